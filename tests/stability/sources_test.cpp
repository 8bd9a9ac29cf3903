// Claims about sources during a run: what finds no room among walls and grains is said, never left out silently.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "scheduler/simulation.hpp"

namespace talus {
namespace {

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

/// A box of 0.1 m with walls on all sides, cut by a plane at half its height.
Scene cut_box() {
  Scene s;
  s.domain.upper = {0.1, 0.1, 0.1};
  s.dt = 1e-5;
  s.steps = 1000;
  s.gravity = {0, 0, -9.81};
  s.materials = {{"glass", 2500, 0, 0}};
  s.contact.normal_stiffness = 2000;
  s.contact.friction = false;
  s.pairs.assign(1, {});
  WallSpec cut;
  cut.name = "cut";
  cut.point = {0, 0, 0.05};
  s.walls = {cut};
  return s;
}

Source grains(Source::Kind kind, double low, double high) {
  Source q;
  q.kind = kind;
  q.name = "rain";
  q.region = {{0, 0, low}, {0.1, 0.1, high}, 0};
  q.size.diameter = 0.01;
  return q;
}

std::string end_of(Simulation& s, std::int64_t steps, ErrorCode code) {
  try {
    s.run(steps);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), code);
    return e.what();
  }
  return "ran on";
}

TEST(Sources, APackThroughWallsStartsWithoutAnyOverlap) {
  Scene s = cut_box();
  s.sources = {grains(Source::Kind::random, 0, 0.1)};
  s.sources[0].number = 400;
  s.output.energies = true;
  s.gravity = {};
  Simulation simulation(s, {});
  simulation.run(200);
  EXPECT_EQ(simulation.particles(), 400);
  EXPECT_EQ(simulation.energies().elastic, 0);
  EXPECT_EQ(simulation.kinetic_energy(), 0);  // nothing was pushed
}

TEST(Sources, AStreamWithoutRoomIsWarnedOfOnceWithNumbers) {
  Scene s = cut_box();
  s.sources = {grains(Source::Kind::stream, 0.044, 0.056)};  // no sphere of 0.01 beside the plane
  s.sources[0].number_rate = 1e5;
  s.sources[0].interval = 1e-4;
  Simulation simulation(s, {});
  simulation.run(100);
  EXPECT_EQ(simulation.particles(), 0);
  const auto& all = simulation.warnings();
  ASSERT_EQ(std::count_if(all.begin(), all.end(), [](const Warning& w) { return w.kind == "stream rain"; }), 1);
  EXPECT_CONTAINS(all.back().text,
                  "step 0: source 'rain': 0 of 10 particles due were placed, the others found no room");
  EXPECT_EQ(all.back().count, 10);
  EXPECT_EQ(all.back().worst, 100);
}

TEST(Sources, ALatePackWithoutRoomEndsTheRunAtItsStepAndKeepsTheState) {
  Scene s = cut_box();
  s.sources = {grains(Source::Kind::random, 0.06, 0.09), grains(Source::Kind::random, 0.044, 0.056)};
  s.sources[0].number = 20;
  s.sources[1].number = 3;
  s.sources[1].name = "late";
  s.sources[1].start = 1e-3;
  Simulation simulation(s, {});
  const std::string text = end_of(simulation, 200, ErrorCode::physics);
  EXPECT_CONTAINS(text, "step 100: source 'late': only 0 of 3 particles fitted at random");
  EXPECT_EQ(simulation.step(), 100);
  EXPECT_EQ(simulation.frame({}).id.size(), 20u);
}

TEST(Sources, ARegionOnBothSidesOfABoxIsWarnedOf) {
  Scene s = cut_box();
  s.walls[0].shape = WallShape::box;
  s.walls[0].lower = {0.03, 0.03, 0.03};
  s.walls[0].upper = {0.07, 0.07, 0.07};
  s.sources = {grains(Source::Kind::random, 0, 0.1)};
  s.sources[0].number = 100;
  const Simulation both(s, {});
  ASSERT_EQ(both.warnings().size(), 1u);
  EXPECT_CONTAINS(both.warnings()[0].text, "lies inside the closed wall \"cut\", the rest outside");
  s.sources[0].closed_walls = Source::ClosedWalls::outside;
  EXPECT_TRUE(Simulation(s, {}).warnings().empty());
}

TEST(Sources, EventsTakeGrainsInRegionsOfEveryShape) {
  Scene s = cut_box();
  s.walls.clear();
  s.gravity = {};
  s.sources = {grains(Source::Kind::lattice, 0, 0.1)};
  Region ball;
  ball.shape = Region::Shape::sphere;
  ball.point = {0.05, 0.05, 0.05};
  ball.radius = 0.03;
  ball.lower = ball.point - Vec3{0.03, 0.03, 0.03};
  ball.upper = ball.point + Vec3{0.03, 0.03, 0.03};
  s.groups = {{"ball", false, ball, {}}};
  Event out;
  out.action = Event::Action::remove;
  out.group = 0;
  s.events = {out};
  Simulation simulation(s, {});
  const std::int64_t before = simulation.particles();
  simulation.run(1);
  const Frame f = simulation.frame({});
  EXPECT_LT(f.id.size(), static_cast<std::size_t>(before));
  EXPECT_GT(f.id.size(), 300u);
  for (const Vec3 x : f.x) EXPECT_GT(norm(x - ball.point), 0.03);
}

}  // namespace
}  // namespace talus
