// Claims about sources among walls: nothing is placed into a wall, wherever it is at that time; an initial file is
// judged against walls as against grains; what cannot be placed is said with numbers.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/error.hpp"
#include "core/grains/insertion.hpp"
#include "core/grains/region.hpp"
#include "core/grains/source_notes.hpp"
#include "core/grains/source_walls.hpp"
#include "core/walls/closed_surface.hpp"
#include "core/walls/wall_mesh.hpp"
#include "wall_support.hpp"

namespace talus {
namespace {

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}

/// Domain [1, 2]^3 with open sides, so that only the walls of the test count.
Scene open_scene(const std::vector<WallSpec>& walls) {
  Scene s;
  s.dt = 1e-3;
  s.steps = 10000;
  s.domain.lower = {1, 1, 1};
  s.domain.upper = {2, 2, 2};
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.materials = {{"glass", 2500, 0, 0}};
  s.pairs.assign(1, {});
  s.walls = walls;
  return s;
}

Source pack(const Scene& scene, Source::Kind kind, double diameter, std::int64_t number) {
  Source s;
  s.kind = kind;
  s.name = "pack";
  s.region = {scene.domain.lower, scene.domain.upper, 0};
  s.size.diameter = diameter;
  s.number = number;
  return s;
}

WallSet walls_of(const Scene& scene) { return WallSet(in_stored_frame(scene), 0.2); }

/// Deepest overlap of any particle with any wall, by the contacts that the engine would find [radii].
double deepest(const Scene& scene, const WallSet& walls, const NewParticles& p) {
  double most = 0;
  for (std::size_t i = 0; i < p.size(); ++i)
    for (const WallContact& c : wall_test::touch(walls, p.x[i] - scene.domain.lower, p.r[i]))
      most = std::max(most, (p.r[i] - c.distance) / p.r[i]);
  return most;
}

std::string cube_file() {
  const Mesh m = box_mesh({1.3, 1.3, 1.3}, {1.7, 1.7, 1.7});
  std::vector<std::array<int, 3>> facets;
  for (const auto& f : m.facets) facets.push_back({f[0], f[1], f[2]});
  return wall_test::write_obj("insertion_cube.obj", m.points, facets);
}

std::vector<WallSpec> one_of_each() {
  return {wall_test::plane_wall({1.5, 1.5, 1.5}, {1, 2, 3}), wall_test::box_wall({1.3, 1.3, 1.3}, {1.7, 1.7, 1.7}),
          wall_test::cone_wall({1.5, 1.5, 1.1}, {0, 0, 1}, 0.8, 0.3, 0.3),
          wall_test::cone_wall({1.5, 1.5, 1.1}, {1, 0, 1}, 0.5, 0.3, 0.1), wall_test::mesh_wall(cube_file())};
}

TEST(InsertionWalls, EveryKindOfSourceKeepsClearOfEveryKindOfWall) {
  for (const WallSpec& wall : one_of_each())
    for (const Source::Kind kind : {Source::Kind::lattice, Source::Kind::random, Source::Kind::stream}) {
      Scene s = open_scene({wall});
      s.sources = {pack(s, kind, 0.05, kind == Source::Kind::lattice ? 0 : 600)};
      if (kind == Source::Kind::stream) s.sources[0].interval = 0.1, s.sources[0].number_rate = 6000;
      const WallSet walls = walls_of(s);
      Insertion free(s), kept(s);
      const auto run = [&](Insertion& i, const WallSet* w) {
        return kind == Source::Kind::stream ? i.batch(0, {}, w) : i.initial(w);
      };
      EXPECT_GT(deepest(s, walls, run(free, nullptr)), 0.5) << wall.name;
      const NewParticles p = run(kept, &walls);
      EXPECT_GT(p.size(), 200u);
      EXPECT_LT(deepest(s, walls, p), 2e-6) << wall.name << " " << static_cast<int>(kind);
    }
}

TEST(InsertionWalls, TouchingIsAllowedWhereTheSceneSaysSo) {
  Scene s = open_scene({wall_test::plane_wall({1.5, 1.5, 1.5}, {1, 0, 0})});
  s.sources = {pack(s, Source::Kind::random, 0.05, 600)};
  s.sources[0].allow_wall_overlap = true;
  const WallSet walls = walls_of(s);
  const NewParticles with = Insertion(s).initial(&walls), without = Insertion(s).initial();
  EXPECT_GT(deepest(s, walls, with), 0.5);
  for (std::size_t i = 0; i < with.size(); ++i) EXPECT_EQ(with.x[i].x, without.x[i].x);
}

TEST(InsertionWalls, ASourceThatIsClearAnywayIsPlacedToTheSameBits) {
  Scene s = open_scene(one_of_each());
  for (WallSpec& w : s.walls) w.motion.velocity = {0, 0, 1};
  s.sources = {pack(s, Source::Kind::random, 0.02, 100), pack(s, Source::Kind::lattice, 0.02, 0)};
  s.sources[0].region = {{1, 1, 1}, {1.1, 1.2, 1.1}, 0};
  s.sources[1].region = {{1.9, 1.9, 1.05}, {2, 2, 1.15}, 0};
  s.walls[0].point = {1.5, 1.5, 1.9};
  s.walls[0].normal = {0, 0, 1};
  const WallSet walls = walls_of(s);
  const NewParticles a = Insertion(s).initial(&walls), b = Insertion(s).initial();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int k = 0; k < 3; ++k) EXPECT_EQ(a.x[i][k], b.x[i][k]);
}

TEST(InsertionWalls, AWallCountsWhereItIsWhenTheBatchComes) {
  WallSpec moving = wall_test::box_wall({1.3, 1.3, 1.3}, {1.7, 1.7, 1.7});
  moving.motion.velocity = {0, 0, 0.1};
  moving.motion.rotation_axis = {0, 0, 1};
  moving.motion.rotation_origin = {1.5, 1.5, 1.5};
  moving.motion.rotation_rate = 0.3;
  Scene s = open_scene({moving});
  s.sources = {pack(s, Source::Kind::random, 0.05, 700)};
  s.sources[0].start = 2;
  WallSet walls = walls_of(s);
  Insertion insertion(s);
  const std::int64_t n = insertion.next_step(0);
  ASSERT_EQ(n, 2000);
  walls.set_step(n, s.dt);
  const NewParticles p = insertion.batch(n, {}, &walls);
  ASSERT_EQ(p.size(), 700u);
  EXPECT_LT(deepest(s, walls, p), 2e-6);
  walls.set_step(0, s.dt);
  EXPECT_GT(deepest(s, walls, p), 0.5);
}

TEST(InsertionWalls, AWallCountsOnlyWhileItActs) {
  WallSpec gate = wall_test::plane_wall({1.5, 1.5, 1.5}, {1, 0, 0});
  gate.appear = 0.5;
  gate.vanish = 1.5;
  Scene s = open_scene({gate});
  s.sources = {pack(s, Source::Kind::random, 0.05, 700)};
  for (const double start : {0.1, 1.0, 2.0}) {
    s.sources[0].start = start;
    WallSet walls = walls_of(s);
    Insertion insertion(s);
    const std::int64_t n = insertion.next_step(0);
    walls.set_step(n, s.dt);
    const NewParticles p = insertion.batch(n, {}, &walls);
    walls.set_step(1000, s.dt);
    const bool acts = start == 1.0;
    EXPECT_EQ(deepest(s, walls, p) < 2e-6, acts) << start;
  }
}

TEST(InsertionWalls, ALatticeFlushWithAMeshInSinglePrecisionKeepsItsFirstLayer) {
  // 1.1 is no single-precision number: read from such a file the floor lies 2e-8 above it.
  const double floor = static_cast<float>(1.1);
  ASSERT_GT(floor, 1.1);
  const std::string file = wall_test::write_obj(
      "insertion_floor.obj", {{0.5, 0.5, floor}, {2.5, 0.5, floor}, {2.5, 2.5, floor}, {0.5, 2.5, floor}},
      {{0, 1, 2}, {0, 2, 3}});
  Scene s = open_scene({wall_test::mesh_wall(file)});
  s.sources = {pack(s, Source::Kind::lattice, 0.05, 0)};
  s.sources[0].region.lower.z = 1.1;
  s.sources[0].lattice = Source::Lattice::cubic;
  s.sources[0].spacing = 1;
  const WallSet walls = walls_of(s);
  EXPECT_EQ(Insertion(s).initial(&walls).size(), Insertion(s).initial().size());
}

TEST(InsertionWalls, ASphereAcrossAMeshOfManySmallFacetsIsRefusedNotAnError) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  wall_test::random_plane(60, 0.005, 0, 7, points, facets);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = points[i] + Vec3{1.35, 1.35, 1.5 + 0.002 * (i % 5)};
  Scene s = open_scene({wall_test::mesh_wall(wall_test::write_obj("insertion_fine.obj", points, facets))});
  s.sources = {pack(s, Source::Kind::random, 0.1, 100)};
  s.sources[0].region = {{1.35, 1.35, 1.2}, {1.65, 1.65, 1.8}, 0};
  s.sources[0].number = 10;
  const WallSet walls = walls_of(s);
  const NewParticles p = Insertion(s).initial(&walls);
  EXPECT_EQ(p.size(), 10u);
  for (std::size_t i = 0; i < p.size(); ++i) EXPECT_GT(std::abs(p.x[i].z - 1.504), 0.04);
}

TEST(InsertionWalls, WhatFindsNoRoomBesideWallsIsSaidWithNumbers) {
  // The box takes all but the rim of the region.
  Scene s = open_scene({wall_test::box_wall({1.1, 1.1, 1.1}, {1.9, 1.9, 1.9})});
  s.sources = {pack(s, Source::Kind::random, 0.15, 100)};
  s.sources[0].region = {{1, 1, 1}, {1.24, 2, 2}, 0};
  s.sources[0].closed_walls = Source::ClosedWalls::inside;
  s.sources[0].number = 20;
  const WallSet walls = walls_of(s);
  std::string text = refusal([&] { Insertion(s).initial(&walls); });
  EXPECT_CONTAINS(text, "source 'pack': only 0 of 20 particles fitted at random");
  EXPECT_CONTAINS(text, "tries met a wall or lay on the wrong side of closed walls");
}

TEST(InsertionWalls, AFullPackAndABlockedLatticeSayHowManyFittedAndThatWallsWereMet) {
  // Two planes leave a slot that is too narrow for any sphere.
  Scene s =
      open_scene({wall_test::plane_wall({1, 1, 1.45}, {0, 0, 1}), wall_test::plane_wall({1, 1, 1.55}, {0, 0, 1})});
  s.sources = {pack(s, Source::Kind::random, 0.12, 5)};
  s.sources[0].region = {{1, 1, 1.42}, {2, 2, 1.58}, 0};
  const WallSet walls = walls_of(s);
  const std::string random = refusal([&] { Insertion(s).initial(&walls); });
  EXPECT_CONTAINS(random,
                  "source 'pack': only 0 of 5 particles fitted at random (solid fraction 0.000 of the region; ");
  EXPECT_CONTAINS(random, "tries met a wall)");
  s.sources[0].kind = Source::Kind::lattice;
  EXPECT_CONTAINS(refusal([&] { Insertion(s).initial(&walls); }),
                  "only 0 particles fitted on the lattice, 5 were asked for (");
  s.sources[0].number = 0;
  EXPECT_CONTAINS(refusal([&] { Insertion(s).initial(&walls); }), "only 0 particles fitted on the lattice (");
}

TEST(InsertionWalls, AStreamThatWallsBlockSaysPlacedOfWanted) {
  Scene s = open_scene({wall_test::plane_wall({1, 1, 1.5}, {0, 0, 1})});
  s.sources = {pack(s, Source::Kind::stream, 0.1, 0)};
  s.sources[0].region = {{1, 1, 1.42}, {2, 2, 1.58}, 0};
  s.sources[0].number_rate = 100;
  s.sources[0].interval = 0.1;
  const WallSet walls = walls_of(s);
  Insertion insertion(s);
  EXPECT_EQ(insertion.batch(0, {}, &walls).size(), 0u);
  ASSERT_EQ(insertion.shortfalls().size(), 1u);
  EXPECT_EQ(insertion.shortfalls()[0].placed, 0);
  EXPECT_EQ(insertion.shortfalls()[0].wanted, 10);
  insertion.batch(100, {}, &walls);
  EXPECT_EQ(insertion.shortfalls()[0].wanted, 20);  // what was due stays due
  WallSet own = walls_of(s);
  const std::vector<std::string> notes = later_shortfalls(s, own);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_CONTAINS(notes[0], "source 'pack': 0 of 10 particles due were placed");
}

TEST(InsertionWalls, APackThatWillFindNoRoomLaterIsForeseen) {
  Scene s = open_scene({wall_test::plane_wall({1, 1, 1.5}, {0, 0, 1})});
  s.sources = {pack(s, Source::Kind::random, 0.1, 5)};
  s.sources[0].region = {{1, 1, 1.42}, {2, 2, 1.58}, 0};
  s.sources[0].start = 1;
  WallSet walls = walls_of(s);
  const std::vector<std::string> notes = later_shortfalls(s, walls);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_CONTAINS(notes[0], "step 1000: the run would end: source 'pack': only 0 of 5 particles");
  s.walls[0].vanish = 0.5;
  WallSet gone = walls_of(s);
  EXPECT_TRUE(later_shortfalls(s, gone).empty());
}

TEST(InsertionWalls, ARegionThroughAPeriodicSideIsFilledOnBothSides) {
  Scene s = open_scene({});
  s.domain.boundary[0] = {Boundary::periodic, Boundary::periodic};
  Source q = pack(s, Source::Kind::random, 0.04, 250);
  q.region = Region{};
  q.region.shape = Region::Shape::sphere;
  q.region.point = {1.05, 1.5, 1.5};
  q.region.radius = 0.2;
  set_bounds(q.region);
  s.sources = {q};
  const NewParticles p = Insertion(s).initial();
  int low = 0, high = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_GE(p.x[i].x, 1);
    EXPECT_LT(p.x[i].x, 2);
    low += p.x[i].x < 1.25;
    high += p.x[i].x > 1.85;
    EXPECT_TRUE(inside(s.domain, q.region, p.x[i]));
    for (std::size_t j = 0; j < i; ++j) {
      Vec3 d = p.x[i] - p.x[j];
      d.x -= std::round(d.x);
      EXPECT_GE(std::sqrt(norm2(d)), 0.04 * (1 - 1e-12));
    }
  }
  EXPECT_EQ(low + high, 250);
  EXPECT_GT(low, 50);
  EXPECT_GT(high, 50);
}

// --- regions

TEST(InsertionRegions, PacksAndLatticesLieInEveryShapeAsAWhole) {
  Region cylinder;
  cylinder.shape = Region::Shape::cylinder;
  cylinder.point = {1.3, 1.3, 1.3};
  cylinder.axis = {1, 1, 1};
  cylinder.length = 0.6;
  cylinder.radius = 0.2;
  set_bounds(cylinder);
  Region sphere;
  sphere.shape = Region::Shape::sphere;
  sphere.point = {1.5, 1.5, 1.5};
  sphere.radius = 0.3;
  set_bounds(sphere);
  Region mesh;
  mesh.shape = Region::Shape::mesh;
  mesh.file = cube_file();
  load_region(mesh, "", "test");
  for (const Region& g : {cylinder, sphere, mesh})
    for (const Source::Kind kind : {Source::Kind::lattice, Source::Kind::random, Source::Kind::stream}) {
      Scene s = open_scene({});
      s.sources = {pack(s, kind, 0.03, kind == Source::Kind::lattice ? 0 : 500)};
      s.sources[0].region = g;
      if (kind == Source::Kind::stream) s.sources[0].interval = 0.1, s.sources[0].number_rate = 5000;
      Insertion insertion(s);
      const NewParticles p = kind == Source::Kind::stream ? insertion.batch(0, {}) : insertion.initial();
      EXPECT_GE(p.size(), 500u);
      for (std::size_t i = 0; i < p.size(); ++i) {
        EXPECT_TRUE(holds(s.domain, g, p.x[i], p.r[i])) << static_cast<int>(g.shape);
        // six points of the sphere's surface, a little within
        for (int k = 0; k < 3; ++k)
          for (const double side : {-0.999, 0.999}) {
            Vec3 x = p.x[i];
            x[k] += side * p.r[i];
            EXPECT_TRUE(inside(g, x));
          }
      }
    }
}

TEST(InsertionRegions, ARegionTooNarrowForTheParticlesIsRefused) {
  Scene s = open_scene({});
  s.sources = {pack(s, Source::Kind::random, 0.1, 1)};
  Region& g = s.sources[0].region;
  g.shape = Region::Shape::cylinder;
  g.point = {1.5, 1.5, 1.5};
  g.axis = {1, 1, 0};
  g.length = 0.09;
  g.radius = 0.2;
  set_bounds(g);
  EXPECT_CONTAINS(refusal([&] { Insertion{s}; }), "the cylinder is shorter than the largest particle");
  g.length = 0.2;
  g.radius = 0.04;
  set_bounds(g);
  EXPECT_CONTAINS(refusal([&] { Insertion{s}; }), "the region is 0.08 m wide, the largest particle 0.1 m");
}

// --- closed walls

TEST(InsertionClosedWalls, GrainsGoToTheSideThatIsAskedFor) {
  for (const bool mesh : {false, true}) {
    WallSpec cube = mesh ? wall_test::mesh_wall(cube_file()) : wall_test::box_wall({1.3, 1.3, 1.3}, {1.7, 1.7, 1.7});
    Scene s = open_scene({cube});
    s.sources = {pack(s, Source::Kind::random, 0.04, 200)};
    WallSet walls = walls_of(s);
    const auto inside_count = [&](Source::ClosedWalls side) {
      s.sources[0].closed_walls = side;
      const NewParticles p = Insertion(s).initial(&walls);
      EXPECT_EQ(p.size(), 200u);
      EXPECT_LT(deepest(s, walls, p), 2e-6);
      return std::count_if(p.x.begin(), p.x.end(), [](Vec3 x) {
        return std::max({std::abs(x.x - 1.5), std::abs(x.y - 1.5), std::abs(x.z - 1.5)}) < 0.2;
      });
    };
    EXPECT_EQ(inside_count(Source::ClosedWalls::outside), 0);
    EXPECT_EQ(inside_count(Source::ClosedWalls::inside), 200);
    const auto both = inside_count(Source::ClosedWalls::both);
    EXPECT_GT(both, 0);
    EXPECT_LT(both, 50);
  }
}

TEST(InsertionClosedWalls, InsideNeedsAWallThatEncloses) {
  Scene s = open_scene({wall_test::plane_wall({1.5, 1.5, 1.5}, {1, 0, 0})});
  s.sources = {pack(s, Source::Kind::random, 0.04, 10)};
  s.sources[0].closed_walls = Source::ClosedWalls::inside;
  EXPECT_CONTAINS(refusal([&] { Insertion{s}; }), "closed_walls = \"inside\", but no wall is closed");
}

TEST(InsertionClosedWalls, TheSideFollowsTheWallsPose) {
  WallSpec cube = wall_test::box_wall({1.3, 1.3, 1.3}, {1.7, 1.7, 1.7});
  cube.motion.velocity = {0.1, 0, 0};
  cube.motion.rotation_axis = {0, 0, 1};
  cube.motion.rotation_origin = {1.3, 1.5, 1.5};
  cube.motion.rotation_rate = 0.2;
  Scene s = open_scene({cube});
  s.sources = {pack(s, Source::Kind::random, 0.03, 100)};
  s.sources[0].closed_walls = Source::ClosedWalls::inside;
  s.sources[0].start = 1;
  WallSet walls = walls_of(s);
  walls.set_step(1000, s.dt);
  const NewParticles p = Insertion(s).batch(1000, {}, &walls);
  ASSERT_EQ(p.size(), 100u);
  const double c = std::cos(0.2), q = std::sin(0.2);
  for (const Vec3 x : p.x) {  // back to the cube at rest
    const Vec3 d = x - Vec3{1.4, 1.5, 1.5};
    const Vec3 b{c * d.x + q * d.y, -q * d.x + c * d.y, d.z};
    EXPECT_TRUE(b.x > 0 && b.x < 0.4 && std::abs(b.y) < 0.2 && std::abs(b.z) < 0.2);
  }
}

TEST(InsertionClosedWalls, ARegionOnBothSidesOfAClosedWallIsSaid) {
  Scene s = open_scene({wall_test::box_wall({1.3, 1.3, 1.3}, {1.7, 1.7, 1.7})});
  s.sources = {pack(s, Source::Kind::random, 0.04, 100)};
  const auto notes = [&] {
    WallSet walls = walls_of(s);
    return sides_of_closed_walls(s, walls);
  };
  ASSERT_EQ(notes().size(), 1u);
  EXPECT_CONTAINS(notes()[0], "source 'pack': about 6.");
  EXPECT_CONTAINS(notes()[0], "% of its region lies inside the closed wall \"box\", the rest outside");
  s.sources[0].closed_walls = Source::ClosedWalls::outside;  // decided: nothing to say
  EXPECT_TRUE(notes().empty());
  s.sources[0].closed_walls = Source::ClosedWalls::both;
  s.sources[0].region = {{1.3, 1.3, 1.3}, {1.7, 1.7, 1.7}, 0};  // a container, filled to its faces
  EXPECT_TRUE(notes().empty());
  s.sources[0].region = {{1, 1, 1}, {2, 2, 1.3}, 0};  // under it
  EXPECT_TRUE(notes().empty());
  s.walls[0] = wall_test::box_wall({1.499, 1.499, 1.099}, {1.501, 1.501, 1.101});  // far smaller than the samples
  ASSERT_EQ(notes().size(), 1u);
  EXPECT_CONTAINS(notes()[0], "a small part of its region lies inside");
  s.walls[0].appear = 1;
  EXPECT_TRUE(notes().empty());
}

TEST(InsertionOpenWalls, ARegionOnBothSidesOfAPlaneATubeOrAConeIsSaid) {
  Scene s = open_scene({});
  s.sources = {pack(s, Source::Kind::random, 0.04, 100)};
  s.sources[0].region = {{1, 1, 1}, {2, 2, 2}, 0};
  const auto notes = [&](const WallSpec& wall) {
    s.walls = {wall};
    WallSet walls = walls_of(s);
    return sides_of_open_walls(s, walls);
  };
  WallSpec tube;
  tube.name = "tube";
  tube.shape = WallShape::cylinder;
  tube.point = {1.5, 1.5, 0.9};
  tube.length = 1.2;
  tube.radius = 0.4;
  ASSERT_EQ(notes(tube).size(), 1u);  // pi (0.4 - r)^2 within, 0.96^2 - pi (0.4 + r)^2 around it; r = 0.02
  EXPECT_CONTAINS(notes(tube)[0], "source 'pack': about ");
  EXPECT_CONTAINS(notes(tube)[0], "near wall \"tube\" lies within it, the rest around it");
  const double share = std::stod(notes(tube)[0].substr(std::string("source 'pack': about ").size()));
  const double within = 3.14159265 * 0.38 * 0.38, beyond = 0.96 * 0.96 - 3.14159265 * 0.42 * 0.42;
  EXPECT_NEAR(share, 100 * within / (within + beyond), 3);
  tube.radius = 0.8;  // around all of it
  EXPECT_TRUE(notes(tube).empty());
  tube.radius = 0.015;  // a rod that no grain fits into
  EXPECT_TRUE(notes(tube).empty());
  tube.radius = 0.4, tube.point.z = 2;  // above
  EXPECT_TRUE(notes(tube).empty());
  tube.point.z = 0.9, tube.motion.velocity = {1, 0, 0}, s.sources[0].start = 0.95;  // has left by then
  EXPECT_TRUE(notes(tube).empty());
  s.sources[0].start = 0;
  WallSpec cone = tube;
  cone.name = "hopper", cone.shape = WallShape::cone, cone.radius = 0.1, cone.radius_end = 0.9, cone.motion = {};
  EXPECT_EQ(notes(cone).size(), 1u);
  WallSpec plane = wall_test::plane_wall({1.5, 1.5, 1.3}, {0, 0, 1});
  plane.name = "floor";
  ASSERT_EQ(notes(plane).size(), 1u);
  EXPECT_CONTAINS(notes(plane)[0], "near wall \"floor\" lies behind it, the rest before it");
  plane.point.z = 1.02;  // half of a grain is behind: none finds room there
  EXPECT_TRUE(notes(plane).empty());
}

// --- initial files

class WallFile : public ::testing::Test {
 protected:
  /// A scene whose file has these rows and whose floor is the domain's wall at z = 1.
  Scene scene(const std::string& rows, const std::vector<WallSpec>& walls = {}) {
    Scene s = open_scene(walls);
    s.domain.boundary[2][0] = Boundary::wall;
    Source q;
    q.kind = Source::Kind::file;
    q.name = "state";
    q.file = wall_test::write_file("insertion_state.csv", "x,y,z,r,vx,vy,vz\n" + rows);
    s.sources = {q};
    return s;
  }
  std::string said(const Scene& s) {
    const WallSet walls = walls_of(s);
    return refusal([&] { Insertion(s).initial(&walls); });
  }
};

TEST_F(WallFile, AnOverlapWithAWallIsRefusedWithRowWallAndDepth) {
  const Scene s = scene("1.5,1.5,1.5,0.1,0,0,0\n1.2,1.2,1.055,0.1,0,0,0\n");
  EXPECT_CONTAINS(said(s), "insertion_state.csv:3 and wall \"domain_z_lower\" by 0.045 m (0.45 of the radius)");
  EXPECT_CONTAINS(said(s), "1 initial overlaps deeper than 0.05 of the smaller radius");
}

TEST_F(WallFile, WallsAndGrainsAreListedTogetherByRow) {
  const Scene s = scene("1.5,1.5,1.5,0.1,0,0,0\n1.65,1.5,1.5,0.1,0,0,0\n1.2,1.2,1.7,0.1,0,0,0\n",
                        {wall_test::box_wall({1.1, 1.1, 1.75}, {1.3, 1.3, 1.9}), wall_test::mesh_wall(cube_file())});
  const std::string text = said(s);
  EXPECT_CONTAINS(text, "insertion_state.csv:2 and ");
  EXPECT_CONTAINS(text, ":3 by 0.05 m (0.5 of the smaller radius)");
  EXPECT_CONTAINS(text, ":3 and wall \"mesh\" by 0.05 m (0.5 of the radius)");
  EXPECT_CONTAINS(text, ":4 and wall \"box\" by 0.05 m (0.5 of the radius)");
  EXPECT_CONTAINS(text, "3 initial overlaps");
}

TEST_F(WallFile, BothPermissionsTreatWallsAsGrains) {
  Scene s = scene("1.2,1.2,1.055,0.1,0,0,0\n");
  s.allow_initial_overlap = true;
  EXPECT_EQ(said(s), "accepted");
  s.max_overlap = 0.4;
  EXPECT_CONTAINS(said(s), "deeper than 0.4");
  s.allow_initial_overlap = false;
  s.relax.steps = 10;
  EXPECT_EQ(said(s), "accepted");
  Scene shallow = scene("1.2,1.2,1.0951,0.1,0,0,0\n");  // 4.9 % of the radius: a bed at rest
  EXPECT_EQ(said(shallow), "accepted");
}

TEST_F(WallFile, OnlyWallsThatActAtTheStartCount) {
  WallSpec gate = wall_test::plane_wall({1, 1, 1.5}, {0, 0, 1});
  gate.appear = 1;
  EXPECT_EQ(said(scene("1.5,1.5,1.5,0.1,0,0,0\n", {gate})), "accepted");
  gate.appear = 0;
  EXPECT_CONTAINS(said(scene("1.5,1.5,1.52,0.1,0,0,0\n", {gate})), "wall \"plane\" by 0.08 m");
}

// --- numbers that can never fit

TEST(InsertionLimits, ImpossibleNumbersAreRefusedBeforeAnythingIsDrawn) {
  Scene s = open_scene({});
  s.sources = {pack(s, Source::Kind::random, 0.04, 100000000)};
  const auto said = [&] { return refusal([&] { Insertion{s}; }); };
  EXPECT_CONTAINS(said(),
                  "source 'pack': 100000000 particles are asked for, about 11340 fit into the region at random");
  s.sources[0].number = 1000000000000;
  EXPECT_CONTAINS(said(), "1000000000000 particles are asked for, about 11340 fit into the region at random");
  s.sources[0].number = 0;
  s.sources[0].mass = 1e9;
  EXPECT_CONTAINS(said(),
                  "1e+09 kg are asked for, about 1.19e+10 particles, about 11340 fit into the region at random");
  s.sources[0].mass = 0;
  s.sources[0].kind = Source::Kind::lattice;
  s.sources[0].number = 1000000000000;
  s.sources[0].lattice = Source::Lattice::cubic;
  EXPECT_CONTAINS(said(), "at most 12167 fit on this lattice");  // 23 cells of 0.042 per side
  s.sources[0].kind = Source::Kind::stream;
  s.sources[0].interval = 0.1;
  s.sources[0].number_rate = 1e12;
  EXPECT_CONTAINS(said(), "1e+11 particles are due in every interval, about 11340 fit into the region at random");
}

TEST(InsertionLimits, MemoryIsJudgedBeforeItIsTaken) {
  Scene s = open_scene({});
  for (int k = 0; k < 3; ++k) s.domain.upper[k] = 1e6;
  s.sources = {pack(s, Source::Kind::random, 0.04, 1000000000)};  // 600 GB, and room for them
  EXPECT_CONTAINS(refusal([&] { Insertion{s}; }), "a start with 1e+09 particles needs about 558.8 GiB of memory");
  s.sources[0].number = 2000000000;
  EXPECT_CONTAINS(refusal([&] { Insertion{s}; }), "2e+09 particles, at most 2^30 = 1073741824 are possible");
  s.sources[0].kind = Source::Kind::lattice;
  s.sources[0].number = 0;  // as many as there are sites: 1e22
  EXPECT_CONTAINS(refusal([&] { Insertion{s}; }), "particles, at most 2^30");
}

TEST(InsertionLimits, WhatFitsIsNeverRefusedByItsNumber) {
  // One sphere may fill its region; a full lattice and a dense pack are placed.
  Scene s = open_scene({});
  s.sources = {pack(s, Source::Kind::random, 0.1, 1)};
  Region& g = s.sources[0].region;
  g.shape = Region::Shape::sphere;
  g.point = {1.5, 1.5, 1.5};
  g.radius = 0.05 * (1 + 1e-3);
  set_bounds(g);
  EXPECT_EQ(refusal([&] { Insertion{s}; }), "accepted");
  Scene full = open_scene({});
  full.sources = {pack(full, Source::Kind::lattice, 0.05, 0)};
  full.sources[0].spacing = 1;
  const std::size_t sites = Insertion(full).initial().size();
  full.sources[0].number = static_cast<std::int64_t>(sites);
  EXPECT_EQ(Insertion(full).initial().size(), sites);
}

}  // namespace
}  // namespace talus
