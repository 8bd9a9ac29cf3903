// Heat steps whose length follows from a wanted error: against closed forms the error stays below what is wanted and
// follows it, the steps lengthen and shorten as the temperatures let them.
//
// Explicit steps of length h at rates r = dT/dt leave h^2/2 |dr/dt| each; where r falls as exp(-t/tau) that is
// (h r / 2) h/tau, and what has gathered is forgotten as fast, so that the error goes to h r / 2: the quantity that is
// kept below the wanted error e. Doubling needs 0.8 e to be left, so that steps use between 0.4 e and e.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_R = 5e-3, k_rho = 2700, k_c = 900, k_k = 200, k_film = 50;
constexpr double k_poor = 0.2;  // contacts that may come do not limit the step
const double k_mc = sphere_mass(k_rho, k_R) * k_c, k_tau = k_rho * k_c * k_R / (3 * k_film);

std::vector<double> temperatures(const Simulation& sim) {
  for (const ExtraColumn& c : sim.frame().extra)
    if (c.name == "temperature") return c.values;
  ADD_FAILURE() << "no temperatures";
  return {};
}

/// Fixed grains in a row that overlap by `overlap`, the first of 400 K and the others of 300 K.
Scene row_of(int n, double overlap, double dt, double error, std::int64_t most, double conductivity = k_k) {
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  s.materials[0].density = k_rho;
  s.allow_unstable_step = s.allow_initial_overlap = true;
  linear_law(s, 1, 0);
  s.heat.on = true;
  s.heat.every = 1;
  s.heat.error = error;
  s.heat.every_most = most;
  s.heat.temperature = 300;
  MatterHeat m;
  m.capacity = Curve::constant(k_c);
  m.conductivity = Curve::constant(conductivity);
  s.heat.matter = {m};
  for (int k = 0; k < n; ++k) {
    Grain g;
    g.x = {(2 * k_R - overlap) * k, 0, 0};
    g.r = k_R;
    g.fixed = true;
    add_grains(s, {g});
    s.heat.sources.push_back({k == 0 ? 400.0 : 300.0, false});
  }
  return s;
}

struct Followed {
  double error = 0;                              ///< largest [K]
  std::int64_t shortest = 1 << 30, longest = 0;  ///< heat steps, in steps
};
/// Largest error at ends of heat steps against exact(t, k).
template <class F>
Followed follow(const Scene& s, std::int64_t steps, F exact) {
  Simulation sim(s, options());
  Followed f;
  for (std::int64_t done = 0; done < steps;) {
    const auto M = static_cast<std::int64_t>(value_of(sim, "heat.steps"));
    f.shortest = std::min(f.shortest, M), f.longest = std::max(f.longest, M);
    sim.run(M), done += M;
    const std::vector<double> T = temperatures(sim);
    for (std::size_t k = 0; k < T.size(); ++k)
      f.error = std::max(f.error, std::fabs(T[k] - exact(static_cast<double>(done) * s.dt, k)));
  }
  EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-12 * value_of(sim, "heat.total"));
  return f;
}

TEST(HeatPace, ErrorOfAGrainInGasFollowsTheWantedOneOverTwoOrders) {
  for (const double wanted : {3.0, 0.3, 0.03}) {
    Scene s = row_of(1, 0, k_tau / 2e4, wanted, 1 << 20, k_poor);
    s.heat.gas.on = true;
    s.heat.gas.film = k_film;
    s.heat.gas.temperature = TimeTable::constant(900);
    const Followed f = follow(s, 100000, [](double t, std::size_t) { return 900 - 500 * std::exp(-t / k_tau); });
    figure("heat.error", f.error / wanted, "of the wanted " + std::to_string(wanted) + " K");
    EXPECT_LT(f.error, wanted);
    EXPECT_GT(f.error, 0.4 * wanted) << "no shorter steps than needed";
    EXPECT_GE(f.longest, 16 * f.shortest);
  }
}

TEST(HeatPace, ErrorOfAChainStaysBelowTheWantedOneInAllItsModes) {
  constexpr int k_n = 10;
  const double a = 1.5e-4, overlap = a * a / (k_R / 2), rate = 2 * k_k * a / k_mc;
  const auto exact = [&](double t, std::size_t k) {
    double T = 300 + 100.0 / k_n;
    for (int m = 1; m < k_n; ++m) {
      const double q = std::numbers::pi * m / k_n, s = std::sin(0.5 * q);
      T += 200.0 / k_n * std::cos(0.5 * q) * std::cos(q * (static_cast<double>(k) + 0.5)) *
           std::exp(-4 * rate * s * s * t);
    }
    return T;
  };
  double last = 0;
  for (const double wanted : {0.5, 0.05}) {
    const Followed f = follow(row_of(k_n, overlap, 2e-4 / rate, wanted, 1 << 20), 50000, exact);
    figure("heat.error of a chain", f.error / wanted, "of the wanted " + std::to_string(wanted) + " K");
    EXPECT_LT(f.error, wanted);
    if (last > 0) {
      EXPECT_LT(f.error, 0.2 * last) << "ten times less wanted";
    }
    last = f.error;
  }
}

TEST(HeatPace, AJumpOfTheGasIsSeenBeforeItComes) {
  const double wanted = 1, dt = k_tau / 2e4, jump = 40000 * dt;
  Scene s = row_of(1, 0, dt, wanted, 2048, k_poor);
  s.heat.gas.on = true;
  s.heat.gas.film = k_film;
  s.heat.gas.temperature = {{0, jump, jump + 1e-9 * dt}, {400, 400, 900}};
  const Followed f = follow(
      s, 80000, [&](double t, std::size_t) { return t <= jump ? 400 : 900 - 500 * std::exp(-(t - jump) / k_tau); });
  EXPECT_LT(f.error, wanted);
  EXPECT_EQ(f.longest, 2048) << "nothing happens before";
  EXPECT_LE(f.shortest, 64) << "h < 2 e / r";
}

}  // namespace
}  // namespace talus::physics
