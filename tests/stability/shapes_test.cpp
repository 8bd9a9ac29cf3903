// Scenarios 41 to 46: grains that are no spheres: thin, long, turning fast, of very unlike masses, with sharp edges,
// and at rest in a heap. Steps are half of what the refusal of a larger one allows, so that its word is tried, too.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/scene/scene_file.hpp"
#include "tests/stability/stability_support.hpp"

namespace talus::stability {
namespace {

struct Setting {
  std::string rest;
  std::string law = "normal_stiffness = 2000\ntangential_stiffness = 600\nfriction = 0.4\nrestitution = 0.5";
  std::string gravity = "[0, 0, -9.81]", upper = "[0.02, 0.02, 0.03]";
  double dt = 1;
};

std::string shape(const std::string& name, const std::string& axes, const std::string& more = {}) {
  return fmt::format("[[shape]]\nname = \"{}\"\nkind = \"superquadric\"\nsemi_axes = {}\n{}\n", name, axes, more);
}
constexpr const char* k_rod =
    "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.001, 0.001, 0, 0, 0, 0.001, 0, 0, 0.001, 0.001]\n";

std::string some(int number, const std::string& shape, const std::string& lower, const std::string& upper,
                 const std::string& more = {}) {
  return fmt::format(
      "[[source]]\nname = \"{0}\"\nkind = \"random\"\nnumber = {1}\nshape = \"{0}\"\n{4}\nregion = {{ lower = {2}, "
      "upper "
      "= {3} }}\n",
      shape, number, lower, upper, more);
}

Scene scene_of(const Setting& s) {
  return parse_scene(
      fmt::format(
          "seed = 4\ngravity = {}\n[domain]\nlower = [0, 0, 0]\nupper = {}\nboundary = \"wall\"\n[time]\nstep = "
          "{:.9g}\nduration = 10\n[[material]]\nname = \"m\"\ndensity = 2000\n[contact]\n{}\n[output]\nenergies = "
          "true\n{}",
          s.gravity, s.upper, s.dt, s.law, s.rest),
      "shapes", "", {});
}

/// The largest step that the refusal of a far too large one names [s].
double largest_step(Setting s) {
  s.dt = 1;
  const std::string text = refusal([&] { Simulation(scene_of(s), options()); });
  const std::size_t at = text.find("at most ");
  EXPECT_NE(at, std::string::npos) << text;
  return at == std::string::npos ? 0 : std::strtod(text.c_str() + at + 8, nullptr);
}

/// What the energies of a run do; all but `first` over the first energy.
struct Course {
  double first = 0;  ///< [J]
  double most = 0, least = 1e300, kinetic = 0, residual = 0;
};
Course course_of(Simulation& sim, std::int64_t steps, int parts = 50) {
  sim.run(1);
  Course c;
  c.first = total_energy(sim.energies());
  for (int k = 0; k < parts; ++k) {
    sim.run(steps / parts);
    const Energies e = sim.energies();
    c.most = std::max(c.most, total_energy(e) / c.first);
    c.least = std::min(c.least, total_energy(e) / c.first);
    c.kinetic = (e.kinetic_translation + e.kinetic_rotation) / c.first;
    c.residual = std::fabs(e.residual) / c.first;
  }
  return c;
}

TEST(Stability, S41_ThinPlatesOfAspectTenComeToRestWithoutGainingEnergy) {
  std::string figures;
  for (const char* exponents : {"[2, 2]", "[8, 2]"}) {
    Setting s;
    s.rest = shape("plate", "[0.002, 0.002, 0.0002]", fmt::format("exponents = {}", exponents)) +
             some(full() ? 40 : 16, "plate", "[0.001, 0.001, 0.001]", "[0.019, 0.019, 0.029]");
    s.dt = 0.5 * largest_step(s);
    Simulation sim(scene_of(s), options());
    const Course c = course_of(sim, static_cast<std::int64_t>((full() ? 2 : 0.2) / s.dt));
    EXPECT_EQ(sim.particles(), full() ? 40 : 16);
    EXPECT_LT(c.most, 1 + 1e-3) << exponents;
    EXPECT_LT(c.kinetic, full() ? 1e-5 : 1e-2) << exponents;
    EXPECT_LT(c.residual, 0.02) << exponents;
    figures += fmt::format("{}: most {:.4f} E0, kinetic {:.1e} E0, balance {:.1e}; ", exponents, c.most, c.kinetic,
                           c.residual);
  }
  row("at half the step that a refusal names energy never exceeds the first, plates come to rest", figures);
}

TEST(Stability, S42_ANeedleOfAspectTenKeepsItsEnergyOverManyImpacts) {
  Setting s;
  s.law = "normal_stiffness = 2000\nfriction = 0\nrestitution = 1";
  s.upper = "[0.008, 0.008, 0.012]";
  s.rest = shape("needle", "[0.0002, 0.0002, 0.002]") + some(3, "needle", "[0, 0, 0.002]", "[0.008, 0.008, 0.012]");
  s.dt = 0.5 * largest_step(s);
  Simulation sim(scene_of(s), options());
  const Course c = course_of(sim, static_cast<std::int64_t>((full() ? 4 : 0.2) / s.dt));
  EXPECT_LT(c.most, 1.02);
  EXPECT_GT(c.least, 0.98);
  row("elastic needles in a box: energy within 2 %", fmt::format("{:.5f} ... {:.5f} E0", c.least, c.most));
}

Setting spinning(double stiffness) {
  Setting s;
  s.law = fmt::format("normal_stiffness = {}\nfriction = 0\nrestitution = 1", stiffness);
  s.gravity = "[0, 0, 0]";
  s.upper = "[0.006, 0.006, 0.006]";
  s.rest =
      shape("top", "[0.001, 0.0008, 0.0005]", "exponents = [3, 2]") +
      some(2, "top", "[0, 0, 0]", "[0.006, 0.006, 0.006]", "group = \"all\"") +
      "[[group]]\nname = \"all\"\n[[event]]\ntime = 0\naction = \"set_velocity\"\ngroup = \"all\"\nvelocity = [1, 2, "
      "-1]\nspin = [60000, 60000, 52915]\n";
  return s;
}

TEST(Stability, S43_GrainsThatSpinAtTenToTheFiveKeepTheirEnergyOrAreRefused) {
  Setting s = spinning(2e7);
  s.dt = 0.5 * largest_step(s);
  Simulation sim(scene_of(s), options());
  const Course c = course_of(sim, full() ? 2000000 : 140000);
  EXPECT_LT(c.most, 1.01);
  EXPECT_GT(c.least, 0.99);
  EXPECT_EQ(sim.particles(), 2);
  // a surface that moves by more than its size from step to step: soft contacts would allow the step
  Setting coarse = spinning(0.05);
  coarse.dt = 5e-5;
  const std::string text = refusal([&] {
    Simulation blind(scene_of(coarse), options());
    blind.run(200);
  });
  EXPECT_NE(text.find("a time.step of at most"), std::string::npos) << text;
  row("1e5 rad/s: elastic energy within 1 %; surfaces that move by a radius per step are refused with a step",
      fmt::format("{:.5f} ... {:.5f} E0", c.least, c.most));
}

TEST(Stability, S44_MassesOfOneToAMillionCollideWithinTheirEnergy) {
  Setting s;
  s.law = "normal_stiffness = 2000\nfriction = 0\nrestitution = 1";
  s.gravity = "[0, 0, 0]";
  s.upper = "[0.012, 0.012, 0.012]";
  s.rest = shape("light", "[0.001, 0.0008, 0.0006]", "density = 20") +
           shape("heavy", "[0.001, 0.0008, 0.0006]", "exponents = [5, 4]\ndensity = 2e7") +
           some(20, "light", "[0, 0, 0]", "[0.012, 0.012, 0.012]", "velocity_jitter = 1") +
           some(4, "heavy", "[0, 0, 0]", "[0.012, 0.012, 0.012]");
  s.dt = 0.5 * largest_step(s);
  Simulation sim(scene_of(s), options());
  const Course c = course_of(sim, static_cast<std::int64_t>((full() ? 0.4 : 0.02) / s.dt));
  EXPECT_LT(c.most, 1.01);
  EXPECT_GT(c.least, 0.99);
  double fastest = 0;
  for (const BodyRecord& b : sim.frame().bodies)
    if (b.mass > 1e-3) fastest = std::max(fastest, norm(b.v));
  EXPECT_LT(fastest, 1e-3);
  EXPECT_GT(fastest, 0);
  row("mass ratio 1e6, elastic: energy within 1 %, the heavy hardly move",
      fmt::format("{:.5f} ... {:.5f} E0, {:.1e} m/s", c.least, c.most, fastest));
}

TEST(Stability, S45_CubesOfExponentTwentyComeToRestInACorner) {
  Setting s;
  s.gravity = "[-5, -5, -7]";
  s.upper = "[0.015, 0.015, 0.015]";
  s.law = "normal_stiffness = 4000\ntangential_stiffness = 1200\nfriction = 0.3\nrestitution = 0.3";
  s.rest = shape("cube", "[0.001, 0.001, 0.001]", "exponents = [20, 20]") +
           some(full() ? 27 : 8, "cube", "[0, 0, 0]", "[0.012, 0.012, 0.012]");
  s.dt = 0.5 * largest_step(s);
  Simulation sim(scene_of(s), options());
  const Course c = course_of(sim, static_cast<std::int64_t>((full() ? 1 : 0.12) / s.dt));
  EXPECT_EQ(sim.particles(), full() ? 27 : 8);
  EXPECT_LT(c.most, 1 + 1e-3);
  EXPECT_LT(c.kinetic, 1e-3);
  EXPECT_LT(c.residual, 0.02);
  const Counters n = sim.counters();
  EXPECT_GT(n.safe_pairs, 0);
  EXPECT_GT(n.solved_pairs, n.safe_pairs);
  row("cubes with n = 20 in a corner: no energy gained, at rest",
      fmt::format("most {:.4f} E0, kinetic {:.1e} E0, balance {:.1e}; {} of {} pairs by the safe method", c.most,
                  c.kinetic, c.residual, n.safe_pairs, n.solved_pairs));
}

/// Largest distance between bodies of two frames [m].
double way_between(const Frame& a, const Frame& b) {
  double way = 0;
  EXPECT_EQ(a.bodies.size(), b.bodies.size());
  for (std::size_t k = 0; k < std::min(a.bodies.size(), b.bodies.size()); ++k)
    way = std::max(way, norm(a.bodies[k].x - b.bodies[k].x));
  return way;
}

TEST(Stability, S46_HeapsAtRestNeitherGainEnergyNorCreep) {
  std::string figures;
  for (const bool clumps : {false, true}) {
    Setting s;
    s.upper = full() ? "[0.012, 0.012, 0.03]" : "[0.008, 0.008, 0.03]";
    s.law = "normal_stiffness = 4000\ntangential_stiffness = 1200\nfriction = 0.5\nrestitution = 0.3";
    const std::string name = clumps ? "rod" : "lens";
    s.rest = (clumps ? std::string(k_rod) : shape("lens", "[0.0016, 0.0016, 0.0008]")) +
             some(full() ? 40 : 12, name, "[0, 0, 0]", s.upper);
    s.dt = 0.5 * largest_step(s);
    Simulation sim(scene_of(s), options());
    const auto steps = [&](double time) { return static_cast<std::int64_t>(time / s.dt); };
    sim.run(steps(full() ? 1.5 : 0.3));  // what still moves rocks, ever less
    double kinetic[3], total[3], way[2];
    Frame last = sim.frame();
    for (int k = 0; k < 3; ++k) {
      const Energies e = sim.energies();
      kinetic[k] = e.kinetic_translation + e.kinetic_rotation;
      total[k] = total_energy(e);
      if (k == 2) break;
      sim.run(steps(full() ? 1.5 : 0.05));
      const Frame now = sim.frame();
      way[k] = way_between(last, now);
      last = now;
    }
    EXPECT_LT(kinetic[2], kinetic[0] + 1e-15 * total[0]) << name;
    EXPECT_LE(total[1], total[0] * (1 + 1e-12)) << name;
    EXPECT_LE(total[2], total[1] * (1 + 1e-12)) << name;
    EXPECT_LT(way[1], 1e-8) << name;
    EXPECT_LT(way[1], way[0]) << name;
    figures += fmt::format("{}: ways {:.1e} and {:.1e} m, kinetic {:.1e} of the whole; ", name, way[0], way[1],
                           kinetic[2] / total[2]);
  }
  row("heaps of lenses and of rods at rest: no energy gained, no growing way", figures);
}

}  // namespace
}  // namespace talus::stability
