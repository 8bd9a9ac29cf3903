// Superquadrics at planes, boxes and meshes: a ball meets them as a sphere does; nothing jumps at seams and edges.
#include "core/shapes/body_walls.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/scene/scene_file.hpp"
#include "core/shapes/wall_contact.hpp"
#include "tests/shapes/shape_support.hpp"

namespace talus::shapes {
namespace {

using testing::Draw;

/// A floor, a block on it and a ramp of a thin block that leans on nothing.
Scene scene_of() {
  return parse_scene(
      "gravity = [0, 0, 0]\n[domain]\nlower = [0, 0, 0]\nupper = [20, 20, 20]\n[time]\nstep = 1e-5\nduration = "
      "1\n[[material]]\nname = \"m\"\ndensity = 1\n[contact]\nnormal_stiffness = 1\nrestitution = 1\nfriction = 0\n"
      "[[wall]]\nname = \"block\"\nshape = \"box\"\nlower = [6, 6, 0]\nupper = [12, 13, 4]\n[[wall]]\nname = "
      "\"plate\"\nshape = \"box\"\nlower = [14, 3, 5]\nupper = [17, 15, 5.4]\n[[source]]\nkind = \"random\"\nnumber = "
      "1\n[source.region]\nlower = [1, 1, 8]\nupper = [5, 5, 12]\n[source.size]\ndiameter = 1\n",
      "test", "", {});
}

/// A tube of radius 5 along z instead of them.
Scene tube_scene() {
  Scene scene = scene_of();
  scene.walls.clear();
  WallSpec tube;
  tube.name = "tube";
  tube.shape = WallShape::cylinder;
  tube.point = {10, 10, -1};
  tube.axis = {0, 0, 1};
  tube.length = 22;
  tube.radius = 5;
  scene.walls.push_back(tube);
  return scene;
}

struct Walls {
  WallSet set;
  Walls() : set(scene_of(), 4, 4) { set.set_step(0, 1e-5); }
  std::vector<BodyWallContact> contacts(const Body& body, double bound) const {
    std::vector<std::int32_t> near;
    set.candidates(body.centre, bound, near);
    std::vector<BodyWallContact> out;
    body_wall_contacts(body, bound, set, near, {}, out);
    return out;
  }
};

TEST(BodyWalls, BallMeetsThemAsASphereDoes) {
  const Walls walls;
  Draw draw(5);
  Superquadric ball;
  int compared = 0, several = 0, edges = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vec3 c{draw.uniform(0.2, 19.8), draw.uniform(0.2, 19.8), draw.uniform(0.2, 8)};
    std::vector<std::int32_t> near;
    walls.set.candidates(c, 1, near);
    talus::WallContact sphere[WallSet::k_max_contacts];
    const int n = walls.set.contacts(c, 1, near, sphere);
    bool shallow = n > 0;
    for (int q = 0; q < n; ++q) shallow = shallow && sphere[q].distance > 0.5;
    if (!shallow) continue;  // in a wall, or far from all
    const auto found = walls.contacts(make_body(ball, 1, c, draw.turn()), 1);
    ++compared;
    several += n > 1;
    ASSERT_EQ(found.size(), static_cast<std::size_t>(n)) << c.x << " " << c.y << " " << c.z;
    for (int q = 0; q < n; ++q) {
      const talus::WallContact& a = found[static_cast<std::size_t>(q)].contact;
      EXPECT_EQ(a.wall, sphere[q].wall);
      EXPECT_NEAR(a.distance, sphere[q].distance, 2e-9);
      EXPECT_LT(norm(a.normal - sphere[q].normal), 1e-6);
      edges += std::fabs(a.normal.x) < 0.99 && std::fabs(a.normal.y) < 0.99 && std::fabs(a.normal.z) < 0.99;
      const Vec3 arm = found[static_cast<std::size_t>(q)].arm;
      EXPECT_LT(norm(arm + a.distance * a.normal), 1e-7);
    }
  }
  EXPECT_GT(compared, 2000);
  EXPECT_GT(several, 200);
  EXPECT_GT(edges, 100);
}

// Edges that a direction parts and triangles behind a face that is met are not asked: nothing may be lost by that.
TEST(BodyWalls, ABodyMeetsSomethingExactlyWhereSomeFacetIsMet) {
  const Walls walls;
  Draw draw(9);
  int met = 0, apart = 0, by_edges = 0;
  for (int k = 0; k < 1000; ++k) {
    Superquadric s = draw.shape(2, k % 2 == 0 ? 2 : 20, 4);
    const double bound = bounding_radius(s);
    // about the borders of the block and of the plate
    const bool block = k % 4 < 2;
    const Vec3 low = block ? Vec3{6, 6, 2} : Vec3{14, 3, 5}, high = block ? Vec3{12, 13, 4} : Vec3{17, 15, 5.4};
    Vec3 c;
    for (int q = 0; q < 3; ++q) c[q] = (draw.uniform() < 0.5 ? low : high)[q] + draw.uniform(-1, 1);
    const Body body = make_body(s, smallest_radius(s), c, draw.turn());
    std::vector<std::int32_t> near;
    walls.set.candidates(c, bound, near);
    std::vector<WallPiece> pieces;
    walls.set.pieces(c, near, pieces, {});
    double deepest = -1;
    bool face = false;
    PairCount count;
    for (const WallPiece& p : pieces) {
      PairMemory none[3];
      const bool plane = p.kind == WallPiece::Kind::plane;
      const double side = plane && dot(c - p.corner[0], p.normal) < 0 ? -1 : 1;
      const shapes::WallContact w =
          plane ? plane_contact(body, p.corner[0], side * p.normal) : triangle_contact(body, p.corner, none, count);
      face = face || (w.overlap > 0 &&
                      fmax2(std::fabs(w.normal.x), fmax2(std::fabs(w.normal.y), std::fabs(w.normal.z))) > 1 - 1e-12);
      deepest = fmax2(deepest, w.overlap);
    }
    if (std::fabs(deepest) < 1e-7 * bound) continue;  // within rounding of touch
    EXPECT_EQ(walls.contacts(body, bound).empty(), !(deepest > 0)) << k << ": " << deepest;
    ++(deepest > 0 ? met : apart);
    by_edges += deepest > 0 && !face;
  }
  EXPECT_GT(met, 120);
  EXPECT_GT(apart, 120);
  EXPECT_GT(by_edges, 25);
}

/// Least of the body's gauge over the surface of a box: below 1 where some point of it lies in the body. The gauge is
/// convex, so that its place on a face is found by ever finer grids.
double least_gauge(const Superquadric& s, const Body& body, Vec3 low, Vec3 high) {
  double least = 1e300;
  for (int axis = 0; axis < 3; ++axis)
    for (const double at : {low[axis], high[axis]}) {
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      double from[2] = {low[a], low[b]}, to[2] = {high[a], high[b]}, best[2] = {from[0], from[1]}, value = 1e300;
      for (int level = 0; level < 6; ++level) {
        constexpr int n = 10;
        for (int i = 0; i <= n; ++i)
          for (int j = 0; j <= n; ++j) {
            Vec3 x;
            x[axis] = at;
            x[a] = from[0] + (to[0] - from[0]) * i / n;
            x[b] = from[1] + (to[1] - from[1]) * j / n;
            const double g = testing::gauge(s, to_body(body.turn, x - body.centre));
            if (g < value) value = g, best[0] = x[a], best[1] = x[b];
          }
        const double lower[2] = {low[a], low[b]}, upper[2] = {high[a], high[b]};
        for (int k = 0; k < 2; ++k) {
          const double step = (to[k] - from[k]) / n;
          from[k] = fmax2(lower[k], best[k] - 3 * step);
          to[k] = fmin2(upper[k], best[k] + 3 * step);
        }
      }
      least = fmin2(least, value);
    }
  return least;
}

// The deepest point of a long body that leans over a rim hangs beyond the side below, which the body does not reach.
TEST(BodyWalls, ALongBodyMeetsABoxExactlyWhereItReachesIt) {
  const Walls walls;
  const Vec3 low{6, 6, 2}, high{12, 13, 4};
  Draw draw(19);
  int met = 0, apart = 0;
  for (int k = 0; k < 600; ++k) {
    const Superquadric s = draw.shape(2, 20, 10);
    const double bound = bounding_radius(s);
    Vec3 c;
    for (int q = 0; q < 3; ++q) c[q] = (draw.uniform() < 0.5 ? low : high)[q] + draw.uniform(-1, 1);
    if (c.z - bound < 0.01 || c.x + bound > 13.99) continue;  // floor and plate
    const Body body = make_body(s, smallest_radius(s), c, draw.turn());
    const double gauge = least_gauge(s, body, {6, 6, 0}, high);
    if (std::fabs(gauge - 1) < 1e-3) continue;
    EXPECT_EQ(walls.contacts(body, bound).empty(), gauge > 1) << k << ": " << gauge;
    ++(gauge < 1 ? met : apart);
  }
  EXPECT_GT(met, 100);
  EXPECT_GT(apart, 50);
}

TEST(BodyWalls, BallMeetsACylinderAsASphereDoesFromInsideAndOutside) {
  const Scene scene = tube_scene();
  WallSet set(scene, 4, 4);
  set.set_step(0, 1e-5);
  Draw draw(6);
  int inside = 0, outside = 0;
  for (int k = 0; k < 3000; ++k) {
    const double phi = 2 * M_PI * draw.uniform(), from = draw.uniform(4.2, 5.8);
    if (std::fabs(from - 5) < 0.3) continue;
    const Vec3 c{10 + from * std::cos(phi), 10 + from * std::sin(phi), draw.uniform(4, 16)};
    std::vector<std::int32_t> near;
    set.candidates(c, 1, near);
    talus::WallContact sphere[WallSet::k_max_contacts];
    const int n = set.contacts(c, 1, near, sphere);
    std::vector<BodyWallContact> found;
    body_wall_contacts(make_body(Superquadric{}, 1, c, draw.turn()), 1, set, near, {}, found);
    ASSERT_EQ(found.size(), static_cast<std::size_t>(n));
    ASSERT_EQ(n, 1);
    EXPECT_NEAR(found[0].contact.distance, sphere[0].distance, 1e-9);
    EXPECT_LT(norm(found[0].contact.normal - sphere[0].normal), 1e-9);
    EXPECT_LT(norm(found[0].arm + sphere[0].distance * sphere[0].normal), 1e-8);
    (from < 5 ? inside : outside) += 1;
  }
  EXPECT_GT(inside, 500);
  EXPECT_GT(outside, 500);
}

TEST(BodyWalls, NeedleBridgesACylinderWithBothEnds) {
  const Scene scene = tube_scene();
  WallSet set(scene, 4, 4);
  set.set_step(0, 1e-5);
  Superquadric needle;
  needle.axes = {3, 0.3, 0.3};
  // a chord: its tips reach 0.01 through the wall where the normals fit
  const double y = 10 - std::sqrt(25 - 9.0) + 0.02;
  std::vector<std::int32_t> near;
  set.candidates({10, y, 8}, 3.01, near);
  std::vector<BodyWallContact> found;
  body_wall_contacts(make_body(needle, smallest_radius(needle), {10, y, 8}, {}), 3.01, set, near, {}, found);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0].contact.distance, found[1].contact.distance, 1e-9);
  EXPECT_NEAR(found[0].contact.normal.x, -found[1].contact.normal.x, 1e-9);
  EXPECT_NEAR(found[0].contact.normal.y, found[1].contact.normal.y, 1e-9);
  EXPECT_GT(found[0].contact.normal.y, 0.5);
}

/// Sum of overlap times normal, as a force of stiffness 1, and the torque of it.
struct Load {
  Vec3 force, torque;
  int contacts = 0;
};
Load load_at(const Walls& walls, const Superquadric& s, Quaternion turn, Vec3 c) {
  Load l;
  for (const BodyWallContact& w : walls.contacts(make_body(s, smallest_radius(s), c, turn), bounding_radius(s))) {
    const Vec3 f = (bounding_radius(s) - w.contact.distance) * w.contact.normal;
    l.force = l.force + f;
    l.torque = l.torque + cross(w.arm, f);
    ++l.contacts;
  }
  return l;
}

TEST(BodyWalls, NothingJumpsWhereABodySlidesOverSeamsAndEdges) {
  const Walls walls;
  Draw draw(9);
  int met = 0;
  for (int k = 0; k < 8; ++k) {
    Superquadric s = draw.shape(2, k % 2 == 0 ? 2.0 : 4.0, 2);
    const Quaternion turn = draw.turn();
    // sinks 0.01 deep over the top of the block: along its diagonal, where two facets meet, and out over an edge
    const Body upright = make_body(s, 1, {}, turn);
    const Vec3 m = to_body(upright.turn, {0, 0, -1});
    const double height = 4 + support_point(s, m).h - 0.01;
    const Vec3 from{9, 9.4, height}, to{draw.uniform(12.5, 14), draw.uniform(7, 12), height};
    constexpr int k_steps = 400;
    const double step = norm(to - from) / k_steps;
    Load last = load_at(walls, s, turn, from);
    EXPECT_EQ(last.contacts, 1);
    EXPECT_NEAR(last.force.z, 0.01, 1e-9);
    double leap = 0, twist = 0;
    for (int i = 1; i <= k_steps; ++i) {
      const Load now = load_at(walls, s, turn, from + (static_cast<double>(i) / k_steps) * (to - from));
      leap = fmax2(leap, norm(now.force - last.force));
      twist = fmax2(twist, norm(now.torque - last.torque));
      last = now;
    }
    met += last.contacts == 0;
    EXPECT_LT(leap, 3 * step) << k;
    EXPECT_LT(twist, 6 * step) << k;
  }
  EXPECT_GT(met, 3) << "some have left the block";
}

}  // namespace
}  // namespace talus::shapes
