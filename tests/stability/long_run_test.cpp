// Scenarios 18 to 23: gases, long runs, far from the origin, moving frames, precision.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "tests/stability/stability_support.hpp"

namespace talus::stability {
namespace {

/// Frictionless gas of unit-mass spheres of diameter 1 at solid fraction phi in a periodic cube; speeds about `speed`.
Scene gas(int per_axis, double phi, double restitution, double speed, double dt_per_contact) {
  const double pitch = std::cbrt(k_pi / 6 / phi), side = per_axis * pitch;
  Scene s = open_scene({0, 0, 0}, {side, side, side}, dt_per_contact);
  for (auto& axis : s.domain.boundary) axis = {Boundary::periodic, Boundary::periodic};
  s.materials[0].density = 6 / k_pi;
  linear_restitution(s, 0.5 * k_pi * k_pi, restitution);  // contact time 1 for m_eff = 1/2
  std::vector<Grain> grains;
  for (int k = 0; k < per_axis * per_axis * per_axis; ++k) {
    const auto q = [k](int c) { return uniform(17, static_cast<std::uint64_t>(8 * k + c)) - 0.5; };
    const double play = 0.9 * (pitch - 1);
    const Vec3 x{pitch * (k % per_axis + 0.5) + play * q(0), pitch * (k / per_axis % per_axis + 0.5) + play * q(1),
                 pitch * (k / per_axis / per_axis + 0.5) + play * q(2)};
    grains.push_back({x, {speed * 2 * q(3), speed * 2 * q(4), speed * 2 * q(5)}, 0.5});
  }
  add_grains(s, grains);
  return s;
}

TEST(Stability, S18_ElasticGasKeepsItsEnergyAndBecomesMaxwellian) {
  // Contacts last 1 s = 600 steps: the energy error within a contact falls with the square of that. The mean free time
  // at phi 0.25 and this speed is about 17 s.
  const int n = full() ? 10 : 7, blocks = full() ? 400 : 40;
  Scene s = gas(n, 0.25, 1, 0.02, 0.0016);
  s.output.energies = true;
  Simulation sim(s, options());
  const Frame begin = sim.frame();
  sim.run(1);
  const auto energy = [&] {
    const Energies e = sim.energies();
    return e.kinetic_translation + e.elastic;
  };
  const double start = energy();
  double worst = 0, sum2 = 0;
  std::vector<double> components;
  for (int k = 0; k < blocks; ++k) {
    sim.run(3750);
    worst = std::max(worst, std::fabs(energy() / start - 1));
    if (k >= blocks / 2 && k % 10 == 0)
      for (const Vec3& v : sim.frame().v)
        for (int q = 0; q < 3; ++q) components.push_back(v[q]);
  }
  for (const double v : components) sum2 += v * v;
  const double sigma = std::sqrt(sum2 / static_cast<double>(components.size()));
  // ten classes of equal probability of the normal law; 9 degrees of freedom less one for sigma
  const std::array<double, 9> edges = {-1.2816, -0.8416, -0.5244, -0.2533, 0, 0.2533, 0.5244, 0.8416, 1.2816};
  std::array<double, 10> count{};
  for (const double v : components)
    ++count[static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), v / sigma) - edges.begin())];
  double chi2 = 0;
  const double expected = static_cast<double>(components.size()) / 10;
  for (const double c : count) chi2 += (c - expected) * (c - expected) / expected;
  EXPECT_LT(worst, 1e-6);
  EXPECT_LT(chi2, 26.1);  // 0.1 % of Maxwellian samples are beyond, 8 degrees of freedom
  Vec3 change;
  const Frame end = sim.frame();
  for (std::size_t k = 0; k < end.v.size(); ++k) change = change + (end.v[k] - begin.v[k]);
  EXPECT_LT(norm(change), 1e-11);  // of unit masses; the sum itself rounds to about 1e-14
  row("e = 1: |dE|/E < 1e-6; velocities Maxwellian (chi^2, 8 degrees of freedom, < 26.1)",
      "|dE|/E " + sci(worst) + ", chi^2 " + sci(chi2) + ", momentum change " + sci(norm(change)));
}

TEST(Stability, S19_CoolingGasFollowsHaffsLaw) {
  const int n = full() ? 14 : 9;
  // elastic until Maxwellian would cost as much again: the start is left out of the fit instead
  Scene s = gas(n, 0.1, 0.9, 0.1, 0.02);
  Simulation sim(s, options());
  std::vector<double> time, temperature;
  for (int k = 0; k <= 40; ++k) {
    Vec3 mean;
    const Frame f = sim.frame();
    for (const Vec3& v : f.v) mean = mean + (1.0 / static_cast<double>(f.v.size())) * v;
    double t = 0;
    for (const Vec3& v : f.v) t += norm2(v - mean) / static_cast<double>(3 * f.v.size());
    time.push_back(sim.time());
    temperature.push_back(t);
    sim.run(2500);
  }
  // T = T0 / (1 + t/tau)^2: 1/sqrt(T) is a straight line, which gives tau; then the slope is fitted
  const std::size_t from = 6;
  double st = 0, sy = 0, stt = 0, sty = 0, count = 0;
  for (std::size_t k = from; k < time.size(); ++k) {
    const double y = 1 / std::sqrt(temperature[k]);
    st += time[k];
    sy += y;
    stt += time[k] * time[k];
    sty += time[k] * y;
    ++count;
  }
  const double slope = (count * sty - st * sy) / (count * stt - st * st), zero = (sy - slope * st) / count;
  std::vector<double> x, y;
  for (std::size_t k = from; k < time.size(); ++k) {
    x.push_back(1 + time[k] * slope / zero);
    y.push_back(temperature[k]);
  }
  const double exponent = log_slope(x, y);
  EXPECT_NEAR(exponent, -2, 0.05);
  EXPECT_GT(temperature[0] / temperature.back(), 5);
  row("e = 0.9: T falls as (1 + t/tau)^-2, exponent within 0.05, before clustering; no collapse",
      "exponent " + fmt_ratio(exponent) + " while T falls by a factor " + sci(temperature[0] / temperature.back()));
}

TEST(Stability, S20_OscillatorHasNoSecularDriftAndTimeIsNTimesDt) {
  const std::int64_t steps = full() ? 10000000 : 600000;
  const double r = 0.01, kn = 1e5, dt = 2.3e-5;
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, dt);
  linear_law(s, kn, 0);
  s.walls = {plane("floor", {0, 0, -0.7 * r}, {0, 0, 1}), plane("lid", {0, 0, 0.7 * r}, {0, 0, -1})};
  s.allow_initial_overlap = true;
  s.output.energies = true;
  add_grains(s, {{{0, 0, 0.02 * r}, {}, r}});
  Simulation sim(s, options());
  sim.run(1);
  const double start = total_energy(sim.energies());
  // bounds over the first and the last tenth: an oscillating error is allowed, a drifting one is not
  const auto range = [&] {
    double low = 1e300, high = -1e300;
    for (int k = 0; k < 1000; ++k) {
      sim.run(1);
      const double e = total_energy(sim.energies());
      low = std::min(low, e);
      high = std::max(high, e);
    }
    return std::pair(low, high);
  };
  const auto first = range();
  sim.run(steps - 2000);
  const auto last = range();
  const double drift = std::max(std::fabs(last.first - first.first), std::fabs(last.second - first.second)) / start;
  EXPECT_LT(drift, 1e-9);
  EXPECT_EQ(sim.time(), static_cast<double>(sim.step()) * dt);
  row("energy bounded without drift over " + std::to_string(steps) + " steps; time = n dt to the bit",
      "drift of the bounds " + sci(drift) + " E0, clock error " +
          sci(sim.time() - static_cast<double>(sim.step()) * dt));
}

/// Frictional grains tumbling in a box with walls at `offset`.
Scene tumble(Vec3 offset, double dt = 1e-5) {
  Scene s = open_scene(offset, offset + Vec3{0.0625, 0.0625, 0.0625}, dt);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  linear_restitution(s, 1e4, 0.8, 2857, 0.4);
  s.gravity = {0, 0, -9.81};
  std::vector<Grain> grains;
  for (int k = 0; k < 64; ++k) {
    // coordinates on a grid of 2^-20 m, so that the shift rounds nothing away
    const auto q = [k](int c) {
      return std::floor(uniform(23, static_cast<std::uint64_t>(8 * k + c)) * 4096) / 1048576;
    };
    const Vec3 x{0.0078125 + 0.015625 * (k % 4) + 0.5 * q(0), 0.0078125 + 0.015625 * (k / 4 % 4) + 0.5 * q(1),
                 0.0078125 + 0.015625 * (k / 16) + 0.5 * q(2)};
    grains.push_back({x + offset, {200 * q(3), -300 * q(4), 100 * q(5)}, 0.00390625});
  }
  add_grains(s, grains);
  return s;
}

TEST(Stability, S21_ShiftFarFromTheOriginKeepsEveryBit) {
  const double r = 0.00390625;
  std::vector<std::uint64_t> hashes;
  for (const double far : {0.0, 1e6, 1e8}) {
    Simulation sim(tumble({far * r, -far * r, 2 * far * r}), options());
    sim.run(3000);
    hashes.push_back(sim.state_hash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
  // a domain wider than 1e6 R itself cannot resolve overlaps as well, and says so
  Scene wide = tumble({0, 0, 0});
  wide.domain.upper.x = 2e6 * r;
  const Simulation sim(wide, options());
  EXPECT_TRUE(!sim.warnings().empty() && sim.warnings()[0].kind == "extent");
  row("scene shifted by 1e6 R and 1e8 R (representable): same hash; domains wider than 1e6 R warn", "1 hash");
}

TEST(Stability, S22_GalileanBoostLeavesRelativeMotion) {
  const auto end = [](double boost, ListPolicy policy, Counters& counters) {
    Scene s = open_scene({0, 0, 0}, {0.0625, 0.0625, 0.0625}, 2e-7);
    for (auto& axis : s.domain.boundary) axis = {Boundary::periodic, Boundary::periodic};
    linear_restitution(s, 1e6, 0.9);
    Scene grains = tumble({0, 0, 0});
    s.sources = grains.sources;
    s.list.policy = policy;
    s.contact.friction = false;
    std::vector<Grain> list;
    const Frame f = Simulation(grains, options()).frame();
    for (std::size_t k = 0; k < f.x.size(); ++k) list.push_back({f.x[k], f.v[k] + Vec3{boost, 0, 0}, f.r[k]});
    s.sources.clear();
    s.list.automatic = false;  // rebuilds are compared
    add_grains(s, list);
    Simulation sim(s, options());
    sim.run(40000);
    counters = sim.counters();
    Frame g = sim.frame();
    const double back = boost * sim.time();
    for (Vec3& x : g.x) x.x -= back;
    return g;
  };
  Counters still{}, moving{}, still_mean{}, moving_mean{};
  const auto local = ListPolicy::local, mean = ListPolicy::mean_subtracted;
  const Frame a = end(0, local, still), b = end(1000, local, moving);
  end(0, mean, still_mean);
  const Frame c = end(1000, mean, moving_mean);
  double worst = 0;
  for (std::size_t k = 0; k < a.x.size(); ++k) {
    double d = std::fabs(a.x[k].x - b.x[k].x);
    d = std::fabs(d - 0.0625 * std::round(d / 0.0625));
    worst = std::max({worst, d, std::fabs(a.x[k].y - b.x[k].y), std::fabs(a.x[k].z - b.x[k].z)});
  }
  // speeds of 1e3 m/s are rounded to 1.1e-13, relative ones of 0.3 to 4e-13, and every collision enlarges that
  EXPECT_LT(worst / 0.0039, 1e-9);
  for (std::size_t k = 0; k < b.x.size(); ++k) {  // exact lists: the policy changes no bit
    EXPECT_EQ(b.x[k].x, c.x[k].x);
    EXPECT_EQ(b.x[k].z, c.x[k].z);
  }
  const auto more = [](const Counters& fast, const Counters& rest) {
    return static_cast<double>(fast.rebuilds_skin + 1) / static_cast<double>(rest.rebuilds_skin + 1);
  };
  EXPECT_LE(more(moving_mean, still_mean), 1.2);
  EXPECT_GE(more(moving, still), 3);  // the control: skins from absolute speeds are used up again and again
  row("boost of 1e3 m/s: relative trajectories equal to 1e-9 R; rebuilds of mean_subtracted lists unchanged",
      "largest difference " + sci(worst / 0.0039) + " R; rebuilds " + std::to_string(still_mean.rebuilds_skin) +
          " -> " + std::to_string(moving_mean.rebuilds_skin) + " (local lists: " + std::to_string(still.rebuilds_skin) +
          " -> " + std::to_string(moving.rebuilds_skin) + ")");
}

TEST(Stability, S23_ExactAgainstFastArithmeticAndTheResolutionOfOverlaps) {
  // fast: fused multiply-add and estimated reciprocals with Newton steps, all in double
  double apart = 0, cost[2] = {0, 0};
  bool runs = true;
  Frame f[2];
  for (const Precision p : {Precision::exact, Precision::fast}) {
    Scene s = tumble({0, 0, 0});
    s.precision = p;
    const auto begin = std::chrono::steady_clock::now();
    runs = runs && refusal([&] {
                     Simulation sim(s, options());
                     sim.run(3000);
                     f[static_cast<int>(p)] = sim.frame();
                   }).empty();
    cost[static_cast<int>(p)] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / (64 * 3000);
  }
  if (!runs) GTEST_SKIP() << pending("exact against fast arithmetic", "this processor has no fast kernels");
  for (std::size_t k = 0; k < f[0].x.size(); ++k) apart = std::max(apart, norm(f[0].x[k] - f[1].x[k]) / 0.00390625);
  EXPECT_GT(apart, 0);  // it is another arithmetic
  EXPECT_LT(apart, 1e-9);
  // An overlap of ten roundings of the coordinate is felt, with the force that the rounding leaves of it.
  double worst = 0;
  for (const double far : {1e2, 1e4, 1e6}) {
    const double r = 0.00390625, x = far * r, overlap = 10 * 2.2e-16 * x, kn = 1e4;
    Scene s = open_scene({0, 0, 0}, {2 * x, 0.0625, 0.0625}, 1e-5);
    linear_law(s, kn, 0);
    s.allow_initial_overlap = true;
    add_grains(s, {{{x, 0.03, 0.03}, {}, r}, {{x + 2 * r - overlap, 0.03, 0.03}, {}, r}});
    const Frame q = Simulation(s, options()).frame({.contacts = true});
    ASSERT_EQ(q.contacts.size(), 1U) << far;
    worst = std::max(worst, std::fabs(norm(q.contacts[0].normal_force) / (kn * overlap) - 1));
  }
  EXPECT_LT(worst, 0.2);  // each coordinate is rounded to half a unit, two of them, of ten
  row("fast against exact arithmetic: 64 tumbling grains differ by < 1e-9 R after 3000 steps; an overlap of 10 eps X "
      "is felt to 20 %",
      "apart " + sci(apart) + " R; " + sci(1e9 * cost[0]) + " and " + sci(1e9 * cost[1]) +
          " ns per grain-step; force error " + sci(worst));
  shortfall("there is no single or mixed precision: positions, forces and history are always double");
}

}  // namespace
}  // namespace talus::stability
