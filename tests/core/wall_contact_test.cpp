// Claims about the reduction of wall elements to contacts: one contact where the surface is smooth or convex, one per
// face where it is concave, the analytic plane's distance on coplanar facets, never NaN.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "wall_support.hpp"

namespace talus {
namespace {

using namespace wall_test;

constexpr double k_reach = 0.02;

TEST(WallContact, CoplanarFacetsAreOnePlane) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  const double z = 0.123456789;
  random_plane(30, 0.02, z, 7, points, facets);
  const std::string file = write_obj("coplanar.obj", points, facets);
  const WallSet mesh(scene_with({mesh_wall(file)}), k_reach);
  const WallSet plane(scene_with({plane_wall({0, 0, z}, {0, 0, 1})}), k_reach);
  const CounterRng rng(3, 1);
  for (std::uint64_t k = 0; k < 20000; ++k) {
    const double side = k % 2 == 0 ? 1 : -1;
    const Vec3 c{rng.uniform(3 * k, 0.05, 0.55), rng.uniform(3 * k + 1, 0.05, 0.55),
                 z + side * rng.uniform(3 * k + 2, 0.0099, 0.01)};
    const auto a = touch(mesh, c, 0.01), b = touch(plane, c, 0.01);
    ASSERT_EQ(a.size(), 1u) << "centre " << c.x << " " << c.y;
    ASSERT_EQ(b.size(), 1u);
    ASSERT_NEAR(a[0].distance, b[0].distance, 1e-13 * b[0].distance);
    ASSERT_NEAR(length(a[0].normal - b[0].normal), 0, 1e-13);
  }
}

TEST(WallContact, CentreExactlyOverEdgesAndVerticesHasOneContact) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0}};
  const std::string file = write_obj("fan.obj", points, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
  const WallSet walls(scene_with({mesh_wall(file)}), k_reach);
  for (const Vec3 c : {Vec3{0.5, 0.5, 0.009}, Vec3{0.25, 0.25, 0.009}, Vec3{0.75, 0.25, -0.009}}) {
    const auto a = touch(walls, c, 0.01);
    ASSERT_EQ(a.size(), 1u);
    EXPECT_DOUBLE_EQ(a[0].distance, 0.009);
    EXPECT_DOUBLE_EQ(a[0].normal.z, c.z > 0 ? 1 : -1);
  }
}

TEST(WallContact, TipOfACone) {
  // 24 or 48 facets larger than the sphere meet in the tip of a funnel: one smooth surface, one contact
  for (const int n : {24, 48}) {
    std::vector<Vec3> points{{0, 0, 0}};
    std::vector<std::array<int, 3>> facets;
    for (int k = 0; k < n; ++k) {
      points.push_back({0.06 * std::cos(2 * M_PI * k / n), 0.06 * std::sin(2 * M_PI * k / n), 0.06 * std::tan(0.21)});
      facets.push_back({0, k + 1, (k + 1) % n + 1});
    }
    const WallSet walls(scene_with({mesh_wall(write_obj("cone.obj", points, facets))}), k_reach);
    for (const Vec3 c : {Vec3{0, 0, 0.0101}, Vec3{1e-4, 5e-5, 0.0101}, Vec3{0, 0, 0.0099}}) {
      const auto a = touch(walls, c, 0.01);
      ASSERT_EQ(a.size(), 1u) << n;
      EXPECT_NEAR(a[0].normal.z, 1, 0.05) << n;
    }
  }
}

TEST(WallContact, WallsOfOneMaterialThatMoveAlikeAreOneSurface) {
  WallSpec drum = cone_wall({0, 0, 0}, {0, 0, 1}, 1, 0.5, 0.5), lid = drum, other = drum, still = drum, rough = drum;
  drum.motion.rotation_rate = lid.motion.rotation_rate = 2;
  other.motion.rotation_rate = 2, other.motion.rotation_origin = {1, 0, 0};
  rough.material = 1;
  Scene scene = scene_with({still, drum, other, lid, rough, still});
  scene.materials.resize(2);
  const WallSet walls(scene, k_reach);
  std::vector<int> surface;
  for (int k = 0; k < 6; ++k) surface.push_back(walls.surface(k));
  EXPECT_EQ(surface, (std::vector<int>{0, 1, 2, 1, 4, 0}));
}

TEST(WallContact, ConvexEdgeOfFiveDegreesHasOneContactAndATurningNormal) {
  // Ridge along y at x = 0; both flanks fall by 2.5 degrees.
  const double fall = std::tan(2.5 * M_PI / 180);
  const std::string file = write_stl("ridge.stl", {{Vec3{-1, -1, -fall}, Vec3{0, -1, 0}, Vec3{0, 1, 0}},
                                                   {Vec3{-1, -1, -fall}, Vec3{0, 1, 0}, Vec3{-1, 1, -fall}},
                                                   {Vec3{0, -1, 0}, Vec3{1, -1, -fall}, Vec3{1, 1, -fall}},
                                                   {Vec3{0, -1, 0}, Vec3{1, 1, -fall}, Vec3{0, 1, 0}}});
  const WallSet walls(scene_with({mesh_wall(file)}), 0.2);
  const double radius = 0.1, height = 0.0999;
  Vec3 last{};
  const int steps = 4000;
  for (int k = 0; k <= steps; ++k) {
    const double x = -0.02 + 0.04 * k / steps;
    const auto a = touch(walls, {x, 0.3, height - std::fabs(x) * fall}, radius);
    ASSERT_EQ(a.size(), 1u) << "x = " << x;
    if (k > 0) {
      ASSERT_LT(length(a[0].normal - last), 0.04 / steps / height * 1.5) << "x = " << x;
    }
    last = a[0].normal;
  }
  EXPECT_NEAR(std::asin(last.x) * 180 / M_PI, 2.5, 1e-4);
}

TEST(WallContact, ConcaveWedgeHasTwoContacts) {
  const std::string file = write_stl("wedge.stl", {{Vec3{-1, -1, 1}, Vec3{0, -1, 0}, Vec3{0, 1, 0}},
                                                   {Vec3{-1, -1, 1}, Vec3{0, 1, 0}, Vec3{-1, 1, 1}},
                                                   {Vec3{0, -1, 0}, Vec3{1, -1, 1}, Vec3{1, 1, 1}},
                                                   {Vec3{0, -1, 0}, Vec3{1, 1, 1}, Vec3{0, 1, 0}}});
  const WallSet walls(scene_with({mesh_wall(file)}), 0.2);
  const double d = 0.0999;
  const auto a = touch(walls, {0, 0.37, d * std::sqrt(2.0)}, 0.1);
  ASSERT_EQ(a.size(), 2u);
  EXPECT_LT(a[0].element, a[1].element);
  EXPECT_NEAR(a[0].distance, d, 1e-15);
  EXPECT_NEAR(a[1].distance, d, 1e-15);
  EXPECT_NEAR(dot(a[0].normal, a[1].normal), 0, 1e-12);
  EXPECT_NEAR(a[0].normal.z, std::sqrt(0.5), 1e-12);
}

TEST(WallContact, CornerOfThreeWallsHasThreeContactsAlsoInsideABox) {
  const double d = 0.0095;
  const WallSet planes(scene_with({plane_wall({0, 0, 0}, {1, 0, 0}), plane_wall({0, 0, 0}, {0, 1, 0}),
                                   plane_wall({0, 0, 0}, {0, 0, 1})}),
                       k_reach);
  const WallSet box(scene_with({box_wall({0, 0, 0}, {0.3, 0.2, 0.1})}), k_reach);
  for (const WallSet* w : {&planes, &box}) {
    const auto a = touch(*w, {d, d, d}, 0.01);
    ASSERT_EQ(a.size(), 3u);
    Vec3 sum;
    for (const WallContact& c : a) {
      EXPECT_NEAR(c.distance, d, 1e-16);
      sum = sum + c.normal;
    }
    EXPECT_NEAR(length(sum - Vec3{1, 1, 1}), 0, 1e-14);
  }
  EXPECT_EQ(planes.name(0), "plane");
  EXPECT_EQ(touch(planes, {d, d, d}, 0.01)[2].wall, 2);
}

TEST(WallContact, SphereOutsideABoxHasOneContactAtFaceEdgeAndCorner) {
  const WallSet walls(scene_with({box_wall({-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02})}), 0.05);
  const double r = 0.03, d = 0.0295;  // the sphere is larger than a facet: every diagonal is within reach
  const CounterRng rng(5, 1);
  for (std::uint64_t k = 0; k < 30000; ++k) {
    // A random point of the box surface inflated by d.
    Vec3 n{rng.uniform(6 * k, -1, 1), rng.uniform(6 * k + 1, -1, 1), rng.uniform(6 * k + 2, -1, 1)};
    Vec3 p{rng.uniform(6 * k + 3, -0.02, 0.02), rng.uniform(6 * k + 4, -0.02, 0.02),
           rng.uniform(6 * k + 5, -0.02, 0.02)};
    const int kind = static_cast<int>(k % 3);
    for (int axis = 0; axis < 3; ++axis)
      if (axis <= kind)
        p[axis] = n[axis] < 0 ? -0.02 : 0.02;
      else
        n[axis] = 0;
    n = (1 / length(n)) * n;
    const auto a = touch(walls, p + d * n, r);
    ASSERT_EQ(a.size(), 1u) << "kind " << kind << " n " << n.x << " " << n.y << " " << n.z;
    ASSERT_NEAR(a[0].distance, d, 1e-14);
    ASSERT_NEAR(length(a[0].normal - n), 0, 1e-12);
  }
}

TEST(WallContact, NeedleFacetsInAFanAreOnePlane) {
  for (const double aspect : {1e3, 1e4, 1e5, 1e6}) {
    // Needles from one apex to a far edge; a shallow slope along x keeps the numbers from being trivially round.
    std::vector<Vec3> points{{0, 0, 0}};
    std::vector<std::array<int, 3>> facets;
    for (int k = 0; k <= 200; ++k) points.push_back({1, 0.1 + k / aspect, 0.25});
    for (int k = 0; k < 200; ++k) facets.push_back({0, k + 1, k + 2});
    const WallSet mesh(scene_with({mesh_wall(write_obj("needles.obj", points, facets))}), k_reach);
    const WallSet plane(scene_with({plane_wall({0, 0, 0}, {-0.25, 0, 1})}), k_reach);
    const Vec3 n = (1 / std::sqrt(1.0625)) * Vec3{-0.25, 0, 1};
    const CounterRng rng(11, 1);
    for (std::uint64_t k = 0; k < 500; ++k) {
      const double x = rng.uniform(2 * k, 0.3, 0.9), s = rng.uniform(2 * k + 1, 0.001, 0.999);
      const Vec3 foot{x, x * (0.1 + 200 * s / aspect), 0.25 * x};
      const auto a = touch(mesh, foot + 0.00995 * n, 0.01), b = touch(plane, foot + 0.00995 * n, 0.01);
      ASSERT_EQ(a.size(), 1u) << "aspect " << aspect;
      ASSERT_NEAR(a[0].distance, b[0].distance, 1e-13 * 0.01) << "aspect " << aspect;
      ASSERT_NEAR(length(a[0].normal - n), 0, 1e-12) << "aspect " << aspect;
    }
  }
}

TEST(WallContact, TiltedNeedlesDoNotTakeTheirNormalFromRounding) {
  // The vertices of this plane are not representable in single precision; a needle of height 1e-6 alone would be off by
  // degrees, its coplanar patch is right to the rounding of the file.
  const Vec3 n = (1 / std::sqrt(1 + 0.09 + 0.16)) * Vec3{-0.3, -0.4, 1};
  auto on = [](double x, double y) { return Vec3{x, y, 0.3 * x + 0.4 * y}; };
  std::vector<Vec3> points{on(0, 0), on(0.9, -0.7)};
  std::vector<std::array<int, 3>> facets;
  for (int k = 0; k <= 100; ++k) points.push_back(on(0.9, 0.1 + k * 1e-6));
  facets.push_back({0, 1, 2});
  for (int k = 0; k < 100; ++k) facets.push_back({0, k + 2, k + 3});
  const WallSet mesh(scene_with({mesh_wall(write_obj("tilted.obj", points, facets))}), k_reach);
  for (int k = 0; k < 200; ++k) {
    const double x = 0.3 + 0.002 * k;
    const auto a = touch(mesh, on(x, x / 9 + x * 0.5e-4) + 0.0099 * n, 0.01);
    ASSERT_EQ(a.size(), 1u);
    EXPECT_NEAR(length(a[0].normal - n), 0, 1e-6);
    EXPECT_NEAR(a[0].distance, 0.0099, 2e-7);
  }
}

TEST(WallContact, DuplicatedFacetsAndWallsCountOnce) {
  const std::vector<Triangle> two{{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}},
                                  {Vec3{0, 1, 0}, Vec3{0, 0, 0}, Vec3{1, 0, 0}}};
  const std::string file = write_stl("twice.stl", two);
  const WallSet once(scene_with({mesh_wall(file)}), k_reach);
  EXPECT_EQ(once.element_count(), 1);
  WallSpec second = mesh_wall(file);
  second.name = "again";
  const WallSet both(scene_with({mesh_wall(file), second}), k_reach);
  EXPECT_EQ(both.element_count(), 2);
  for (const Vec3 c : {Vec3{0.3, 0.3, 0.009}, Vec3{0.3, -0.004, 0.008}, Vec3{-0.003, -0.004, 0.007}}) {
    ASSERT_EQ(touch(both, c, 0.01).size(), 1u);
    EXPECT_EQ(touch(both, c, 0.01)[0].wall, 0);
  }
}

TEST(WallContact, FineConcaveFilletHasNoContactAtAnEdgeThatIsNoMinimum) {
  // Floor, two narrow steps of 5 and 10 degrees, then a step down: the crest behind the fillet is within reach of the
  // sphere, but the surface leads down from it to the true contacts.
  std::vector<Vec3> profile{{-1, 0, 0}};
  double x = 0, z = 0;
  profile.push_back({x, 0, z});
  for (const double angle : {5.0, 10.0}) {
    x += 0.002 * std::cos(angle * M_PI / 180), z += 0.002 * std::sin(angle * M_PI / 180);
    profile.push_back({x, 0, z});
  }
  profile.push_back({x, 0, -1});
  std::vector<Triangle> t;
  for (std::size_t k = 0; k + 1 < profile.size(); ++k) {
    const Vec3 a = profile[k], b = profile[k + 1], y{0, 1, 0};
    t.push_back({a - y, b - y, b + y});
    t.push_back({a - y, b + y, a + y});
  }
  const WallSet walls(scene_with({mesh_wall(write_stl("fillet.stl", t))}), 0.2);
  // The foot of the centre is on the floor, 1.5 radians-widths of the first step before it; no step projects.
  const auto a = touch(walls, {-0.02, 0, 0.0995}, 0.1035);
  for (const WallContact& c : a) EXPECT_NEAR(c.normal.z, 1, 1e-9);
  ASSERT_EQ(a.size(), 1u);
}

TEST(WallContact, CylinderFromInsideAndOutside) {
  const WallSet walls(scene_with({cone_wall({0.1, 0.2, 0.3}, {1, 2, 2}, 0.6, 0.25, 0.25)}), 0.05);
  const Vec3 axis = (1.0 / 3) * Vec3{1, 2, 2}, across = (1 / std::sqrt(5.0)) * Vec3{-2, 1, 0};
  const Vec3 middle = Vec3{0.1, 0.2, 0.3} + 0.3 * axis;
  const auto inside = touch(walls, middle + 0.24 * across, 0.011);
  ASSERT_EQ(inside.size(), 1u);
  EXPECT_NEAR(inside[0].distance, 0.01, 1e-15);
  EXPECT_NEAR(length(inside[0].normal + across), 0, 1e-13);
  const auto outside = touch(walls, middle + 0.26 * across, 0.011);
  ASSERT_EQ(outside.size(), 1u);
  EXPECT_NEAR(length(outside[0].normal - across), 0, 1e-13);
  // Beyond the end: the rim, at 45 degrees.
  const auto rim = touch(walls, Vec3{0.1, 0.2, 0.3} - 0.006 * axis + 0.256 * across, 0.011);
  ASSERT_EQ(rim.size(), 1u);
  EXPECT_NEAR(rim[0].distance, 0.006 * std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(dot(rim[0].normal, axis), -std::sqrt(0.5), 1e-12);
  EXPECT_TRUE(touch(walls, middle, 0.011).empty());
}

TEST(WallContact, ConeFaceAndRimAtTheOrificeJoinSmoothly) {
  // Hopper: cylinder of radius 0.1 above a 45 degree cone down to an orifice of radius 0.02 at z = 0.
  const WallSet walls(
      scene_with({cone_wall({0, 0, 0}, {0, 0, 1}, 0.08, 0.02, 0.1), cone_wall({0, 0, 0.08}, {0, 0, 1}, 0.2, 0.1, 0.1)}),
      k_reach);
  const double r = 0.005, d = 0.0049;
  Vec3 last;
  for (int k = 0; k <= 1000; ++k) {
    // Along the inflated surface: down the cone, then round the rim.
    const double turn = k <= 500 ? 0 : (k - 500) / 500.0 * 0.4 * M_PI;
    const double up = k <= 500 ? 0.02 * (500 - k) / 500.0 : 0;
    const double angle = 0.75 * M_PI + turn;  // of the inward normal in the (rho, z) plane
    const Vec3 c{0.02 + up + d * std::cos(angle), 0, up + d * std::sin(angle)};
    const auto a = touch(walls, c, r);
    ASSERT_EQ(a.size(), 1u) << k;
    ASSERT_NEAR(a[0].distance, d, 1e-14);
    if (k > 0) {
      ASSERT_LT(length(a[0].normal - last), 0.004) << k;
    }
    last = a[0].normal;
  }
  // In the concave junction of cone and cylinder: one contact with each.
  const double z = 0.08 - d + d * std::sqrt(2.0);
  const auto two = touch(walls, {0, 0.1 - d, z}, r);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0].wall, 0);
  EXPECT_EQ(two[1].wall, 1);
  EXPECT_NEAR(two[0].distance, d, 1e-14);
  EXPECT_NEAR(two[1].distance, d, 1e-14);
}

TEST(WallContact, FlatRingAndDiscAreConesOfNoLength) {
  const WallSet walls(
      scene_with({cone_wall({0, 0, 0}, {0, 0, 1}, 0, 0.1, 0.03), cone_wall({0, 0, -1}, {0, 0, 1}, 0, 0.1, 0)}),
      k_reach);
  const auto flat = touch(walls, {0.05, 0.01, 0.004}, 0.005);
  ASSERT_EQ(flat.size(), 1u);
  EXPECT_NEAR(flat[0].normal.z, 1, 1e-15);
  EXPECT_NEAR(flat[0].distance, 0.004, 1e-16);
  EXPECT_TRUE(touch(walls, {0, 0, 0.001}, 0.005).empty());  // the orifice
  const auto rim = touch(walls, {0.027, 0, 0.003}, 0.005);
  ASSERT_EQ(rim.size(), 1u);
  EXPECT_NEAR(rim[0].normal.x, -std::sqrt(0.5), 1e-12);
  const auto disc = touch(walls, {0, 0, -0.996}, 0.005);  // on the axis
  ASSERT_EQ(disc.size(), 1u);
  EXPECT_NEAR(disc[0].normal.z, 1, 1e-15);
}

TEST(WallContact, DegeneratePositionsHaveAFiniteRepeatableUnitNormal) {
  const std::string file = write_stl("one.stl", {{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}});
  std::vector<std::vector<WallSpec>> sets{{mesh_wall(file)},
                                          {plane_wall({0, 0, 0}, {0, 0, 1})},
                                          {cone_wall({0, 0, 0}, {0, 0, 1}, 0.5, 0.004, 0.004)},
                                          {cone_wall({0, 0, 0}, {0, 0, 1}, 0.5, 0, 0.3)},
                                          {box_wall({0, 0, 0}, {1, 1, 1})}};
  for (const auto& set : sets) {
    const WallSet walls(scene_with(set), k_reach);
    for (const Vec3 c : {Vec3{0, 0, 0}, Vec3{0.25, 0.25, 0}, Vec3{0.5, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 0, 0.25},
                         Vec3{1e-320, 0, 0}, Vec3{1e-170, 1e-170, 1e-170}}) {
      const auto a = touch(walls, c, 0.01), b = touch(walls, c, 0.01);
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t k = 0; k < a.size(); ++k) {
        EXPECT_NEAR(length(a[k].normal), 1, 1e-14);
        EXPECT_TRUE(std::isfinite(a[k].distance));
        EXPECT_EQ(a[k].normal.x, b[k].normal.x);
      }
    }
  }
}

TEST(WallContact, MoreThanSixteenFeaturesIsAnError) {
  // Twenty parallel plates pierce the sphere's shell at different places: a comb of needles around the centre.
  std::vector<Triangle> comb;
  for (int k = 0; k < 20; ++k) {
    const double a = 2 * M_PI * k / 20, x = 0.0095 * std::cos(a), y = 0.0095 * std::sin(a);
    comb.push_back({Vec3{x, y, 0}, Vec3{2 * x, 2 * y, -0.001}, Vec3{2 * x, 2 * y, 0.001}});
  }
  const WallSet walls(scene_with({mesh_wall(write_stl("comb.stl", comb))}), k_reach);
  EXPECT_THROW(touch(walls, {0, 0, 0}, 0.01), Error);
  EXPECT_EQ(touch(walls, {0.0005, 0, 0}, 0.00901).size(), 1u);
}

TEST(WallContact, DomainSidesFollowTheScenesOwnWalls) {
  Scene s = scene_with({box_wall({0, 0, 0}, {1, 1, 1})});
  s.domain.boundary[0] = {Boundary::wall, Boundary::open};
  s.domain.boundary[2] = {Boundary::wall, Boundary::wall};
  s.domain.wall_material = 0;
  const WallSet walls(s, k_reach);
  ASSERT_EQ(walls.size(), 4);
  EXPECT_EQ(walls.name(1), "domain_x_lower");
  EXPECT_EQ(walls.name(3), "domain_z_upper");
  EXPECT_EQ(walls.element_count(), 15);
  const auto a = touch(walls, {-1.995, 0.5, 1.994}, 0.01);
  ASSERT_EQ(a.size(), 2u);
  EXPECT_EQ(a[0].normal.x, 1);
  EXPECT_EQ(a[1].normal.z, -1);
  EXPECT_FALSE(walls.any_moving());
}

TEST(WallContact, ImpossibleGeometryIsRefused) {
  EXPECT_THROW(WallSet(scene_with({plane_wall({0, 0, 0}, {0, 0, 0})}), k_reach), Error);
  EXPECT_THROW(WallSet(scene_with({cone_wall({0, 0, 0}, {0, 0, 1}, 0, 0.1, 0.1)}), k_reach), Error);
  EXPECT_THROW(WallSet(scene_with({cone_wall({0, 0, 0}, {0, 0, 0}, 1, 0.1, 0.1)}), k_reach), Error);
  EXPECT_THROW(WallSet(scene_with({box_wall({0, 0, 0}, {1, 0, 1})}), k_reach), Error);
  EXPECT_THROW(WallSet(scene_with({plane_wall({NAN, 0, 0}, {0, 0, 1})}), k_reach), Error);
  const std::string far = write_stl("far.stl", {{Vec3{0, 0, 0}, Vec3{1000, 0, 0}, Vec3{0, 1000, 0}}});
  WallSpec w = mesh_wall(far);
  w.shift = {0, 0, 50};
  EXPECT_THROW(WallSet(scene_with({w}), k_reach), Error);  // wholly outside the domain: wrong unit
}

}  // namespace
}  // namespace talus
