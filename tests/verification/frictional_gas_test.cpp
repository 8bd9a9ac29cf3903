// A gas of rough grains, with a tangential dashpot: what a collision leaves of the spins does not depend on the step.
// Thousands of impacts in all directions show a bias of the return map that single ones hide.
#include <gtest/gtest.h>

#include <cmath>

#include "ladder.hpp"

namespace talus::verification {
namespace {

struct Energies {
  double translation = 0, rotation = 0;  ///< over those at the start
};

/// 12^3 grains of e = 0.8 and mu = 0.3 that spin as fast as they fly, about five collisions each.
Energies cool(bool hertz, double steps) {
  const int per_axis = 12, n = per_axis * per_axis * per_axis;
  const double phi = 0.12, r = 0.5, contact = 0.01, dt = contact / steps;
  const double length = std::cbrt(n * k_pi / 6 / phi), pitch = length / per_axis;
  Scene s = open_scene({0, 0, 0}, {length, length, length}, dt);
  for (auto& axis : s.domain.boundary) axis = {Boundary::periodic, Boundary::periodic};
  s.materials[0].density = density_of(1, r);
  if (hertz) {
    // t_c = 0.01 at v = 1: 2.9433 depth / v
    const double depth = contact / 2.9433, k = 1.25 * 0.5 / std::pow(depth, 2.5);
    s.materials[0].poisson = 0.25;
    s.materials[0].young = 1.5 * k / std::sqrt(0.25) * (1 - 0.0625);
    hertz_law(s, 0.8, 0.3);
  } else {
    const double kn = 0.5 * std::pow(k_pi / contact, 2);
    linear_restitution(s, kn, 0.8, 2.0 / 7.0 * kn, 0.3);
    s.contact.tangential_damping = damping_ratio(0.8) * k_pi / contact;  // half the normal rate
  }
  s.contact.friction = true;
  std::vector<Grain> grains;
  for (int k = 0; k < n; ++k) {
    const auto q = static_cast<std::uint64_t>(6 * k);
    const Vec3 x{pitch * (k % per_axis + 0.5), pitch * (k / per_axis % per_axis + 0.5),
                 pitch * (k / per_axis / per_axis + 0.5)};
    const auto g = [&](std::uint64_t draw) { return gauss(3, q + draw); };
    grains.push_back({x, {g(0), g(1), g(2)}, r, {3 * g(3), 3 * g(4), 3 * g(5)}});
  }
  add_grains(s, grains);
  Simulation sim(s, options());
  const auto energies = [&] {
    const Frame f = sim.frame();
    Energies e;
    for (std::size_t k = 0; k < f.v.size(); ++k) {
      e.translation += 0.5 * norm2(f.v[k]);
      e.rotation += 0.5 * 0.4 * r * r * norm2(f.w[k]);
    }
    return e;
  };
  const Energies before = energies();
  sim.run(std::llround(2 / dt));
  const Energies after = energies();
  return {after.translation / before.translation, after.rotation / before.rotation};
}

TEST(FrictionalGas, SpinsAndSpeedsDoNotDependOnTheStep) {
  // Paths diverge after a few collisions: runs are independent samples, energies of 1728 grains within about 2 %.
  for (const bool hertz : {false, true}) {
    const Energies fine = cool(hertz, 200);
    const std::string law = hertz ? "frictional gas, Hertz" : "frictional gas, linear";
    figure(law + ", N = 200: rotational energy / start", fine.rotation,
           "translational " + std::to_string(fine.translation));
    EXPECT_LT(fine.rotation, 0.8);  // there have been enough collisions to tell
    for (const double steps : {20.0, 50.0}) {
      const Energies e = cool(hertz, steps);
      figure(law + ", N = " + std::to_string(static_cast<int>(steps)) + ": rotational energy / that at N = 200",
             e.rotation / fine.rotation, "translational " + std::to_string(e.translation / fine.translation));
      EXPECT_NEAR(e.rotation / fine.rotation, 1, 0.05);
      EXPECT_NEAR(e.translation / fine.translation, 1, 0.05);
    }
  }
}

}  // namespace
}  // namespace talus::verification
