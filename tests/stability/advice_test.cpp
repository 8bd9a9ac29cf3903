// What `talus check` advises, put to the test: softened contacts overlap by what was promised, advised steps are
// stable, and walls that outrun the particles are refused.
#include <cmath>

#include "core/rules/timestep.hpp"
#include "tests/stability/stability_support.hpp"

namespace talus::stability {
namespace {

TEST(Advice, SoftenedContactsOverlapByOnePercentInTheImpactItIsMeantFor) {
  const double r = 0.01, v = 2;
  for (const bool hertz : {false, true}) {
    Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, 1e-6);
    s.materials[0].young = 1e9;
    s.materials[0].poisson = 0.3;
    if (hertz)
      hertz_law(s, 1, 0);
    else
      linear_restitution(s, 1e6, 1);
    s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
    add_grains(s, {{{0, 0, 1.001 * r}, {0, 0, -v}, r}});
    const Softening a = softening(s, r, v);
    EXPECT_TRUE(a.by_impact);
    const auto deepest = [&](double factor) {
      Scene t = s;
      t.contact.normal_stiffness *= factor;
      t.materials[0].young *= factor;
      Simulation sim(t, options());
      double lowest = r;
      for (int k = 0; k < 4000; ++k) {
        sim.run(1);
        lowest = std::min(lowest, sim.frame().x[0].z);
      }
      return (r - lowest) / r;
    };
    EXPECT_NEAR(deepest(1) / a.overlap, 1, 0.01) << hertz;
    EXPECT_NEAR(deepest(a.factor), 0.01, 1e-4) << hertz;
    Scene t = s;
    t.contact.normal_stiffness *= a.factor;
    t.materials[0].young *= a.factor;
    EXPECT_NEAR(time_step_limits(t, r, r, v).contact.seconds / time_step_limits(s, r, r, v).contact.seconds,
                a.step_factor, 1e-6 * a.step_factor)
        << hertz;
  }
}

TEST(Advice, WeightOfAColumnDecidesWhereNothingMoves) {
  // one column of H / 2r grains weighs pi/6 rho g H d^2; the estimate takes 0.6 for what chains of contacts concentrate
  const double r = 0.01, k = 1e4;
  Scene s = open_scene({0, 0, 0}, {1, 1, 2}, 1e-6);
  linear_law(s, k, 0);
  s.gravity = {0, 0, -9.81};
  add_grains(s, {{{0.5, 0.5, 0.5}, {}, r}});
  const Softening a = softening(s, r);
  const double column = 2 / (2 * r) * sphere_mass(2500, r) * 9.81;
  EXPECT_NEAR(a.load / column, 0.6 / (k_pi / 6), 1e-9);
  s.gravity = {};
  EXPECT_EQ(softening(s, r).factor, 0);
}

/// Growth of the kinetic energy in 4000 steps of a squeezed fcc crystal of equal spheres, periodic, with friction and a
/// little noise, at the end and at its largest; infinite where the run stops.
struct Growth {
  double last = 0, peak = 0;
};
Growth growth(Dashpot dashpot, double e, double share_of_limit, double& limit) {
  const double r = 0.01, kn = 1e5, edge = 2 * r * std::sqrt(2.0) * (1 - 1e-3);
  const int n = 4;
  Scene s = open_scene({0, 0, 0}, {n * edge, n * edge, n * edge}, 1e-9);
  for (auto& axis : s.domain.boundary) axis = {Boundary::periodic, Boundary::periodic};
  linear_restitution(s, kn, e, 2.0 / 7.0 * kn, 10);
  s.contact.dashpot = dashpot;
  std::vector<Grain> grains;
  for (int k = 0; k < n * n * n; ++k)
    for (int q = 0; q < 4; ++q) {
      const Vec3 cell{k % n + 0.25, k / n % n + 0.25, k / n / n + 0.25};
      const Vec3 x = edge * (cell + 0.5 * Vec3{double(q == 1 || q == 2), double(q == 1 || q == 3), double(q > 1)});
      const auto u = [&](int c) { return 1e-3 * (uniform(5, static_cast<std::uint64_t>(64 * k + 16 * q + c)) - 0.5); };
      grains.push_back({x, {u(0), u(1), u(2)}, r});
    }
  s.allow_initial_overlap = s.allow_unstable_step = true;
  limit = time_step_limits(s, r, r).packing.seconds;
  s.dt = share_of_limit * limit;
  add_grains(s, grains);
  Simulation sim(s, options());
  sim.run(1);
  const double start = sim.kinetic_energy();
  Growth g;
  try {
    for (int n = 0; n < 40; ++n) {
      sim.run(100);
      g.last = sim.kinetic_energy() / start;
      g.peak = std::max(g.peak, g.last);
    }
  } catch (const Error&) {
    g.last = g.peak = INFINITY;
  }
  return g;
}

TEST(Advice, PackingLimitIsStableWithEveryDashpotAndNotMuchTooCareful) {
  for (const Dashpot dashpot : {Dashpot::centred, Dashpot::pairwise, Dashpot::lagged})
    for (const double e : {0.1, 0.5, 0.9}) {
      double limit = 0;
      const std::string name = "dashpot " + std::to_string(static_cast<int>(dashpot)) + ", e " + sci(e);
      EXPECT_LT(growth(dashpot, e, 1.0, limit).last, 1) << name << ": at the limit " << limit;
      figure("fcc, " + name + ": packing limit / contact time of a pair",
             limit / (k_pi / std::sqrt(1e5 / (0.5 * sphere_mass(2500, 0.01)))));
      EXPECT_GT(growth(dashpot, e, 1.1, limit).peak, 1e3) << name << ": the control";
    }
}

TEST(Advice, WallsThatOutrunTheParticlesAreRefusedOrWarnedOf) {
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, 1e-5);
  linear_law(s, 5e3, 0);
  add_grains(s, {{{0, 0, 0.5}, {}, 0.001}});
  s.walls = {plane("shaker", {0, 0, 0}, {0, 0, 1})};
  s.walls[0].motion.frequency = 50;
  s.walls[0].motion.amplitude = {0, 0, 0.2};  // 63 m/s: 0.63 radii per step
  EXPECT_NE(time_step_limits(s, 0.001, 0.001).warning.find("wall 'shaker' moves 0.628"), std::string::npos)
      << time_step_limits(s, 0.001, 0.001).warning;
  s.walls[0].motion.amplitude = {0, 0, 0.4};
  const std::string text = refusal([&] { time_step_limits(s, 0.001, 0.001); });
  EXPECT_NE(text.find("pass particles or walls unseen"), std::string::npos) << text;
  s.walls[0].motion.amplitude = {0, 0, 0.0002};
  EXPECT_EQ(time_step_limits(s, 0.001, 0.001).warning, "");
}

/// A pack of 60 grains of 8 to 12 mm that falls into a box by a few of its radii, at `share` of its packing limit.
struct Bed {
  double peak = 0;  ///< largest mechanical energy / that of the start
  double last = 0;  ///< kinetic energy at the end / energy of the fall
  std::string end;  ///< why the run stopped
};
Bed bed(bool hertz, double e, double mu, Dashpot dashpot, double share, std::int64_t steps) {
  const double side = 0.04, height = 0.1;
  Scene s = open_scene({0, 0, 0}, {side, side, height}, 1e-9);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  s.gravity = {0, 0, -9.81};
  s.materials[0].young = 5e6;
  s.materials[0].poisson = 0.3;
  if (hertz)
    hertz_law(s, e, mu);
  else
    linear_restitution(s, 1e4, e, mu > 0 ? 2.0 / 7.0 * 1e4 : 0, mu);
  s.contact.dashpot = dashpot;
  s.output.energies = true;
  Source q;
  q.kind = Source::Kind::random;
  q.name = "pack";
  q.region = {{0, 0, 0.02}, {side, side, height}};
  q.size.kind = SizeDistribution::Kind::uniform;
  q.size.min = 0.008;
  q.size.max = 0.012;
  q.number = 60;
  s.sources = {q};
  s.dt = share * Simulation(s, options()).time_step().packing.seconds;
  s.allow_unstable_step = share > 1;
  Simulation sim(s, options());
  Bed b;
  double start = 0;
  const double fall = sphere_mass(2500, 0.005) * 60 * 9.81 * 0.05;
  try {
    for (std::int64_t n = 1; n <= steps; n += 200) {
      sim.run(n == 1 ? 1 : 200);
      const Energies g = sim.energies();
      const double all = g.kinetic_translation + g.kinetic_rotation + g.potential + g.elastic;
      if (n == 1) start = all;
      b.peak = std::max(b.peak, all / start);
      b.last = (g.kinetic_translation + g.kinetic_rotation) / fall;
    }
  } catch (const Error& error) {
    b.end = error.what();
  }
  return b;
}

TEST(Advice, BedsKeepTheirEnergyBoundedJustBelowThePackingLimit) {
  for (const bool hertz : {false, true})
    for (const double mu : {0.0, 0.5})
      for (const double e : {0.1, 0.3, 0.5, 0.8, 1.0}) {
        // without friction the dashpots alone decide, within few steps
        const std::int64_t steps = full() || mu > 0 || e == 1 ? 100000 : 20000;
        const Bed b = bed(hertz, e, mu, Dashpot::centred, 0.95, steps);
        const std::string name =
            std::string(hertz ? "Hertz" : "linear") + (mu > 0 ? ", friction" : "") + ", e " + sci(e);
        figure("bed at 0.95 of the packing limit, " + name + ": largest energy / start", b.peak);
        figure("bed at 0.95 of the packing limit, " + name + ": kinetic energy at the end / fall", b.last);
        EXPECT_EQ(b.end, "") << name;
        EXPECT_LT(b.peak, e < 1 ? 1.001 : 1.05) << name;
        if (e < 1) {
          EXPECT_LT(b.last, 3e-3) << name;
        }
      }
}

}  // namespace
}  // namespace talus::stability
