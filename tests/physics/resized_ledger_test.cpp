// The energy ledger beside changing sizes: it closes as well as without, for every law; the term is that of the closed
// form for a clamped grain; grains that leave while they touch; resumed runs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "physics_support.hpp"
#include "tests/breathing.hpp"

namespace talus::physics {
namespace {

/// A bed that has fallen into a box with a floor, periodic sideways; grains of 5 mm.
Scene bed(double dt) {
  Scene s = open_scene({0, 0, 0}, {0.03, 0.03, 0.1}, dt);
  s.domain.boundary[0] = s.domain.boundary[1] = {Boundary::periodic, Boundary::periodic};
  s.domain.boundary[2] = {Boundary::wall, Boundary::open};
  s.gravity = {1, 0, -9.81};
  s.max_overlap = 1;
  s.output.energies = true;
  std::vector<Grain> grains;
  for (int k = 0; k < 150; ++k) {
    const auto q = [k](int c) { return uniform(7, static_cast<std::uint64_t>(8 * k + c)) - 0.5; };
    grains.push_back({{0.003 + 0.006 * (k % 5), 0.003 + 0.006 * (k / 5 % 5), 0.003 + 0.0058 * (k / 25)},
                      {0.1 * q(0), 0.1 * q(1), 0.1 * q(2)},
                      0.0028 + 0.0002 * q(3)});
  }
  linear_law(s, 2e3, 300, 1000, 150, 0.4);
  add_grains(s, grains);
  return s;
}

struct Balance {
  double residual = 0, sizes = 0;  ///< largest size of each [J]
};

Balance balance(const Scene& s, double growth, double seconds) {
  const auto steps = static_cast<std::int64_t>(std::llround(seconds / s.dt));
  Simulation sim(s, options());
  if (growth != 0) breathe(sim, growth, steps);
  Balance b;
  for (int k = 0; k < 50; ++k) {
    sim.run(steps / 50);
    const Energies e = sim.energies();
    b.residual = std::max(b.residual, std::fabs(e.residual));
    b.sizes = std::max(b.sizes, std::fabs(e.sizes));
  }
  return b;
}

void soft_hertz(Scene& s) {
  s.materials[0].young = 1e6;
  s.materials[0].poisson = 0.3;
  hertz_law(s, 0.7, 0.4);
}

struct Law {
  const char* name;
  std::function<void(Scene&)> set;
};

class ResizedLedger : public ::testing::TestWithParam<Law> {};

TEST_P(ResizedLedger, ClosesAsWellAsWithoutChangingSizes) {
  Scene s = bed(1e-5);
  GetParam().set(s);
  // grown grains are heavier and pressed harder; what is turned over is larger, and so is the residual
  const Balance still = balance(s, 0, 0.2), grown = balance(s, 0.08, 0.2);
  const std::string name = GetParam().name;
  figure("bed, " + name + ": residual without changing sizes [J]", still.residual);
  figure("bed, " + name + ": residual with [J]", grown.residual);
  figure("bed, " + name + ": brought in by sizes [J]", grown.sizes);
  EXPECT_EQ(still.sizes, 0);
  EXPECT_GT(grown.sizes, 50 * still.residual);
  EXPECT_LT(grown.residual, 2.5 * still.residual);
}

TEST_P(ResizedLedger, HoldsTheElasticEnergyOfUnequalGrainsBetweenPlates) {
  // one grows, the other shrinks by less: all that is stored comes with the radii
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 2e-6);
  linear_law(s, 2e3, 300, 1000, 150, 0.4);
  s.output.energies = true;
  s.max_overlap = 1;
  s.allow_initial_overlap = true;
  s.walls = {plane("floor", {0, 0, -0.00399}, {0, 0, 1}), plane("lid", {0, 0, 0.00699}, {0, 0, -1})};
  add_grains(s, {{{0, 0, 0}, {}, 0.004, {0, 0, 20}}, {{0, 0, 0.00549}, {}, 0.0015}});
  GetParam().set(s);
  const Balance b = balance(s, 0.03, 0.02);
  figure("two grains between plates, " + std::string(GetParam().name) + ": residual / brought in",
         b.residual / b.sizes);
  EXPECT_GT(b.sizes, 1e-7);
  EXPECT_LT(b.residual, 2e-4 * b.sizes);
}

INSTANTIATE_TEST_SUITE_P(Laws, ResizedLedger,
                         ::testing::Values(Law{"linear", [](Scene&) {}},
                                           Law{"rolling",
                                               [](Scene& s) {
                                                 s.contact.rolling = Rolling::epsd;
                                                 s.contact.twisting = true;
                                                 s.pairs[0].rolling_friction = s.pairs[0].twisting_friction = 0.2;
                                                 s.pairs[0].rolling_damping = 0.3;
                                               }},
                                           Law{"cohesive",
                                               [](Scene& s) {
                                                 s.contact.cohesion = Cohesion::sjkr;
                                                 s.pairs[0].cohesion_energy = 2e4;
                                               }},
                                           Law{"hertz", [](Scene& s) { soft_hertz(s); }},
                                           Law{"partial_slip",
                                               [](Scene& s) {
                                                 soft_hertz(s);
                                                 s.contact.partial_slip = true;
                                               }},
                                           Law{"jkr",
                                               [](Scene& s) {
                                                 soft_hertz(s);
                                                 s.contact.model = ContactModel::jkr;
                                                 s.pairs[0].work_of_adhesion = 0.02;
                                               }}),
                         [](const auto& p) { return std::string(p.param.name); });

TEST(ResizedLedgerOfAPair, HoldsTheWorkOfTheRadiusAndClosesWithTheSquareOfTheStep) {
  // a grain between two plates grows by 2 %: each plate is pressed in by the same
  const auto residual = [](double dt) {
    Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, dt);
    linear_restitution(s, 1e5, 1);
    s.walls = {plane("floor", {0, 0, -0.005}, {0, 0, 1}), plane("lid", {0, 0, 0.005}, {0, 0, -1})};
    s.output.energies = true;
    s.max_overlap = 1;
    add_grains(s, {{{}, {0, 0, 0.02}, 0.005}});
    Simulation sim(s, options());
    const auto steps = static_cast<std::int64_t>(std::llround(4e-3 / dt));
    breathe(sim, 0.02, steps);
    double worst = 0;
    for (int k = 0; k < 100; ++k) {
      sim.run(steps / 100);
      worst = std::max(worst, std::fabs(sim.energies().residual));
    }
    const Energies e = sim.energies();
    EXPECT_NEAR(e.sizes, 1e5 * 1e-4 * 1e-4, 0.01 * e.sizes);  // the grain, at rest between the plates, does the rest
    figure("grain that grows between plates: largest residual / work of the radius", worst / e.sizes);
    return worst / e.sizes;
  };
  const double coarse = residual(8e-6), fine = residual(4e-6);
  EXPECT_LT(fine, 0.35 * coarse);
  EXPECT_LT(fine, 1e-3);
}

TEST(ResizedLedgerOfAPair, MassThatComesAndGoesTakesItsKineticAndPotentialEnergyAlong) {
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, 1e-4);
  linear_law(s, 1, 0, 1, 0, 0.3);
  s.gravity = {0, 0, -9.81};
  s.output.energies = true;
  add_grains(s, {{{0.1, 0, 0.5}, {1, 0, 2}, 0.005, {0, 50, 10}}, {{-0.1, 0, 0.5}, {0, 1, 0}, 0.005, {80, 0, 0}}});
  Simulation sim(s, options());
  breathe(sim, 0.5, 2000);
  sim.run(2000);
  const Energies e = sim.energies();
  figure("free grains that grow and shrink: residual / brought in", e.residual / e.sizes);
  EXPECT_GT(std::fabs(e.sizes), 1e-3);
  // what is left is the 1/8 dt^2 m g^2 of the leapfrog, of the mass that came
  EXPECT_LT(std::fabs(e.residual), 1e-7 * std::fabs(e.sizes));
}

TEST(ResizedLedgerOfAPair, GrainThatIsUsedUpTakesTheEnergyOfItsContactsAlong) {
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 1e-6);
  linear_restitution(s, 1e5, 1);
  s.output.energies = true;
  s.max_overlap = 1;
  s.allow_initial_overlap = true;
  s.walls = {plane("floor", {0, 0, -0.0149}, {0, 0, 1}), plane("lid", {0, 0, 0.0149}, {0, 0, -1})};
  add_grains(s, {{{0, 0, -0.01}, {}, 0.005}, {{}, {}, 0.005}, {{0, 0, 0.01}, {}, 0.0051}});
  Simulation sim(s, options());
  breathe(sim, 0.0, 1000, 0);  // the lowest leaves in step 20
  sim.run(20);
  const double elastic = sim.energies().elastic;
  sim.run(20);
  const Energies e = sim.energies();
  EXPECT_EQ(sim.particles(), 2);
  EXPECT_LT(e.inserted, -1e-5);
  figure("grain that leaves a stack: residual / elastic energy before", e.residual / elastic);
  EXPECT_LT(std::fabs(e.residual), 0.02 * elastic);
}

}  // namespace
}  // namespace talus::physics
