// Superquadrics in a scene: what a ball, a wall, a collision, a mesh and an edge make of them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "paths.hpp"
#include "scheduler/step/access.hpp"
#include "tests/shapes/body_support.hpp"

namespace talus {
namespace {

struct Words {
  std::string head = "gravity = [0, 0, 0]", boundary = "\"open\"",
              law = "normal_stiffness = 2000\nfriction = 0.4\ntangential_stiffness = 800", shape, restitution = "0.7",
              rest, material = "density = 2000";
  double dt = 1e-5;
};

std::string superquadric(const std::string& name, const std::string& axes, const std::string& exponents = {}) {
  return "[[shape]]\nname = \"" + name + "\"\nkind = \"superquadric\"\nsemi_axes = " + axes + "\n" +
         (exponents.empty() ? "" : "exponents = " + exponents + "\n");
}

Scene scene_of(const Words& w) {
  return parse_scene(w.head +
                         "\nseed = 3\nsort_every = 300\n[domain]\nlower = [0, 0, 0]\nupper = [0.05, 0.05, "
                         "0.05]\nboundary = " +
                         w.boundary + "\n[time]\nstep = " + fmt::format("{:.9g}", w.dt) +
                         "\nduration = 1\n[[material]]\nname = \"m\"\n" + w.material +
                         "\n[contact]\nrestitution = " + w.restitution + "\n" + w.law + "\n" + w.shape + w.rest,
                     "test", "", {});
}

TEST(Superquadric, CollisionsKeepMomentumAndAngularMomentum) {
  for (const char* law : {"normal_stiffness = 2000\nfriction = 0.4\ntangential_stiffness = 800",
                          "model = \"hertz_mindlin\"\nfriction = 0.4"}) {
    Words w;
    w.law = law;
    w.material = "density = 2000\nyoung = 5e6\npoisson = 0.3";
    w.shape = superquadric("one", "[0.003, 0.002, 0.001]") + superquadric("two", "[0.002, 0.002, 0.002]", "[5, 4]");
    w.rest = source("a", 20, "[0.01, 0.01, 0.01]", "[0.04, 0.04, 0.04]", "shape = \"one\"\nvelocity_jitter = 1.5") +
             source("b", 20, "[0.01, 0.01, 0.01]", "[0.04, 0.04, 0.04]", "shape = \"two\"\nvelocity_jitter = 1.5");
    Simulation sim(scene_of(w), {});
    sim.run(1);
    const Sums before = sums_of(sim);
    std::int64_t met = 0;
    for (int k = 0; k < 40; ++k) {
      sim.run(10);
      met += sim.counters().contacts;
    }
    const Sums after = sums_of(sim);
    EXPECT_EQ(sim.particles(), 40);
    EXPECT_GT(met, 5);
    EXPECT_LT(after.energy, 0.97 * before.energy);
    EXPECT_LT(norm(after.momentum - before.momentum), 1e-13 * before.mass);
    EXPECT_LT(norm(after.angular - before.angular), 1e-13 * before.mass * 0.05);
  }
}

/// Largest differences from spheres of radius 1 mm over a time in which they meet each other and walls.
struct Difference {
  double way = 0, turn = 0;  ///< [m], [rad/s]
};
Difference from_spheres(const std::string& law, const std::string& axes) {
  Words w;
  w.head = "gravity = [1, 0, -9.81]";
  w.boundary = "\"wall\"";
  w.law = law;
  w.material = "density = 2000\nyoung = 5e6\npoisson = 0.3";
  const char* region = "[0.005, 0.005, 0.005]";
  w.shape = superquadric("ball", axes);
  w.rest = source("grains", 130, region, "[0.045, 0.045, 0.03]", "shape = \"ball\"\nvelocity = [0.1, 0, 0]", "0.005");
  Simulation shaped(scene_of(w), {});
  w.shape = "";
  w.rest = source("grains", 130, region, "[0.045, 0.045, 0.03]", "velocity = [0.1, 0, 0]", "0.005");
  Simulation sphere(scene_of(w), {});
  for (Simulation* s : {&shaped, &sphere}) s->run(4000);
  const Frame a = shaped.frame(), b = sphere.frame();
  EXPECT_EQ(a.id.size(), b.id.size());
  EXPECT_GT(sphere.counters().contacts, 2);
  EXPECT_EQ(sphere.counters().contacts, shaped.counters().contacts);
  EXPECT_EQ(sphere.counters().wall_contacts, shaped.counters().wall_contacts);
  Difference most;
  for (std::size_t k = 0; k < a.id.size(); ++k) {
    most.way = fmax2(most.way, norm(a.x[k] - b.x[k]));
    most.turn = fmax2(most.turn, norm(a.w[k] - b.w[k]));
  }
  std::printf("%s: largest difference %.2g m, %.2g rad/s\n", axes.c_str(), most.way, most.turn);
  return most;
}
constexpr const char* k_laws[] = {"normal_stiffness = 2000\nfriction = 0.4\ntangential_stiffness = 800",
                                  "model = \"hertz_mindlin\"\nfriction = 0.4"};

TEST(Superquadric, BallMovesAsASphere) {
  for (const char* law : k_laws) {
    const Difference d = from_spheres(law, "[0.001, 0.001, 0.001]");
    EXPECT_LT(d.way, 1e-15);
    EXPECT_LT(d.turn, 1e-9);
  }
}

// The solver and the motion of arms, which a ball has no need of.
TEST(Superquadric, NearlyABallMovesNearlyAsASphere) {
  for (const char* law : k_laws) {
    const Difference d = from_spheres(law, "[0.001, 0.001, 0.001000000001]");
    EXPECT_LT(d.way, 1e-7);
    EXPECT_LT(d.turn, 0.03);
  }
}

// J = -(1 + e) v_n / (1/m + (r x n) I^-1 (r x n)): semi-axes 2, 1, 1, tilted by 45 degrees, v_z = -1 gives
// v_z' = 0.052632 and a spin of 0.998614, in units of the short axis.
TEST(Superquadric, EllipsoidLeavesAPlaneAsItsImpulseSays) {
  for (const bool mesh : {false, true}) {
    Words w;
    w.boundary = mesh ? "\"open\"" : "\"wall\"";
    w.law = "friction = 0\nnormal_stiffness = 2e6";
    w.restitution = "1.0";
    w.dt = 2e-7;
    w.shape = superquadric("egg", "[0.001, 0.001, 0.002]");
    w.rest = source("one", 1, "[0.02, 0.02, 0.0016]", "[0.027, 0.027, 0.0066]",
                    "shape = \"egg\"\nvelocity = [0, 0, -1]\norientation = \"aligned\"\norientation_axis = [1, 0, 1]");
    if (mesh)
      w.rest +=
          "[[wall]]\nname = \"floor\"\nshape = \"box\"\nlower = [0.001, 0.001, 0.0002]\nupper = [0.049, 0.049, "
          "0.0004]\n";
    Simulation sim(scene_of(w), {});
    bool met = false;
    for (int k = 0; k < 400; ++k) {
      sim.run(50);
      const bool touches = sim.counters().wall_contacts > 0;
      if (met && !touches) break;
      met = met || touches;
    }
    ASSERT_TRUE(met);
    const Vec3 spin = angular_velocity(rules_of(sim), bodies_of(sim), 0);
    EXPECT_NEAR(bodies_of(sim).v[2], 0.052632, 5e-3) << mesh;
    EXPECT_NEAR(std::fabs(spin.y), 998.614, 5) << mesh;
    EXPECT_NEAR(norm(spin), std::fabs(spin.y), 1e-6);
    const Sums s = sums_of(sim);
    EXPECT_NEAR(s.energy / (0.5 * s.mass), 1, 2e-3);
  }
}

// A pill that falls upright on the floor: v sqrt(m/k) over the radius of the sphere within it.
TEST(Superquadric, AdviceExpectsTheOverlapThatAnImpactMakes) {
  Words w;
  w.boundary = "\"wall\"";
  w.law = "friction = 0\nnormal_stiffness = 2000";
  w.restitution = "1.0";
  w.dt = 2e-6;
  w.shape = superquadric("pill", "[0.0013, 0.0013, 0.0026]", "[4, 2]");
  w.rest = source("one", 1, "[0.02, 0.02, 0.0002]", "[0.03, 0.03, 0.007]",
                  "shape = \"pill\"\nvelocity = [0, 0, -1.3]\norientation = \"aligned\"");
  Simulation sim(scene_of(w), {});
  sim.run(1);
  const double mass = 1 / bodies_of(sim).v[3], expected = sim.softening(0).overlap;
  const double inner = bodies_of(sim).scale(0) * 0.0013, central = 1.3 * std::sqrt(mass / 2000) / inner;
  double deepest = 1;
  for (int k = 0; k < 400; ++k) {
    sim.run(10);
    deepest = fmin2(deepest, bodies_of(sim).centre(0).z);
  }
  const double made = (bodies_of(sim).scale(0) * 0.0026 - deepest) / inner;
  EXPECT_NEAR(made / central, 1, 0.01);
  EXPECT_NEAR(expected / central, 1, 0.01);
}

/// Pairs of an engine whose bounding spheres meet, each once; `touch`: of them, those whose surfaces do.
std::int64_t near_pairs(Simulation& sim, bool touch) {
  std::int64_t twice = 0;
  for (const auto& c : EngineAccess::world(sim).contacts.chunks) {
    const std::int64_t* end = c->contacts.end;
    twice += 2 * (end[1] - end[0]) + end[0] + (end[2] - end[1]);
    if (touch) twice -= 2 * c->contacts.apart[0] + c->contacts.apart[1];
  }
  return twice / 2;
}

TEST(Superquadric, PairsThatALastNormalPartsAreNotSolvedAgain) {
  for (const char* exponents : {"", "[5, 4]"}) {
    Words w;
    w.head = "gravity = [0, 0, -9.81]";
    w.boundary = "[\"periodic\", \"periodic\", \"wall\"]";
    w.restitution = "0.3";
    w.shape = superquadric("egg", "[0.002, 0.0035, 0.0025]", exponents);
    w.rest = source("grains", 150, "[0, 0, 0]", "[0.05, 0.05, 0.05]", "shape = \"egg\"");
    Simulation sim(scene_of(w), {});
    sim.run(20000);
    const std::int64_t spheres = near_pairs(sim, false), touching = near_pairs(sim, true);
    EXPECT_GT(touching, 100);
    EXPECT_GT(spheres, touching * 3 / 2);
    EXPECT_GE(sim.counters().step_solved_pairs, touching);
    EXPECT_LE(sim.counters().step_solved_pairs, touching + touching / 10);
    std::printf("spheres of %lld pairs meet, %lld touch, %lld were solved\n", static_cast<long long>(spheres),
                static_cast<long long>(touching), static_cast<long long>(sim.counters().step_solved_pairs));
  }
}

/// Relative change of the energy of pairs that meet without friction or damping, spin included.
double energy_error(double dt, int seed) {
  Words w;
  w.law = "friction = 0\nnormal_stiffness = 2000";
  w.restitution = "1.0";
  w.dt = dt;
  w.head = "gravity = [0, 0, 0]\n";
  w.shape = superquadric("one", "[0.003, 0.002, 0.0015]", "[3, 2.5]") + superquadric("two", "[0.002, 0.0015, 0.003]");
  w.rest =
      source("a", 1, "[0.015, 0.02, 0.02]", "[0.0231, 0.0281, 0.0281]", "shape = \"one\"\nvelocity = [0.5, 0, 0]") +
      source("b", 1, "[0.024, 0.02, 0.02]", "[0.0321, 0.0281, 0.0281]", "shape = \"two\"");
  Scene s = scene_of(w);
  s.seed = static_cast<std::uint64_t>(seed);
  Simulation sim(s, {});
  sim.run(1);
  const double before = sums_of(sim).energy;
  bool met = false;
  const auto chunk = static_cast<std::int64_t>(1e-4 / dt + 0.5);
  for (int k = 0; k < 800; ++k) {
    sim.run(chunk);
    const bool touches = sim.counters().contacts > 0;
    if (met && !touches) break;
    met = met || touches;
  }
  EXPECT_TRUE(met) << seed;
  EXPECT_GT(norm(angular_velocity(rules_of(sim), bodies_of(sim), 0)), 1) << seed;
  return std::fabs(sums_of(sim).energy / before - 1);
}

// Leapfrog by itself would be off by up to (omega dt)^2/4 = 2.7e-5 of the normal part of the energy at 300 steps per
// contact, as the instants of touch and of parting lie in their steps: the first and last step count their part.
TEST(Superquadric, ElasticCollisionsKeepTheirEnergyToSecondOrder) {
  double coarse = 0, fine = 0, worst = 0;  // means over several collisions, for the instants lie anywhere in a step
  for (int seed = 3; seed < 13; ++seed) {
    coarse += 0.1 * energy_error(6.25e-6, seed);
    const double error = energy_error(1.5625e-6, seed);  // some 300 steps per contact
    fine += 0.1 * error;
    worst = fmax2(worst, error);
  }
  const double order = std::log(coarse / fine) / std::log(4.0);
  std::printf("energy error %.2g at 6.25e-6 s, %.2g at 1.5625e-6 s (worst %.2g): order %.2f\n", coarse, fine, worst,
              order);
  EXPECT_LT(worst, 1e-6);
  EXPECT_GT(order, 1.7);
}

TEST(Superquadric, EnergyLedgerClosesOfAMixedScene) {
  Words w;
  w.head = "gravity = [0, 0, -9.81]";
  w.boundary = "\"wall\"";
  w.shape = superquadric("egg", "[0.002, 0.0015, 0.0015]") +
            superquadric("dice", "[0.0015, 0.0015, 0.0015]", "[6, 6]") +
            "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.002, 0.002, 0, 0, 0, 0.002, 0, 0, 0.002, 0.002]\n";
  const char *low = "[0.002, 0.002, 0.002]", *high = "[0.048, 0.048, 0.048]";
  w.rest = source("eggs", 40, low, high, "shape = \"egg\"\nvelocity_jitter = 0.5") +
           source("dice", 30, low, high, "shape = \"dice\"\nvelocity_jitter = 0.5") +
           source("rods", 30, low, high, "shape = \"rod\"\nvelocity_jitter = 0.5") +
           source("balls", 30, low, high, "velocity_jitter = 0.5", "0.004") +
           "[output]\nenergies = true\n[damping]\nviscous = 0.2\n";
  Simulation sim(scene_of(w), {});
  EXPECT_EQ(sim.particles(), 130);
  sim.run(10000);
  const Energies e = sim.energies();
  const double turned = e.dissipated_damping + e.dissipated_friction + e.dissipated_background;
  EXPECT_GT(e.dissipated_friction, 0.01 * turned);
  EXPECT_LT(std::fabs(e.residual), 3e-3 * turned) << "of " << turned;
}

TEST(Superquadric, LieInABoxAtTheHeightOfTheirShortestAxis) {
  Words w;
  w.head = "gravity = [0, 0, -9.81]";
  w.boundary = "\"wall\"";
  w.restitution = "0.3";
  w.shape = superquadric("lens", "[0.003, 0.002, 0.001]");
  w.rest = source("one", 1, "[0.02, 0.02, 0.0001]", "[0.03, 0.03, 0.0071]", "shape = \"lens\"") +
           "[damping]\nviscous = 20\n";
  Simulation sim(scene_of(w), {});
  sim.run(60000);
  const double sag = bodies_of(sim).mass(0) * 9.81 / 2000;
  EXPECT_NEAR(bodies_of(sim).centre(0).z, 0.001 - sag, 2e-6);
  EXPECT_LT(norm(angular_velocity(rules_of(sim), bodies_of(sim), 0)), 0.5);
}

// The case, with fewer grains.
TEST(Superquadric, LentilsOfTheCasePourOntoTheirPlate) {
  const Scene scene = load_scene(std::string(TALUS_SOURCE_DIR) + "/cases/shapes/lentil-heap.toml",
                                 {"source.0.number=60", "time.steps=20000"});
  Simulation sim(scene, {});
  sim.run(20000);
  EXPECT_EQ(sim.counters().inserted, 60);
  EXPECT_GT(sim.counters().wall_contacts, 8);
  EXPECT_TRUE(sim.warnings().empty()) << sim.warnings().front().text;
  const Frame f = sim.frame({.contacts = true});
  ASSERT_FALSE(f.bodies.empty());
  for (const BodyRecord& b : f.bodies) {
    EXPECT_GT(b.x.z, 0.0007) << b.id;
    EXPECT_NEAR(b.semi_axes.x / b.semi_axes.z, 2.4 / 1.1, 1e-12);
  }
  for (const ContactRecord& c : f.contacts) EXPECT_LT(c.overlap, 1.1e-4);
  const Energies e = sim.energies();
  const double turned = e.dissipated_damping + e.dissipated_friction;
  EXPECT_LT(std::fabs(e.residual), 0.02 * turned) << "of " << turned;
}

std::string refusal(const Words& w) {
  try {
    Simulation sim(scene_of(w), {});
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Superquadric, WhatCannotBeRightIsRefused) {
  const std::string use = source("some", 1, "[0.01, 0.01, 0.01]", "[0.04, 0.04, 0.04]", "shape = \"s\"");
  const auto with = [&](const std::string& shape, const std::string& rest, const std::string& law = {}) {
    Words w;
    w.shape = "[[shape]]\nname = \"s\"\nkind = \"superquadric\"\n" + shape;
    w.rest = rest;
    w.law += law;
    return refusal(w);
  };
  const auto says = [](const std::string& text, const std::string& word) {
    return text.find(word) != std::string::npos ? "" : text;
  };
  const std::string good = "semi_axes = [0.002, 0.001, 0.001]\n";
  EXPECT_EQ(with(good, use), "accepted");
  EXPECT_EQ(with(good + "exponents = [20, 2]\n", use), "accepted");
  EXPECT_EQ(says(with("", use), "semi_axes"), "");
  EXPECT_EQ(says(with("semi_axes = [0.002, 0.001]\n", use), "semi_axes"), "");
  EXPECT_EQ(says(with("semi_axes = [0.002, 0.001, 0]\n", use), "semi_axes"), "");
  EXPECT_EQ(says(with("semi_axes = [0.2, 0.001, 0.001]\n", use), "differ"), "");
  EXPECT_EQ(says(with(good + "exponents = [1.5, 2]\n", use), "exponents"), "");
  EXPECT_EQ(says(with(good + "exponents = [2]\n", use), "exponents"), "");
  EXPECT_EQ(says(with(good + "spheres = [0, 0, 0, 1]\n", use), "spheres"), "");
  EXPECT_EQ(says(with(good, use, "\nrolling = \"cdt\"\nrolling_friction = 0.1"), "rolling"), "");
  EXPECT_EQ(says(with(good, use, "\ncohesion = \"sjkr\"\ncohesion_energy = 10"), "cohesion"), "");
  EXPECT_EQ(says(with(good, use, "\ntwisting_friction = 0.1"), "twist"), "");
  EXPECT_EQ(with(good, use + "[output]\nstress = true\ngrid = [2, 2, 2]\n"), "accepted");
  const std::string tube =
      "[[wall]]\nname = \"t\"\nshape = \"cylinder\"\npoint = [0.025, 0.025, 0]\naxis = [0, 0, 1]\nradius = 0.02\n";
  Words closed;
  closed.boundary = "[\"open\", \"open\", \"wall\"]";
  closed.shape = superquadric("s", "[0.002, 0.001, 0.001]");
  closed.rest = use + tube + "length = 0.05\n";
  EXPECT_EQ(refusal(closed), "accepted");
  closed.rest = use + tube + "length = 0.04\n";
  EXPECT_EQ(says(refusal(closed), "cylinder"), "");
  closed.rest = use + tube + "length = 0.05\n[wall.motion]\nvelocity = [0, 0, 1]\n";
  EXPECT_EQ(says(refusal(closed), "cylinder"), "");
  EXPECT_EQ(says(with(good, use + "[[wall]]\nname = \"t\"\nshape = \"cylinder\"\npoint = [0.02, 0.02, 0]\naxis = [0, "
                                  "0, 1]\nlength = 0.04\nradius = 0.02\n"),
                 "cylinder"),
            "");
}

}  // namespace
}  // namespace talus
