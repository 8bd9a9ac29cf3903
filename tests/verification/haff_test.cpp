// Homogeneous cooling (Haff's law): a dilute gas of inelastic smooth spheres, T(t) = T1/(1 + (t - t1)/tau)^2 with
// 1/tau = (1 - e^2) omega(T1)/6, omega = 4 sqrt(pi) chi n d^2 sqrt(T/m), chi = (2 - phi)/(2 (1 - phi)^3) (Enskog).
// The box is small (11 mean free paths), so that vortices and clusters, which need a longer wave, stay away.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladder.hpp"

namespace talus::verification {
namespace {

struct Cooling {
  double tau = 0;  ///< Enskog's, for the temperature at the start of the record
  double slope = 0, slope_error = 0, tau_ratio = 0, flow = 0, contact_share = 0;
};

/// Gas of per_axis^3 grains, d = m = T = 1, cooled until T has fallen by 1/60.
Cooling cool(int per_axis, double e, std::uint64_t seed) {
  const double phi = 0.05, r = 0.5, contact = 0.02, dt = contact / 20;
  const int n = per_axis * per_axis * per_axis;
  const double length = std::cbrt(n * k_pi / 6 / phi), pitch = length / per_axis;
  Scene s = open_scene({0, 0, 0}, {length, length, length}, dt);
  for (auto& axis : s.domain.boundary) axis = {Boundary::periodic, Boundary::periodic};
  s.materials[0].density = density_of(1, r);
  linear_restitution(s, 0.5 * std::pow(k_pi / contact, 2), e);
  std::vector<Grain> grains;
  Vec3 mean;
  for (int k = 0; k < n; ++k) {
    const auto q = static_cast<std::uint64_t>(3 * k);
    const Vec3 x{pitch * (k % per_axis + 0.5), pitch * (k / per_axis % per_axis + 0.5),
                 pitch * (k / per_axis / per_axis + 0.5)};
    grains.push_back({x, {gauss(seed, q), gauss(seed, q + 1), gauss(seed, q + 2)}, r});
    mean = mean + (1.0 / n) * grains.back().v;
  }
  double square = 0;
  for (Grain& g : grains) {
    g.v = g.v - mean;
    square += norm2(g.v) / (3.0 * n);
  }
  for (Grain& g : grains) g.v = (1 / std::sqrt(square)) * g.v;
  add_grains(s, grains);
  Simulation sim(s, options());
  const auto temperature = [&] { return 2 * sim.kinetic_energy() / (3.0 * n); };
  // forget the lattice: ten collisions of each grain or so
  while (temperature() > 0.5) sim.run(200);
  const double chi = (2 - phi) / (2 * std::pow(1 - phi, 3)), density = n / (length * length * length);
  const double t1 = sim.time(), temperature_1 = temperature();
  Cooling out;
  out.tau = 6 / ((1 - e * e) * 4 * std::sqrt(k_pi) * chi * density * std::sqrt(temperature_1));
  std::vector<double> x, y, time, root;
  double contacts = 0;
  int samples = 0;
  // points evenly spaced in ln(1 + t/tau): each weighs the same
  for (double q = 0.05; temperature() > temperature_1 / 60; q += 0.05) {
    const double until = t1 + out.tau * (std::exp(q) - 1);
    sim.run(std::max<std::int64_t>(1, std::llround(until / dt) - sim.step()));
    contacts += 2.0 * static_cast<double>(sim.counters().contacts) / n;
    samples += 1;
    x.push_back(std::log(1 + (sim.time() - t1) / out.tau));
    y.push_back(std::log(temperature() / temperature_1));
    time.push_back(sim.time() - t1);
    root.push_back(std::sqrt(temperature_1 / temperature()));
  }
  const Line l = fit_line(x, y);
  out.slope = l.slope;
  out.slope_error = l.error;
  out.tau_ratio = 1 / (fit_line(time, root).slope * out.tau);
  out.contact_share = contacts / samples;
  // largest share of the energy in the eight cells' mean motion: n/8 grains share 8/n of it by chance
  const Frame f = sim.frame();
  Vec3 momentum[8];
  double energy = 0;
  for (int k = 0; k < n; ++k) {
    const auto q = static_cast<std::size_t>(k);
    const int cell =
        (f.x[q].x > 0.5 * length ? 1 : 0) + (f.x[q].y > 0.5 * length ? 2 : 0) + (f.x[q].z > 0.5 * length ? 4 : 0);
    momentum[cell] = momentum[cell] + f.v[q];
    energy += norm2(f.v[q]);
  }
  for (const Vec3& p : momentum) out.flow += norm2(p) * 8 / n / energy;
  return out;
}

TEST(Haff, CoolingGasFallsWithTheSquareOfTime) {
  // 1000 grains: kinetic energy of a run scatters by a few percent, its slope over ln(1 + t/tau) from 0 to 2 by 1 %.
  // Soft contacts last 1 ... 2 % of the time between collisions at the start, less later.
  const std::vector<std::uint64_t> seeds =
      full() ? std::vector<std::uint64_t>{1, 2, 3, 4, 5, 6, 7, 8} : std::vector<std::uint64_t>{1};
  for (const double e : {0.9, 0.8}) {
    double slope = 0, tau = 0, flow = 0;
    for (const std::uint64_t seed : seeds) {
      const Cooling c = cool(10, e, seed);
      const std::string name = "Haff, e " + std::to_string(e).substr(0, 3) + ", seed " + std::to_string(seed);
      figure(name + ": slope of ln T over ln(1 + t/tau), Enskog's tau", c.slope,
             "standard error " + std::to_string(c.slope_error));
      figure(name + ": measured tau / Enskog's tau", c.tau_ratio,
             "contacts per grain " + std::to_string(c.contact_share));
      figure(name + ": share of energy in mean motion of octants", c.flow, "0.008 by chance");
      slope += c.slope / static_cast<double>(seeds.size());
      tau += c.tau_ratio / static_cast<double>(seeds.size());
      flow = std::max(flow, c.flow);
    }
    figure("Haff, e " + std::to_string(e).substr(0, 3) + ": mean slope", slope);
    EXPECT_NEAR(slope, -2, 0.05) << e;
    EXPECT_NEAR(tau, 1, 0.08) << e;
    EXPECT_LT(flow, 0.05) << e;
  }
}

}  // namespace
}  // namespace talus::verification
