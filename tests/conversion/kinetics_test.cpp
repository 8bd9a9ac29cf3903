// Reactions of one grain: closed forms at constant temperature, order of the step, stiff rates, balances, presets.
#include <algorithm>

#include "core/base/error.hpp"
#include "tests/conversion/grain_support.hpp"

namespace talus::conversion {
namespace {
using namespace test;

/// A grain whose temperature stays: infinite heat capacity.
Matter isothermal(const std::string& scheme) {
  Matter m = inert(600, 1e12, 0.2);
  m.solids.clear();
  add_scheme(m, scheme);
  m.solids[0].initial = 1;
  return m;
}

Grain<double>& held(Grain<double>& g, double T, double dt, int steps) {
  run(g, gas_at(T, 0), dt, steps);
  return g;
}

TEST(Kinetics, ParallelReactionsShareTheWoodByTheirRates) {
  for (const std::string& scheme : scheme_names()) {
    if (scheme == "debiagi" || scheme == "sadhukhan" || scheme == "liden") continue;
    Matter m = isothermal(scheme);
    const double T = 700;
    double k[3];
    for (int r = 0; r < 3; ++r) k[r] = m.reactions[r].A * std::exp(-m.reactions[r].E / (k_gas_constant * T));
    const double K = k[0] + k[1] + k[2], t = 2 / K;
    std::erase_if(m.reactions, [](const Reaction& r) { return r.of_gas; });
    Grain<double> g(checked(m), {heat::Shape::sphere, 0.01, 1, 3}, T, {});
    const auto total = held(g, T, t / 7, 7).totals();
    EXPECT_NEAR(total.fuel / g.at_start().mass, std::exp(-2.0), 1e-12) << scheme;
    EXPECT_NEAR(total.char_ / g.at_start().mass, k[2] / K * (1 - std::exp(-2.0)), 1e-12) << scheme;
    EXPECT_NEAR(g.state.released[m.gas("tar")] / g.at_start().mass, k[1] / K * (1 - std::exp(-2.0)), 1e-12) << scheme;
  }
}

TEST(Kinetics, ThereAreNinePresetsAndTheyBalance) {
  EXPECT_EQ(scheme_names().size(), 9u);
  for (const std::string& scheme : scheme_names()) EXPECT_NO_THROW(checked(isothermal(scheme))) << scheme;
  EXPECT_THROW(isothermal("cham"), Error);
}

/// a -> b -> c with rates k1, k2 at every temperature.
Matter chain(double k1, double k2) {
  Matter m = inert(600, 1e12, 0.2);
  m.solids = {{"c", Kind::char_, 0, {}}, {"b", Kind::fuel, 0, {}}, {"a", Kind::fuel, 1, {}}};
  m.gases = {{"gas", {}}};
  m.reactions = {{"first", 2, false, k1, 0, 0, 0, {{1, 1}}, {}},
                 {"second", 1, false, k2, 0, 0, 0, {{0, 0.4}}, {{0, 0.6}}}};
  return m;
}

TEST(Kinetics, ConsecutiveReactionsAreOfSecondOrder) {
  const double k1 = 1, k2 = 3, t = 1;
  const double b = k1 / (k2 - k1) * (std::exp(-k1 * t) - std::exp(-k2 * t));
  double errors[3];
  for (int k = 0; k < 3; ++k) {
    const Matter m = checked(chain(k1, k2));
    Grain<double> g(m, {heat::Shape::sphere, 0.01, 1, 2}, 600, {});
    held(g, 600, t / (10 << k), 10 << k);
    const std::size_t at = m.solid("b");
    errors[k] = std::fabs((g.state.m(at, 0) + g.state.m(at, 1)) / g.at_start().mass - b);
    EXPECT_LT(std::fabs(g.mass_residual()), 1e-14 * g.at_start().mass * 100);
  }
  std::printf("consecutive reactions: errors %.2e %.2e %.2e, orders %.2f %.2f\n", errors[0], errors[1], errors[2],
              order(errors[0], errors[1]), order(errors[1], errors[2]));
  EXPECT_GT(order(errors[1], errors[2]), 1.9);
  EXPECT_LT(errors[2], 1e-4);
}

TEST(Kinetics, RateOf1e10PerSecondKeepsMassesPositiveAndBalanced) {
  for (const Method method : {Method::euler, Method::tr_bdf2}) {
    const Matter m = checked(chain(1e10, 1e10));
    Grain<double> g(m, {heat::Shape::sphere, 0.01, 1, 5}, 600, {method, 3, false});
    held(g, 600, 10, 3);
    for (const double x : g.state.mass) EXPECT_GE(x, 0);
    EXPECT_NEAR(g.totals().char_, 0.4 * g.at_start().mass, 1e-9 * g.at_start().mass);
    EXPECT_LT(std::fabs(g.mass_residual()), 1e-13 * g.at_start().mass);
  }
}

TEST(Kinetics, StiffHeatOfReactionStaysWithinItsAdiabaticRange) {
  // released at once: 300 + 1e6 / 1500; taken up: never below where the reaction stops
  for (const double heat : {-1e6, 1e6}) {
    Matter m = chain(1e13, 1e13);
    for (auto& c : m.heat_capacity) c = Property::constant(1500);
    m.reactions[0].E = m.reactions[1].E = 1e5;
    m.reactions[0].heat = heat;
    Grain<double> g(checked(m), {heat::Shape::sphere, 0.01, 1, 10}, 600, {Method::tr_bdf2, 4, false});
    const auto s = gas_at(2000, 200);
    g.begin(s);
    for (int n = 0; n < 300; ++n) {
      g.advance(0.2, s, s, {});
      for (const double T : g.state.temperature) {
        ASSERT_GE(T, 300) << heat;
        ASSERT_LE(T, 2000 + 1e6 / 1500 * 2.5 + 10) << heat;
      }
      for (const double x : g.state.mass) ASSERT_GE(x, 0);
    }
    EXPECT_LT(std::fabs(g.heat_residual()), 1e-11 * (std::fabs(g.state.heat_in) + std::fabs(g.state.heat_of_reaction)));
  }
}

TEST(Kinetics, TarCracksByItsTimeInTheShells) {
  Matter m = isothermal("di_blasi");
  m.porosity = 0.6;
  Grain<double> whole(checked(m), {heat::Shape::sphere, 0.01, 1, 20}, 900, {});
  std::erase_if(m.reactions, [](const Reaction& r) { return r.of_gas; });
  Grain<double> none(checked(m), {heat::Shape::sphere, 0.01, 1, 20}, 900, {});
  held(whole, 900, 0.5, 100);
  held(none, 900, 0.5, 100);
  const std::size_t tar = whole.matter().gas("tar");
  EXPECT_LT(whole.state.released[tar], none.state.released[tar]);
  EXPECT_GT(whole.totals().char_, none.totals().char_);
  EXPECT_LT(std::fabs(whole.mass_residual()), 1e-12 * whole.at_start().mass);
}

TEST(Matter, LoopsAndUnbalancedReactionsAreRefused) {
  Matter loop = chain(1, 1);
  loop.reactions[1].solids = {{2, 0.4}};
  EXPECT_THROW(check_matter(loop), Error);
  Matter off = chain(1, 1);
  off.reactions[1].gases[0].mass = 0.5;
  EXPECT_THROW(check_matter(off), Error);
  Matter elements = chain(1, 1);
  elements.gases[0].composition = Composition{0, 1, 0, 0, 0};
  for (Solid& s : elements.solids) s.composition = Composition{1, 0, 0, 0, 0};
  EXPECT_THROW(check_matter(elements), Error);
}

// ---- char with gas from outside: shrinking core ----

/// A grain of char and little ash that keeps its temperature.
Matter char_grain(double A, double burn_off) {
  Matter m = inert(200, 1e12, 0.2);
  m.solids = {{"char", Kind::char_, 0.99, {}}, {"ash", Kind::ash, 0.01, {}}};
  m.char_reactions = {{CharReaction::Oxidant::carbon_dioxide, A, 0, 0, 0, 0}};
  m.shrinkage.burn_off = burn_off;
  return m;
}

/// Time until `share` of the char has gone.
double burn(const Matter& m, double film, double c, double share, std::size_t shells, double dt, double R = 0.005) {
  Grain<double> g(checked(m), {heat::Shape::sphere, R, 1, shells}, 1200, {Method::euler, 2, false});
  GasAround<double> gas;
  gas.film = film;
  gas.carbon_dioxide = c;
  const auto s = gas_at(1200, 0);
  g.begin(s);
  double before = 1;
  for (int n = 1; n < 200000; ++n) {
    g.advance(dt, s, s, gas);
    const double left = g.totals().char_ / g.at_start().char_;
    if (left <= 1 - share) return dt * (n - 1 + (before - (1 - share)) / (before - left));
    before = left;
  }
  return 0;
}

constexpr double k_need = 0.044009 / 0.012011;  // kg CO2 per kg of carbon

TEST(Char, FilmControlBurnsInProportionToTime) {
  // constant radius: t = X tau, tau = rho R need / (3 film c)
  Matter m = char_grain(1e6, 0);
  m.tortuosity_factor = 1e6;  // no resistance of pores
  const double tau = 198 * 0.005 * k_need / (3 * 0.1 * 0.2);
  for (const double X : {0.25, 0.5, 0.75}) EXPECT_NEAR(burn(m, 0.1, 0.2, X, 20, tau / 2000), X * tau, 0.02 * tau) << X;
}

TEST(Char, KineticControlFollowsTheShrinkingCore) {
  Matter m = char_grain(0.01, 0);
  m.tortuosity_factor = 1e6;
  const double tau = 198 * 0.005 * k_need / (0.01 * 0.2);
  for (const double X : {0.25, 0.5, 0.75})
    EXPECT_NEAR(burn(m, 1e6, 0.2, X, 40, tau / 2000), (1 - std::cbrt(1 - X)) * tau, 0.03 * tau) << X;
}

TEST(Char, AshControlFollowsTheShrinkingCore) {
  Matter m = char_grain(1e6, 0);
  m.porosity = 0.5;
  m.tortuosity_factor = 0.5;
  const double D = 0.25 * 2.07e-5 * std::pow(1200.0 / 298, 1.75);
  const double tau = 198 * 0.005 * 0.005 * k_need / (6 * D * 0.2);
  for (const double X : {0.25, 0.5, 0.75}) {
    const double wanted = (1 - 3 * std::pow(1 - X, 2.0 / 3) + 2 * (1 - X)) * tau;
    EXPECT_NEAR(burn(m, 1e6, 0.2, X, 40, tau / 2000), wanted, 0.04 * tau) << X;
  }
}

TEST(Char, BurntGrainShrinksAndItsGasesBalance) {
  Matter m = char_grain(1, 0.95);
  m.char_reactions[0] = {CharReaction::Oxidant::oxygen, 1.715, 1, 74830, 4.3, 28186};
  for (auto& c : m.heat_capacity) c = Property::constant(1200);
  Grain<double> g(checked(m), {heat::Shape::sphere, 0.005, 1, 20}, 1200, {});
  GasAround<double> gas;
  gas.film = 0.1;
  gas.oxygen = 0.07;
  const auto s = gas_at(1200, 100);
  g.begin(s);
  for (int n = 0; n < 6000; ++n) g.advance(0.05, s, s, gas);
  const auto t = g.totals();
  EXPECT_LT(t.char_, 0.02 * g.at_start().char_);
  EXPECT_LT(g.state.shells.radius(), 0.45 * 0.005);
  EXPECT_GT(g.state.oxygen_taken, 1.33 * (g.at_start().char_ - t.char_));
  EXPECT_LT(g.state.oxygen_taken, 2.67 * (g.at_start().char_ - t.char_));
  EXPECT_LT(std::fabs(g.mass_residual()), 1e-3 * g.at_start().mass);  // molar masses of the products have 4 digits
  for (std::size_t e = 0; e < k_elements; ++e) EXPECT_LT(std::fabs(g.element_residual(e)), 1e-12 * g.at_start().mass);
  EXPECT_LT(std::fabs(g.heat_residual()), 1e-11 * std::fabs(g.state.heat_of_reaction));
}

}  // namespace
}  // namespace talus::conversion
