// Bodies of particle files: one row each, where and how it says; what cannot be meant is refused; a state that a run
// has written comes back.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/io/particle_export.hpp"
#include "core/scene/scene_file.hpp"
#include "tests/shapes/body_support.hpp"

namespace talus {
namespace {

constexpr const char* k_shapes = R"(
[[shape]]
name = "hook"
spheres = [0, 0, 0, 0.002, 0.003, 0, 0, 0.002, 0, 0.001, 0.003, 0.001]
[[shape]]
name = "plate"
kind = "superquadric"
semi_axes = [0.004, 0.003, 0.0005]
exponents = [8, 4]
)";

struct Words {
  std::string head = "gravity = [0, 0, 0]", boundary = "\"wall\"",
              law = "friction = 0.4\ntangential_stiffness = 800\nrestitution = 0.7", rest;
};

Scene scene_of(const Words& w) {
  return parse_scene(w.head +
                         "\nseed = 3\nsort_every = 300\n[domain]\nlower = [-0.01, 0, 0]\nupper = [0.05, 0.05, 0.05]\n"
                         "boundary = " +
                         w.boundary +
                         "\n[time]\nstep = 1e-5\nduration = 1\n[[material]]\nname = \"m\"\ndensity = 2000\n"
                         "[[material]]\nname = \"heavy\"\ndensity = 5000\n[contact]\nnormal_stiffness = 2000\n" +
                         w.law + "\n" + k_shapes + w.rest,
                     "test", "", {});
}

double difference(Vec3 a, Vec3 b) { return norm(a - b); }

TEST(BodyFile, EachRowIsABodyWhereAndAsItSays) {
  const double h = std::sqrt(0.5);
  // a quarter turn about z takes x to y
  const Table table(
      fmt::format("x,y,z,shape,scale,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,material,radius\n"
                  "0.01,0.02,0.01,hook,2,{0},0,0,{0},1,2,3,4,5,6,heavy,0\n"
                  "0.03,0.02,0.03,1,1.5,1,0,0,0,0,0,1,0,0,7,m,0\n"
                  "0.03,0.04,0.01,-,,,,,,0,0,0,0,0,0,m,0.003\n",
                  h));
  Words w;
  w.rest = table.source();
  const Scene scene = scene_of(w);
  Simulation sim(scene, {});
  EXPECT_EQ(sim.particles(), 3);
  const Bodies& b = bodies_of(sim);
  ASSERT_EQ(b.n, 2);
  EXPECT_LT(difference(b.centre(0) + scene.domain.lower, {0.01, 0.02, 0.01}), 1e-17);
  EXPECT_LT(difference({b.v[0], b.v[1], b.v[2]}, {1, 2, 3}), 1e-15);
  EXPECT_LT(difference(angular_velocity(rules_of(sim), b, 0), {4, 5, 6}), 1e-14);
  const BodyShape& hook = *scene.shapes[0].body;
  EXPECT_NEAR(b.mass(0), 8 * 5000 * hook.volume, 1e-15);
  EXPECT_NEAR(b.mass(1), 1.5 * 1.5 * 1.5 * 2000 * scene.shapes[1].body->volume, 1e-15);
  const Frame f = sim.frame();
  ASSERT_EQ(f.x.size(), 5U) << "three spheres, a plate, a sphere";
  // from the first to the second sphere of the hook: 3 mm along its x, twice as large, turned to y
  EXPECT_LT(difference(f.x[1] - f.x[0], {0, 0.006, 0}), 1e-16);
  EXPECT_LT(difference(f.x[2] - f.x[0], {-0.002, 0, 0.006}), 1e-16);
  EXPECT_LT(difference(f.v[1] - f.v[0], cross(Vec3{4, 5, 6}, f.x[1] - f.x[0])), 1e-14);
  EXPECT_EQ(f.r[1], 0.004);
  ASSERT_EQ(f.bodies.size(), 2U);
  EXPECT_NEAR(f.bodies[0].orientation[0], h, 1e-15) << "of the axes that the shape is given in";
  EXPECT_NEAR(f.bodies[0].orientation[3], h, 1e-15);
  EXPECT_NEAR(f.bodies[1].semi_axes.x, 0.006, 1e-17);
  EXPECT_EQ(f.r[4], 0.003);
}

TEST(BodyFile, SizesByRadiusOfEqualVolumeAndOneShapeForAllRows) {
  const Table table("x y z diameter\n0.02 0.02 0.02 0.004\n0.02 0.02 0.04 0.003\n");
  Words w;
  w.rest = table.source("shape = \"plate\"");
  Simulation sim(scene_of(w), {});
  const double equal = rules_of(sim).scene.shapes[1].body->equal_radius;
  ASSERT_EQ(bodies_of(sim).n, 2);
  EXPECT_NEAR(bodies_of(sim).scale(0), 0.002 / equal, 1e-15);
  EXPECT_NEAR(bodies_of(sim).mass(1), 2000 * 4.0 / 3 * M_PI * std::pow(0.0015, 3), 1e-16);
}

TEST(BodyFile, HeldBodiesStayUntilReleased) {
  const Table table("x,y,z,shape,scale,fixed,wx,wy,wz\n0.02,0.02,0.02,hook,1,1,0,0,0\n0.02,0.04,0.02,hook,1,0,0,0,9\n");
  Words w;
  w.head = "gravity = [0, 0, -9.81]";
  w.rest = "[[group]]\nname = \"g\"\nfixed_in_file = true\n" + table.source() +
           "[[event]]\ntime = 0.02\naction = \"release\"\ngroup = \"g\"\n[output]\nenergies = true\n";
  Simulation sim(scene_of(w), {});
  const double z = bodies_of(sim).centre(0).z;
  sim.run(1900);
  const auto height = [&](std::size_t k) { return sim.frame().bodies.at(k).x.z; };
  EXPECT_EQ(height(0), z);
  EXPECT_NEAR(height(1), z - 0.5 * 9.81 * 0.019 * 0.019, 1e-7);
  EXPECT_NEAR(sim.frame().bodies.at(1).w.z, 9, 0.05) << "about no principal axis: it wobbles";
  sim.run(1000);
  EXPECT_LT(height(0), z - 1e-4);
  EXPECT_LT(std::fabs(sim.energies().residual), 1e-9);
}

/// A run of a mixed scene, its state as a table, and a scene that begins with it.
TEST(BodyFile, AStateThatARunHasWrittenComesBack) {
  Words w;
  w.head = "gravity = [0, 0, -9.81]";
  w.boundary = "[\"periodic\", \"wall\", \"wall\"]";
  const char *low = "[-0.01, 0.001, 0.001]", *high = "[0.05, 0.049, 0.04]";
  w.rest = source("hooks", 12, low, high,
                  "shape = \"hook\"\nvelocity = [0, 0, -1]\nvelocity_jitter = 0.2\nmaterial = \"heavy\"") +
           source("plates", 12, low, high, "shape = \"plate\"\nvelocity = [0, 0, -1]\nvelocity_jitter = 0.2") +
           source("balls", 12, low, high, "velocity = [0, 0, -1]\nvelocity_jitter = 0.2", "0.004");
  Simulation sim(scene_of(w), {});
  sim.run(3000);
  EXPECT_GT(sim.counters().contacts + sim.counters().wall_contacts, 0);
  const Frame before = sim.frame();
  const std::string text = csv_text(before, rules_of(sim).scene.shapes);
  const Table table(text);
  Words next = w;
  next.law += "\n[checks]\nallow_initial_overlap = true\nmax_overlap = 0.5";
  next.rest = table.source();
  Simulation again(scene_of(next), {});
  const Frame after = again.frame();
  ASSERT_EQ(after.bodies.size(), before.bodies.size());
  ASSERT_EQ(after.x.size(), before.x.size());
  double place = 0, turn = 0, motion = 0;
  for (std::size_t k = 0; k < after.x.size(); ++k) {
    place = fmax2(place, difference(after.x[k], before.x[k]));
    if (k >= after.x.size() - 12) motion = fmax2(motion, difference(after.v[k], before.v[k]));  // balls
    EXPECT_EQ(after.material[k], before.material[k]);
    EXPECT_NEAR(after.r[k], before.r[k], 1e-18);
  }
  for (std::size_t k = 0; k < after.bodies.size(); ++k) {
    const BodyRecord &a = after.bodies[k], &b = before.bodies[k];
    EXPECT_EQ(a.shape, b.shape);
    EXPECT_EQ(a.scale, b.scale);
    EXPECT_EQ(a.mass, b.mass);
    place = fmax2(place, difference(a.x, b.x));
    motion = fmax2(motion, fmax2(difference(a.v, b.v), 0.001 * difference(a.w, b.w)));
    for (std::size_t c = 0; c < 4; ++c) turn = fmax2(turn, std::fabs(a.orientation[c] - b.orientation[c]));
  }
  EXPECT_LT(place, 1e-16);
  EXPECT_LT(motion, 1e-14);
  EXPECT_LT(turn, 4e-16);
  EXPECT_EQ(csv_text(after).substr(0, 20), text.substr(0, 20));
  again.run(500);
  EXPECT_EQ(again.particles(), 36);
}

TEST(BodyFile, TilesRepeatBodiesAlsoThoseAcrossAPeriodicSide) {
  const Table table("x,y,z,shape,scale\n-0.0095,0.01,0.01,hook,1\n0.005,0.03,0.03,plate,1\n");
  Words w;
  w.boundary = "[\"periodic\", \"wall\", \"wall\"]";
  w.rest = table.source("tile = [3, 1, 1]");
  Simulation sim(scene_of(w), {});
  ASSERT_EQ(bodies_of(sim).n, 6);
  const Frame f = sim.frame();
  ASSERT_EQ(f.x.size(), 12U);
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t tile = 1; tile < 3; ++tile) {
      Vec3 way = f.x[4 * tile + k] - f.x[k];
      way.x -= 0.02 * static_cast<double>(tile);
      EXPECT_LT(std::fabs(std::remainder(way.x, 0.06)), 1e-15);
      EXPECT_EQ(way.y, 0);
    }
  sim.run(10);
}

TEST(BodyFile, OverlapsAreThoseOfSurfacesAndNotOfTheSpheresAroundThem) {
  const auto pile = [](double gap) {
    const Table table(fmt::format("x,y,z,shape,scale\n0.02,0.02,0.02,plate,1\n0.02,0.02,{},plate,1\n", 0.021 + gap));
    Words w;
    w.rest = table.source();
    try {
      Simulation sim(scene_of(w), {});
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(pile(1e-5), "accepted") << "plates of 1 mm whose bounding spheres have 9 mm";
  EXPECT_EQ(pile(-1e-5), "accepted") << "2 % of the half thickness";
  EXPECT_NE(pile(-1e-4).find("initial overlaps deeper than 0.05"), std::string::npos) << pile(-1e-4);
}

std::string refusal(const std::string& table, const std::string& more = {}, const std::string& rest = {}) {
  const Table file(table);
  Words w;
  w.rest = file.source(more) + rest;
  try {
    Simulation sim(scene_of(w), {});
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}
#define EXPECT_SAYS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

TEST(BodyFile, WhatCannotBeMeantIsRefused) {
  const std::string at = "0.02,0.02,0.02,";
  EXPECT_EQ(refusal("x,y,z,shape,scale\n" + at + "hook,1\n"), "accepted");
  EXPECT_SAYS(refusal("x,y,z,shape,scale\n" + at + "hok,1\n"), ":2: shape 'hok' does not exist (did you mean 'hook'?)");
  EXPECT_SAYS(refusal("x,y,z,shape,scale\n" + at + "2,1\n"), "shape '2' does not exist");
  EXPECT_SAYS(refusal("x,y,z,shape,scale\n" + at + "hook,0\n"), "a body without a size");
  EXPECT_SAYS(refusal("x,y,z,shape,scale\n" + at + "hook,-1\n"), "scale: -1 is not allowed");
  EXPECT_SAYS(refusal("x,y,z,shape,scale,radius\n" + at + "hook,1,0.004\n"), "scale 1 is not that of radius 0.004");
  EXPECT_SAYS(refusal("x,y,z,shape,scale\n" + at + "-,1\n"), "radius: 0 is not allowed");
  EXPECT_SAYS(refusal("x,y,z,shape,scale,radius\n" + at + "-,2,0.001\n"), "scale: 2 is not allowed");
  EXPECT_SAYS(refusal("x,y,z,shape\n" + at + "hook\n"), "column 'radius' is missing");
  EXPECT_SAYS(refusal("x,y,z,shape,scale,qw,qx,qy\n" + at + "hook,1,1,0,0\n"), "qx, qy and qz come together");
  EXPECT_SAYS(refusal("x,y,z,shape,scale,qw,qx,qy,qz\n" + at + "hook,1,0,0,0,0\n"), "no unit quaternion");
  EXPECT_SAYS(refusal("x,y,z,shape,scale,qw,qx,qy,qz\n" + at + "hook,1,2,0,0,0\n"), "no unit quaternion");
  EXPECT_SAYS(refusal("x,y,z,shape,scale\n0.0499,0.02,0.02,hook,1\n"), "reaches through a side of the domain");
  EXPECT_SAYS(refusal("x,y,z,radius,body\n" + at + "0.001,0\n"), "column 'body'");
  EXPECT_SAYS(refusal("x,y,z,shape,scale\n" + at + "plate,1\n0.05,0.03,0.02,plate,1\n"), "wall \"domain_x_upper\"");
  EXPECT_EQ(refusal("x,y,z,radius,scale\n" + at + "0.001,7\n"), "accepted") << "spheres: the column means nothing";
}

}  // namespace
}  // namespace talus
