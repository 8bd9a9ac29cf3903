// What `talus check` advises, put to the test: softened contacts overlap by what was promised, advised steps are
// stable, and walls that outrun the particles are refused.
#include <cmath>

#include "core/timestep.hpp"
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

TEST(Advice, WallsThatOutrunTheParticlesAreRefusedOrWarnedOf) {
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, 1e-5);
  linear_law(s, 1e4, 0);
  add_grains(s, {{{0, 0, 0.5}, {}, 0.001}});
  s.walls = {plane("shaker", {0, 0, 0}, {0, 0, 1})};
  s.walls[0].motion.frequency = 50;
  s.walls[0].motion.amplitude = {0, 0, 0.2};  // 63 m/s: 0.63 radii per step
  EXPECT_NE(time_step_limits(s, 0.001, 0.001).warning.find("wall 'shaker' moves by up to 0.628"), std::string::npos)
      << time_step_limits(s, 0.001, 0.001).warning;
  s.walls[0].motion.amplitude = {0, 0, 0.4};
  const std::string text = refusal([&] { time_step_limits(s, 0.001, 0.001); });
  EXPECT_NE(text.find("pass particles unseen"), std::string::npos) << text;
  s.walls[0].motion.amplitude = {0, 0, 0.0002};
  EXPECT_EQ(time_step_limits(s, 0.001, 0.001).warning, "");
}

}  // namespace
}  // namespace talus::stability
