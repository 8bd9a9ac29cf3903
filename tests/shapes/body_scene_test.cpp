// Bodies of several spheres in a scene: what a collision, a wall, a side, an event and a source make of them.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/step/access.hpp"
#include "tests/shapes/body_support.hpp"

namespace talus {
namespace {

constexpr const char* k_rod =
    "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.002, 0.002, 0, 0, 0, 0.002, 0, 0, 0.002, 0.002]\n";
constexpr const char* k_pair = "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.002, 0.002, 0, 0, 0.002, 0.002]\n";

struct Words {
  std::string head = "gravity = [0, 0, 0]", boundary = "\"open\"", law = "friction = 0.4\ntangential_stiffness = 800",
              shape = k_rod, restitution = "0.7", rest;
  double dt = 1e-5;
};

Scene scene_of(const Words& w) {
  return parse_scene(
      w.head + "\nseed = 3\nsort_every = 300\n[domain]\nlower = [0, 0, 0]\nupper = [0.05, 0.05, 0.05]\nboundary = " +
          w.boundary + "\n[time]\nstep = " + std::to_string(w.dt) +
          "\nduration = 1\n[[material]]\nname = \"m\"\ndensity = 2000\n[contact]\n"
          "normal_stiffness = 2000\nrestitution = " +
          w.restitution + "\n" + w.law + "\n" + w.shape + w.rest,
      "test", "", {});
}

TEST(Body, CollisionsKeepMomentumAndAngularMomentum) {
  Words w;
  w.rest =
      source("rods", 12, "[0.015, 0.015, 0.015]", "[0.035, 0.035, 0.035]", "shape = \"rod\"\nvelocity_jitter = 0.3");
  Simulation sim(scene_of(w), {});
  sim.run(1);
  const Sums before = sums_of(sim);
  sim.run(1500);
  const Sums after = sums_of(sim);
  EXPECT_EQ(sim.particles(), 12);
  double spin = 0, mass = 0;
  for (std::int32_t k = 0; k < bodies_of(sim).n; ++k) {
    spin = fmax2(spin, norm(angular_velocity(rules_of(sim), bodies_of(sim), k)));
    mass += bodies_of(sim).mass(k);
  }
  EXPECT_GT(spin, 10) << "some have met";
  EXPECT_LT(norm(after.momentum - before.momentum), 1e-13 * mass);
  EXPECT_LT(norm(after.angular - before.angular), 1e-13 * mass * 0.05);
}

TEST(Body, FrictionlessRodLeavesAWallAsItsImpulseSays) {
  Words w;
  w.boundary = "\"wall\"";
  w.law = "friction = 0";
  w.shape = k_pair;
  w.restitution = "1.0";
  w.dt = 2e-6;
  w.rest =
      source("rods", 1, "[0.02, 0.02, 0.004]", "[0.0281, 0.0281, 0.0121]",
             "shape = \"rod\"\nvelocity = [0, 0, -0.05]\norientation = \"aligned\"\norientation_axis = [0.8, 0, 0.6]");
  Simulation sim(scene_of(w), {});
  const BodyShape& shape = shape_of(rules_of(sim), bodies_of(sim), 0);
  const double m = bodies_of(sim).mass(0), transverse = m * shape.moments.y;
  // the lower sphere touches below its centre: arm of the normal force about the centre, 0.8 of the offset
  const double arm = 0.8 * 0.002, impulse = 2 * 0.05 / (1 / m + arm * arm / transverse);
  double energy = 0;
  bool met = false;
  for (int k = 0; k < 400; ++k) {
    sim.run(100);
    const bool touches = sim.counters().wall_contacts > 0;
    if (met && !touches) break;
    met = met || touches;
  }
  ASSERT_TRUE(met);
  const double v = bodies_of(sim).v[2];
  const Vec3 spin = angular_velocity(rules_of(sim), bodies_of(sim), 0);
  EXPECT_NEAR(v, -0.05 + impulse / m, 0.05 * 5e-3);
  EXPECT_NEAR(std::fabs(spin.y), impulse * arm / transverse, 5e-3 * impulse * arm / transverse);
  EXPECT_NEAR(spin.x, 0, 1e-9);
  energy = 0.5 * m * v * v + rotation_energy(rules_of(sim), bodies_of(sim), 0);
  EXPECT_NEAR(energy, 0.5 * m * 0.05 * 0.05, 2e-3 * 0.5 * m * 0.05 * 0.05);
}

TEST(Body, OneSphereMovesAsASphere) {
  Words w;
  w.head = "gravity = [1, 0, -9.81]";
  w.boundary = "\"wall\"";
  const char* region = "[0.005, 0.005, 0.005]";
  w.shape = "[[shape]]\nname = \"ball\"\nspheres = [0.001, 0.002, 0.003, 0.001]\n";
  w.rest = source("grains", 130, region, "[0.045, 0.045, 0.03]", "shape = \"ball\"\nvelocity = [0.1, 0, 0]", "0.005");
  Simulation clump(scene_of(w), {});
  w.shape = "";
  w.rest = source("grains", 130, region, "[0.045, 0.045, 0.03]", "velocity = [0.1, 0, 0]", "0.005");
  Simulation sphere(scene_of(w), {});
  for (Simulation* s : {&clump, &sphere}) s->run(4000);
  const Frame a = clump.frame(), b = sphere.frame();
  ASSERT_EQ(a.id.size(), b.id.size());
  EXPECT_GT(sphere.counters().contacts + sphere.counters().wall_contacts, 3);
  for (std::size_t k = 0; k < a.id.size(); ++k) {
    EXPECT_LT(norm(a.x[k] - b.x[k]), 1e-9) << k;
    EXPECT_LT(norm(a.w[k] - b.w[k]), 1e-4) << k;
  }
}

TEST(Body, EnergyLedgerClosesOverALongRunOfRodsAndSpheres) {
  Words w;
  w.head = "gravity = [0, 0, -9.81]";
  w.boundary = "\"wall\"";
  w.rest =
      source("rods", 60, "[0.002, 0.002, 0.002]", "[0.048, 0.048, 0.048]", "shape = \"rod\"\nvelocity_jitter = 0.5") +
      source("balls", 40, "[0.002, 0.002, 0.002]", "[0.048, 0.048, 0.048]", "velocity_jitter = 0.5", "0.004") +
      "[output]\nenergies = true\n[damping]\nviscous = 0.2\n";
  Simulation sim(scene_of(w), {});
  EXPECT_EQ(sim.particles(), 100);
  sim.run(10000);
  const Energies e = sim.energies();
  const double turned = e.dissipated_damping + e.dissipated_friction + e.dissipated_background;
  EXPECT_GT(e.dissipated_background, 0.001 * turned);
  EXPECT_GT(e.kinetic_rotation, 0);
  EXPECT_LT(std::fabs(e.residual), 2e-3 * turned) << "of " << turned;
}

TEST(Body, FreeSpinKeepsItsMomentumAndOffCentreLoadsLeaveThroughSides) {
  Words w;
  w.shape =
      "[[shape]]\nname = \"t\"\nspheres = [0, 0, 0, 0.002, 0.003, 0, 0, 0.001, -0.003, 0, 0, 0.001, 0, 0.002, 0, "
      "0.001]\n";
  w.boundary = "\"periodic\"";
  w.rest = "[[group]]\nname = \"g\"\n" +
           source("t", 1, "[0.02, 0.02, 0.02]", "[0.03, 0.03, 0.03]", "shape = \"t\"\ngroup = \"g\"") +
           "[[event]]\ntime = 0\naction = \"set_velocity\"\ngroup = \"g\"\nvelocity = [0.9, 0.3, -0.6]\nspin = [200, "
           "300, -100]\n";
  Simulation sim(scene_of(w), {});
  sim.run(1);
  const Vec3 before = momentum_in_space(rules_of(sim), bodies_of(sim), 0);
  const double energy = rotation_energy(rules_of(sim), bodies_of(sim), 0);
  for (int k = 0; k < 40; ++k) {
    sim.run(500);
    EXPECT_NEAR(rotation_energy(rules_of(sim), bodies_of(sim), 0), energy, 1e-4 * energy);
    const Rows& rows = EngineAccess::world(sim).rows;
    for (Row i = 0; i < 4; ++i)
      for (int a = 0; a < 3; ++a) {
        EXPECT_GE(rows.p[4L * i + a], 0);
        EXPECT_LE(rows.p[4L * i + a], 0.05);
      }
  }
  EXPECT_LT(norm(momentum_in_space(rules_of(sim), bodies_of(sim), 0) - before), 1e-11 * norm(before));
}

TEST(Body, PeriodicSideChangesNothingForBodiesThatLieAcrossIt) {
  std::vector<Vec3> ways[2];
  for (int shifted = 0; shifted < 2; ++shifted) {
    Words w;
    w.boundary = "[\"periodic\", \"open\", \"open\"]";
    // two rods collide in the middle, or on the side
    const auto at = [&](double low, double high) {
      const double move = shifted == 1 ? 0.025 : 0;
      return std::pair("[" + std::to_string(low + move) + ", 0.02, 0.02]",
                       "[" + std::to_string(high + move) + ", 0.0281, 0.0281]");
    };
    const auto [a, b] = at(0.008, 0.0161);
    w.rest =
        source("one", 1, a, b,
               "shape = \"rod\"\nvelocity = [0.4, 0, 0]\norientation = \"aligned\"\norientation_axis = [0.6, 0, 0.8]");
    Scene s = scene_of(w);
    Source other = s.sources[0];
    other.name = "two";
    other.velocity = {-0.4, 0, 0};
    for (Vec3* x : {&other.region.lower, &other.region.upper}) x->x += 0.012;
    s.sources.push_back(other);
    if (shifted == 1)
      for (Source& q : s.sources)
        for (Vec3* x : {&q.region.lower, &q.region.upper}) x->x -= 0.0;
    Simulation sim(s, {});
    sim.run(3000);
    for (std::int32_t k = 0; k < 2; ++k) {
      ways[shifted].push_back(momentum_in_space(rules_of(sim), bodies_of(sim), k));
      ways[shifted].push_back({bodies_of(sim).v[4L * k], bodies_of(sim).v[4L * k + 1], bodies_of(sim).v[4L * k + 2]});
    }
  }
  EXPECT_GT(std::fabs(ways[0][1].x - 0.4), 0.1) << "they have met";
  for (std::size_t k = 0; k < ways[0].size(); ++k)
    EXPECT_LT(norm(ways[0][k] - ways[1][k]), 1e-6 * norm(ways[0][k]) + 1e-18) << k;
}

TEST(Body, EventsHoldTurnReleaseAndRemoveBodiesAsAWhole) {
  Words w;
  w.head = "gravity = [0, 0, -9.81]";
  w.rest = "[[group]]\nname = \"g\"\n" +
           source("rods", 3, "[0.01, 0.01, 0.02]", "[0.04, 0.04, 0.04]", "shape = \"rod\"\ngroup = \"g\"") +
           "[[event]]\ntime = 0\naction = \"drive\"\ngroup = \"g\"\nvelocity = [0, 0, 0.1]\nspin = [0, 100, 0]\n"
           "[[event]]\ntime = 0.01\naction = \"release\"\ngroup = \"g\"\n"
           "[[event]]\ntime = 0.02\naction = \"remove\"\ngroup = \"g\"\n[output]\nenergies = true\n";
  Simulation sim(scene_of(w), {});
  const auto lies = [&] {  // epochs change the places of bodies, not their numbers
    const auto q = sim.frame().bodies.at(0).orientation;
    return shapes::rotation({q[0], q[1], q[2], q[3]});
  };
  const shapes::Rotation before = lies();
  sim.run(900);
  EXPECT_NEAR(bodies_of(sim).v[2], 0.1, 1e-15);
  // 0.009 s at 100 rad/s about y
  const shapes::Rotation after = lies();
  const double c = std::cos(0.9), s = std::sin(0.9);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(after.row[0][k], c * before.row[0][k] + s * before.row[2][k], 1e-10);
    EXPECT_NEAR(after.row[2][k], c * before.row[2][k] - s * before.row[0][k], 1e-10);
  }
  sim.run(900);
  EXPECT_NEAR(norm(angular_velocity(rules_of(sim), bodies_of(sim), 0)), 100, 20) << "it goes on turning";
  EXPECT_LT(bodies_of(sim).v[2], 0.1 - 9.81 * 0.0079);
  EXPECT_EQ(sim.particles(), 3);
  sim.run(300);
  EXPECT_EQ(sim.particles(), 0);
  EXPECT_EQ(sim.counters().removed, 3);
  EXPECT_LT(std::fabs(sim.energies().residual), 1e-12);
}

TEST(Body, LeavesThroughAnOpenSideWithItsCentreAndIsCountedOnce) {
  Words w;
  w.rest = source("rods", 5, "[0.01, 0.01, 0.002]", "[0.04, 0.04, 0.04]", "shape = \"rod\"\nvelocity = [0, 0, -0.5]") +
           "[output]\ncsv_every = 0.1\n[[output.plane]]\nname = \"gate\"\npoint = [0, 0, 0.001]\nnormal = [0, 0, -1]\n";
  Simulation sim(scene_of(w), {});
  double mass = 0;
  for (std::int32_t k = 0; k < 5; ++k) mass += bodies_of(sim).mass(k);
  sim.run(12000);
  EXPECT_EQ(sim.particles(), 0);
  EXPECT_EQ(sim.counters().removed, 5);
  EXPECT_NEAR(sim.counters().removed_mass, mass, 1e-12 * mass);
  ASSERT_EQ(sim.planes().size(), 1U);
  EXPECT_EQ(sim.planes()[0].forward, 5);
  EXPECT_NEAR(sim.planes()[0].mass, mass, 1e-12 * mass);
  EXPECT_EQ(bodies_of(sim).n, 0) << "an epoch takes them out of the table";
}

TEST(Body, SizeIsTheDiameterOfTheSphereOfEqualVolume) {
  Words w;
  w.rest = source("rods", 30, "[0.004, 0.004, 0.004]", "[0.046, 0.046, 0.046]", "shape = \"rod\"");
  Scene s = scene_of(w);
  s.sources[0].size.kind = SizeDistribution::Kind::uniform;
  s.sources[0].size.min = 0.003;
  s.sources[0].size.max = 0.005;
  Simulation sim(s, {});
  double least = 1, most = 0;
  for (std::int32_t k = 0; k < bodies_of(sim).n; ++k) {
    const double d = std::cbrt(6 * bodies_of(sim).mass(k) / 2000 / M_PI);
    least = std::min(least, d);
    most = std::max(most, d);
    EXPECT_NEAR(bodies_of(sim).scale(k), d / (2 * shape_of(rules_of(sim), bodies_of(sim), k).equal_radius), 1e-12);
  }
  EXPECT_GE(least, 0.003 * (1 - 1e-12));
  EXPECT_LE(most, 0.005 * (1 + 1e-12));
  EXPECT_GT(most / least, 1.3);
}

TEST(Body, RelaxingStartPushesABodyOutOfAWallAndLeavesItAtRest) {
  Words w;
  w.boundary = "\"wall\"";
  w.rest =
      source("one", 1, "[0.02, 0.02, 0.0]", "[0.0281, 0.0281, 0.0061]",
             "shape = \"rod\"\norientation = \"aligned\"\norientation_axis = [1, 0, 0.2]\nallow_wall_overlap = true") +
      "[[wall]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0.0012]\n[relax]\nsteps = 3000\n";
  Simulation sim(scene_of(w), {});
  const auto deepest = [&] {
    double depth = 0;
    for (const ContactRecord& c : sim.frame({.contacts = true}).contacts) depth = fmax2(depth, c.overlap);
    return depth;
  };
  ASSERT_GT(deepest(), 5e-4);
  const shapes::Quaternion before = state_of(bodies_of(sim), 0).turn;
  sim.run(3000);
  const BodyState s = state_of(bodies_of(sim), 0);
  EXPECT_LT(deepest(), 2e-6);
  EXPECT_EQ(norm(s.v), 0);
  EXPECT_EQ(norm(s.spin), 0);
  EXPECT_GT(std::fabs(s.turn.x - before.x) + std::fabs(s.turn.y - before.y), 1e-3) << "the wall has turned it";
}

std::string refusal(const Words& w) {
  try {
    Simulation sim(scene_of(w), {});
  } catch (const Error& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Body, TravelOfAThinSuperquadricCountsItsThicknessAndItsTurning) {
  // 0.2 mm thick, 6 mm wide
  const auto said = [](const std::string& velocity, const std::string& spin, const std::string& size) {
    Words w;
    w.law = "friction = \"none\"";
    w.shape = "[[shape]]\nname = \"rod\"\nkind = \"superquadric\"\nsemi_axes = " + size + "\n";
    w.rest = "[[group]]\nname = \"g\"\n" +
             source("plate", 1, "[0.02, 0.02, 0.02]", "[0.03, 0.03, 0.03]", "shape = \"rod\"\ngroup = \"g\"") +
             "[[event]]\ntime = 0\naction = \"set_velocity\"\ngroup = \"g\"\nvelocity = " + velocity +
             "\nspin = " + spin + "\n";
    Simulation sim(scene_of(w), {});
    try {
      sim.run(5);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return sim.warnings().empty() ? std::string("nothing") : sim.warnings().front().text;
  };
  const std::string plate = "[0.003, 0.003, 0.0001]", ball = "[0.003, 0.003, 0.003]";
  EXPECT_EQ(said("[0, 0, 0.5]", "[0, 0, 0]", plate), "nothing") << "0.05 of its half thickness";
  EXPECT_NE(said("[0, 0, 5]", "[0, 0, 0]", plate).find("moves 0.5 of its radius"), std::string::npos);
  EXPECT_NE(said("[0, 0, 12]", "[0, 0, 0]", plate).find("could pass"), std::string::npos);
  EXPECT_NE(said("[0, 0, 0]", "[0, 1000, 0]", plate).find("moves 0.3 of its radius"), std::string::npos) << "its rim";
  EXPECT_NE(said("[0, 0, 0]", "[0, 5000, 0]", plate).find("could pass"), std::string::npos);
  EXPECT_EQ(said("[0, 0, 0]", "[0, 5000, 0]", ball), "nothing") << "a ball that turns goes nowhere";
}

TEST(Shape, WhatCannotBeABodyIsRefused) {
  const std::string use = source("rods", 1, "[0.01, 0.01, 0.01]", "[0.04, 0.04, 0.04]", "shape = \"rod\"");
  const auto with = [&](const std::string& shape, const std::string& rest) {
    Words w;
    w.shape = "[[shape]]\nname = \"rod\"\n" + shape;
    w.rest = rest;
    return refusal(w);
  };
  const std::string good = "spheres = [0, 0, 0, 0.002]\n";
  EXPECT_EQ(with(good, use), "accepted");
  EXPECT_NE(with("", use).find("spheres"), std::string::npos);
  EXPECT_NE(with("spheres = [0, 0, 0]\n", use).find("four numbers"), std::string::npos);
  EXPECT_NE(with("spheres = [0, 0, 0, -1]\n", use).find("radius"), std::string::npos);
  EXPECT_NE(with(good + "inertia = [1, 1, 1]\n", use).find("mass"), std::string::npos);
  EXPECT_NE(with(good + "mass = 1\ninertia = [1, 1, 3]\n", use).find("no body has"), std::string::npos);
  EXPECT_NE(with(good + "mass = 1\ninertia = [1, 1]\n", use).find("three moments"), std::string::npos);
  // a shell of 2 mm and 1 kg has 2/3 m R2 = 2.7e-6 about each axis; more than 3/2 of it nothing of this size has
  EXPECT_EQ(with(good + "mass = 1\ninertia = [2.6e-6, 2.6e-6, 2.6e-6]\n", use), "accepted");
  EXPECT_NE(with(good + "mass = 1\ninertia = [2.7e-6, 2.7e-6, 2.7e-6]\n", use).find("sum is at most 8e-06"),
            std::string::npos);
  EXPECT_NE(with(good + "mass = 1\ninertia = [1e-6, 1e-6, 1e-6]\ncentre = [0, 0, 0.0021]\n", use).find("lies outside"),
            std::string::npos);
  EXPECT_EQ(with(good + "mass = 1\ninertia = [1e-6, 1e-6, 1e-6]\ncentre = [0, 0, 0.0019]\n", use), "accepted");
  EXPECT_EQ(with("spheres = [0, 0, 0.0016, 0.0005, 0, 0, 0, 0.002]\n", use), "accepted");
  EXPECT_NE(with(good + "mass = 1\ndensity = 3\n", use).find("density"), std::string::npos);
  EXPECT_NE(with(good, source("rods", 1, "[0.01, 0.01, 0.01]", "[0.04, 0.04, 0.04]", "shape = \"road\"")).find("rod"),
            std::string::npos);
  // what lies so at first is not held so: the old word could be read as that
  EXPECT_NE(with(good, use + "[[source]]\nkind = \"random\"\nnumber = 1\nshape = \"rod\"\norientation = \"fixed\"\n")
                .find("aligned"),
            std::string::npos);
  EXPECT_EQ(with(good, use + "[output]\nstress = true\n[tracer]\nrate = 1\n"), "accepted");
}

}  // namespace
}  // namespace talus
