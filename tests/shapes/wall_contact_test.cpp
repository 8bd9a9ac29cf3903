// Superquadrics against planes, triangles, cylinders and cones.
#include "core/shapes/wall_contact.hpp"

#include <gtest/gtest.h>

#include "tests/shapes/shape_support.hpp"

namespace talus::shapes {
namespace {
using testing::Draw;

Body ball(double r, Vec3 x) { return make_body({{r, r, r}, 2, 2}, r, x, normalised({1, 2, 3, 4})); }

TEST(WallContact, ABallOnAPlaneIsTheSphereFormula) {
  const Vec3 n = (1 / 3.0) * Vec3{1, 2, 2};
  const WallContact c = plane_contact(ball(0.5, Vec3{1, 1, 1} + 0.48 * n), {1, 1, 1}, n);
  EXPECT_NEAR(c.overlap, 0.02, 1e-14);
  EXPECT_LT(norm(c.normal + n), 1e-15);
  EXPECT_LT(norm(c.point - (Vec3{1, 1, 1} - 0.01 * n)), 1e-14);
}

TEST(WallContact, NoPointOfTheBodyReachesFartherThroughThePlane) {
  Draw draw(51);
  for (int k = 0; k < 300; ++k) {
    const Superquadric s = draw.shape(2, 20, 10);
    const Quaternion q = draw.turn();
    const Body b = make_body(s, 1e9, draw.direction(), q);
    const Vec3 n = draw.direction(), on = draw.direction();
    const WallContact c = plane_contact(b, on, n);
    EXPECT_NEAR(dot(c.point - on, n), -0.5 * c.overlap, 1e-13);
    for (int t = 0; t < 200; ++t) {
      const Vec3 u = draw.direction(), x = b.centre + to_space(b.turn, (1 / testing::gauge(s, u)) * u);
      EXPECT_LE(-dot(x - on, n), c.overlap + 1e-12);
    }
  }
}

TEST(WallContact, ABallOnAFacetAnEdgeAndAVertexIsTheSphereFormula) {
  const Vec3 corner[3] = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  PairCount count;
  const auto touch = [&](Vec3 x) {
    PairMemory memory[3];
    return triangle_contact(ball(0.5, x), corner, memory, count);
  };
  for (const double side : {1.0, -1.0}) {
    const WallContact f = touch({0.5, 0.5, side * 0.45});
    EXPECT_NEAR(f.overlap, 0.05, 1e-13);
    EXPECT_LT(norm(f.normal - Vec3{0, 0, -side}), 1e-13);
    const WallContact e = touch({0.7, -0.3, side * 0.3});
    EXPECT_NEAR(e.overlap, 0.5 - std::sqrt(0.18), 2e-9);
    EXPECT_LT(norm(e.normal - std::sqrt(0.5) * Vec3{0, 1, -side}), 1e-8);
    const WallContact v = touch({2.2, -0.2, side * 0.2});
    EXPECT_NEAR(v.overlap, 0.5 - std::sqrt(0.12), 2e-9);
    EXPECT_LT(norm(v.normal - (1 / std::sqrt(3.0)) * Vec3{-1, 1, -side}), 1e-7);
  }
  EXPECT_LT(touch({3, -1, 0.2}).overlap, 0);
  EXPECT_LT(touch({0.5, 0.5, 0.51}).overlap, 0);
}

/// Depth of a point in a body: the least of h(n) - n . (x - centre), found by the search over directions.
double depth(const Body& b, Vec3 x, PairCount& count) {
  const Body point = make_body({{1e-9, 1e-9, 1e-9}, 2, 2}, 0, x, {});
  PairMemory memory;
  return solve_pair(b, point, memory, count, 10).overlap;
}

/// Largest value of a concave f on [0, 1].
template <class F>
double largest(F f, int rounds) {
  double low = 0, high = 1;
  for (int k = 0; k < rounds; ++k) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (f(a) < f(b))
      low = a;
    else
      high = b;
  }
  return f(0.5 * (low + high));
}

TEST(WallContact, TheTrianglesOverlapIsThatOfItsDeepestPoint) {
  Draw draw(52);
  PairCount count, points;
  int facet = 0, edge = 0;
  for (int k = 0; k < 60; ++k) {
    const Superquadric s = draw.shape(2, 20, 3);
    const Body b = make_body(s, 1e9, {}, draw.turn());
    Vec3 corner[3];
    const Vec3 u = draw.direction();
    for (Vec3& c : corner) c = 1.5 * draw.direction();
    // Move it so that it reaches a little into the body.
    const Vec3 middle = (1 / 3.0) * ((corner[0] + corner[1]) + corner[2]);
    double low = 0, high = 4;
    PairMemory memory[3];
    for (int it = 0; it < 30; ++it) {
      const double at = 0.5 * (low + high);
      Vec3 v[3];
      for (int c = 0; c < 3; ++c) v[c] = (corner[c] - middle) + at * u;
      PairMemory none[3];
      (triangle_contact(b, v, none, count).overlap > 0.01 ? low : high) = at;
    }
    for (Vec3& c : corner) c = (c - middle) + low * u;
    const WallContact c = triangle_contact(b, corner, memory, count);
    // The depth is concave over the triangle: a ternary search within a ternary search finds its largest value.
    const auto along = [&](double a) {
      return largest(
          [&](double w) {
            return depth(b, (a * corner[0] + (1 - a) * w * corner[1]) + (1 - a) * (1 - w) * corner[2], points);
          },
          24);
    };
    const double deepest = largest(along, 24);
    EXPECT_LE(deepest, c.overlap + 1e-7) << k;
    EXPECT_GT(deepest, c.overlap - 1e-3) << k;
    const Vec3 flat = cross(corner[1] - corner[0], corner[2] - corner[0]);
    (norm(cross(flat, c.normal)) < 1e-9 * norm(flat) ? facet : edge) += 1;
  }
  EXPECT_GT(facet, 3);
  EXPECT_GT(edge, 3);
}

TEST(WallContact, ABallInAndOutsideACylinderAndInAConeIsTheSphereFormula) {
  const ConeWall tube{{0, 0, 0}, {0, 0, 1}, 1, 0, 2};
  WallContact c[2];
  ASSERT_EQ(cone_contacts_inside(ball(0.5, {0, 1.52, 7}), tube, c), 1);
  EXPECT_NEAR(c[0].overlap, 0.02, 1e-13);
  EXPECT_LT(norm(c[0].normal - Vec3{0, 1, 0}), 1e-11);
  EXPECT_LT(norm(c[0].point - Vec3{0, 2.01, 7}), 1e-11);
  EXPECT_EQ(cone_contacts_inside(ball(0.5, {0, 1.4, 7}), tube, c), 0);
  const WallContact o = cylinder_contact_outside(ball(0.5, {0, 2.47, 7}), tube);
  EXPECT_NEAR(o.overlap, 0.03, 1e-13);
  EXPECT_LT(norm(o.normal - Vec3{0, -1, 0}), 1e-11);
  const ConeWall cone{{0, 0, 0}, {0, 0, 1}, 0.8, -0.6, 0};
  ASSERT_EQ(cone_contacts_inside(ball(0.5, {1, 0, 2.1}), cone, c), 1);  // distance to the wall 0.6 * 2.1 - 0.8 = 0.46
  EXPECT_NEAR(c[0].overlap, 0.04, 1e-13);
}

TEST(WallContact, ALongGrainTouchesATubeInTwoPlaces) {
  const ConeWall tube{{0, 0, 0}, {0, 0, 1}, 1, 0, 1};
  const Body rod = make_body({{1.02, 0.1, 0.1}, 2, 2}, 0.01, {0, 0, 0}, {});
  WallContact c[2];
  ASSERT_EQ(cone_contacts_inside(rod, tube, c), 2);
  EXPECT_NEAR(c[0].overlap, 0.02, 1e-12);
  EXPECT_NEAR(c[1].overlap, 0.02, 1e-12);
  EXPECT_NEAR(dot(c[0].normal, c[1].normal), -1, 1e-10);
}

}  // namespace
}  // namespace talus::shapes
