// Claims about regions: what lies inside box, cylinder, sphere and mesh, how large they are, how they continue through
// periodic sides, and what is refused.
#include "core/grains/region.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/base/error.hpp"
#include "core/base/rng.hpp"
#include "core/grains/curved_share.hpp"
#include "core/scene/scene_file.hpp"
#include "core/walls/closed_surface.hpp"
#include "core/walls/wall_mesh.hpp"
#include "wall_support.hpp"

namespace talus {
namespace {

constexpr double k_pi = 3.14159265358979323846;

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

Region box_region(Vec3 lower, Vec3 upper, double radius = 0) { return Region{lower, upper, radius}; }

Region cylinder_region(Vec3 point, Vec3 axis, double length, double radius) {
  Region g;
  g.shape = Region::Shape::cylinder;
  g.point = point;
  g.axis = axis;
  g.length = length;
  g.radius = radius;
  set_bounds(g);
  return g;
}

Region sphere_region(Vec3 centre, double radius) {
  Region g;
  g.shape = Region::Shape::sphere;
  g.point = centre;
  g.radius = radius;
  set_bounds(g);
  return g;
}

Region mesh_region(Mesh mesh) {
  check_mesh(mesh, 0);
  Region g;
  g.shape = Region::Shape::mesh;
  g.surface = std::make_shared<const ClosedSurface>(mesh);
  set_bounds(g);
  return g;
}

Mesh merged(const Mesh& a, const Mesh& b) {
  Mesh m = a;
  const auto base = static_cast<std::int32_t>(a.points.size());
  m.points.insert(m.points.end(), b.points.begin(), b.points.end());
  for (auto f : b.facets) {
    for (auto& v : f) v += base;
    m.facets.push_back(f);
  }
  return m;
}

/// Ring of square section about the z axis, n sides: concave, with a hole.
Mesh ring(int n, double inner, double outer, double height) {
  Mesh m;
  for (int i = 0; i < n; ++i) {
    const double a = 2 * k_pi * i / n;
    for (const double r : {inner, outer})
      for (const double z : {0.0, height}) m.points.push_back({r * std::cos(a), r * std::sin(a), z});
  }
  const auto quad = [&](int a, int b, int c, int d) {
    m.facets.push_back({a, b, c});
    m.facets.push_back({a, c, d});
  };
  for (int i = 0; i < n; ++i) {
    const int p = 4 * i, q = 4 * ((i + 1) % n);
    quad(p, p + 1, q + 1, q);          // inner side
    quad(p + 2, q + 2, q + 3, p + 3);  // outer side
    quad(p, q, q + 2, p + 2);          // bottom
    quad(p + 1, p + 3, q + 3, q + 1);  // top
  }
  return m;
}

Domain periodic_domain() {
  Domain d;
  d.boundary[0] = {Boundary::periodic, Boundary::periodic};
  return d;
}

TEST(Region, BoxAndUprightCylinderIncludeTheirBorder) {
  const Region box = box_region({0, 0, 0}, {1, 2, 3});
  EXPECT_TRUE(inside(box, {0, 0, 0}));
  EXPECT_TRUE(inside(box, {1, 2, 3}));
  EXPECT_FALSE(inside(box, {1, 2, std::nextafter(3, 4)}));
  const Region upright = box_region({0, 0, 0}, {2, 2, 3}, 0.5);
  EXPECT_TRUE(inside(upright, {1.5, 1, 3}));
  EXPECT_FALSE(inside(upright, {1.4, 1.4, 1}));
  EXPECT_NEAR(volume(upright), k_pi * 0.25 * 3, 1e-14);
}

TEST(Region, CylinderAboutAnyAxisHasTwoEndsAndARim) {
  const Vec3 axis{1, 2, 2};  // length 3
  const Region g = cylinder_region({0.1, -0.2, 0.3}, axis, 6, 0.5);
  const Vec3 u = (1.0 / 3) * axis, across{2 / std::sqrt(5.0), -1 / std::sqrt(5.0), 0};
  for (const double along : {-0.01, 0.01, 3.0, 5.99, 6.01})
    for (const double out : {0.0, 0.49, 0.51})
      EXPECT_EQ(inside(g, g.point + along * u + out * across), along > 0 && along < 6 && out < 0.5) << along << out;
  EXPECT_NEAR(volume(g), k_pi * 0.25 * 6, 1e-13);
  for (int k = 0; k < 3; ++k) {  // the bounds are the narrowest: a point of the rim reaches each of them
    const double half = 0.5 * std::sqrt(1 - u[k] * u[k]);
    EXPECT_NEAR(g.lower[k], g.point[k] - half, 1e-14);
    EXPECT_NEAR(g.upper[k], g.point[k] + 6 * u[k] + half, 1e-14);
  }
}

TEST(Region, SphereHoldsWhatIsNearerThanItsRadius) {
  const Region g = sphere_region({1, 2, 3}, 0.5);
  EXPECT_TRUE(inside(g, {1.5, 2, 3}));
  EXPECT_FALSE(inside(g, {1.3, 2.3, 3.3}));
  EXPECT_TRUE(holds(Domain{}, g, {1.2, 2, 3}, 0.3 - 1e-12));
  EXPECT_FALSE(holds(Domain{}, g, {1.2, 2, 3}, 0.3 + 1e-12));
  EXPECT_NEAR(volume(g), k_pi / 6, 1e-15);
}

TEST(Region, SpheresAreHeldAsAWholeByEveryShape) {
  const Domain d;
  const Region g = cylinder_region({0, 0, 0}, {0, 1, 0}, 2, 0.5);
  EXPECT_TRUE(holds(d, g, {0.2, 0.3, 0.2}, 0.2));
  EXPECT_FALSE(holds(d, g, {0.2, 0.1, 0.2}, 0.2));  // end
  EXPECT_FALSE(holds(d, g, {0.3, 0.5, 0.3}, 0.2));  // rim
  EXPECT_FALSE(holds(d, g, {0, 1, 0}, 0.6));        // wider than the cylinder
  const Region cube = mesh_region(box_mesh({0, 0, 0}, {1, 1, 1}));
  EXPECT_TRUE(holds(d, cube, {0.5, 0.5, 0.3}, 0.29));
  EXPECT_FALSE(holds(d, cube, {0.5, 0.5, 0.3}, 0.31));
  EXPECT_FALSE(holds(d, cube, {0.5, 0.5, 1.5}, 0.1));
}

TEST(Region, MeshOfABoxAgreesWithTheBoxAlsoAboveItsEdgesAndVertices) {
  const Region cube = mesh_region(box_mesh({0, 0, 0}, {1, 1, 1}));
  for (int i = -1; i <= 9; ++i)
    for (int j = -1; j <= 9; ++j)
      for (int k = -1; k <= 9; ++k) {
        // the grid lies on edges, diagonals and vertices seen from above, and off the faces in z
        const Vec3 x{i / 8.0, j / 8.0, (k + 0.5) / 8};
        if (i == 0 || i == 8 || j == 0 || j == 8) continue;  // on the surface: either answer
        EXPECT_EQ(inside(cube, x), i > 0 && i < 8 && j > 0 && j < 8 && k >= 0 && k < 8) << i << j << k;
      }
  EXPECT_NEAR(volume(cube), 1, 1e-15);
}

TEST(Region, RaysThroughVerticesAndEdgesOfARingCountRight) {
  const int n = 24;
  const Region g = mesh_region(ring(n, 0.5, 1, 0.25));
  EXPECT_NEAR(volume(g), 0.25 * 0.5 * n * std::sin(2 * k_pi / n) * (1 - 0.25), 1e-14);
  int in = 0;
  for (int i = 0; i < n; ++i)
    for (const double share : {0.0, 0.5})
      for (const double r : {0.4, 0.55, 0.75, 0.95, 1.05})
        for (const double z : {-0.1, 0.1, 0.3}) {
          const double a = 2 * k_pi * (i + share) / n;
          const bool expected = r > 0.5 && r < 1 && z > 0 && z < 0.25;
          EXPECT_EQ(inside(g, {r * std::cos(a), r * std::sin(a), z}), expected) << i << " " << r << " " << z;
          in += expected;
        }
  EXPECT_EQ(in, n * 2 * 3);
  // Points that share their plan view with a vertex to the bit, above and below it.
  for (const Vec3 v : ring(n, 0.5, 1, 0.25).points) {
    EXPECT_FALSE(inside(g, {v.x, v.y, 0.3}));
    EXPECT_FALSE(inside(g, {v.x, v.y, -0.1}));
  }
}

TEST(Region, AShellWithinAShellBoundsAHollow) {
  const Region g =
      mesh_region(merged(box_mesh({0, 0, 0}, {1, 1, 1}), box_mesh({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75})));
  EXPECT_TRUE(inside(g, {0.1, 0.5, 0.5}));
  EXPECT_FALSE(inside(g, {0.5, 0.5, 0.5}));
  EXPECT_TRUE(inside(g, {0.5, 0.5, 0.1}));
  EXPECT_NEAR(volume(g), 1 - 0.125, 1e-15);
}

TEST(Region, WindingOfTheFacetsAndPlaceInSpaceDoNotMatter) {
  Mesh m = ring(12, 0.5, 1, 0.25);
  for (std::size_t f = 0; f < m.facets.size(); f += 3) std::swap(m.facets[f][0], m.facets[f][1]);
  const double expected = 0.25 * 0.5 * 12 * std::sin(2 * k_pi / 12) * 0.75;
  EXPECT_NEAR(volume(mesh_region(m)), expected, 1e-14);
  for (Vec3& p : m.points) p = p + Vec3{4096, -8192, 2048};
  const Region far = mesh_region(m);
  EXPECT_NEAR(volume(far), expected, 1e-10);
  EXPECT_TRUE(inside(far, {4096 + 0.75, -8192, 2048.1}));
  EXPECT_FALSE(inside(far, {4096, -8192, 2048.1}));
}

TEST(Region, SidesOfNearlyCollinearEdgesAreDecidedExactly) {
  // Two prisms share a slanted wall. A point belongs to exactly one of them however near to the wall its plan view is.
  const Vec3 a{0.1, 0.1, 0}, b{24.3, 24.7, 0};
  const auto prism = [&](Vec3 third) {
    Mesh m;
    for (const Vec3 p : {a, b, third})
      for (const double z : {0.0, 1.0}) m.points.push_back({p.x, p.y, z});
    m.facets = {{0, 2, 4}, {1, 5, 3}, {0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}, {4, 5, 1}, {4, 1, 0}};
    return mesh_region(m);
  };
  const Region left = prism({0, 30, 0}), right = prism({30, 0, 0});
  int first = 0, second = 0;
  for (int i = 1; i < 200; ++i) {
    Vec3 x = a + (i / 200.0) * (b - a);
    x.z = 0.5;
    for (int ulp = -3; ulp <= 3; ++ulp) {
      const Vec3 y{x.x, x.y + ulp * 0x1p-50 * x.y, x.z};
      EXPECT_NE(inside(left, y), inside(right, y)) << i << " " << ulp;
      first += inside(left, y);
      second += inside(right, y);
    }
  }
  EXPECT_GT(first, 300);
  EXPECT_GT(second, 300);
}

TEST(Region, DistanceToASurfaceIsThatOfTheNearestFacet) {
  const Region g = mesh_region(ring(40, 0.5, 1, 0.25));
  const CounterRng rng(3, 1);
  for (std::uint64_t n = 0; n < 500; ++n) {
    const Vec3 x{rng.uniform(3 * n, -1.5, 1.5), rng.uniform(3 * n + 1, -1.5, 1.5), rng.uniform(3 * n + 2, -0.5, 1)};
    double nearest = 0.3;
    for (const TriangleElement& t : g.surface->facets()) nearest = std::min(nearest, closest(t, x).distance);
    EXPECT_EQ(g.surface->distance(x, 0.3), nearest);
  }
}

TEST(Region, AMeshWithAHoleIsRefusedWithItsPlace) {
  Mesh m = box_mesh({0, 0, 0}, {1, 1, 1});
  m.facets.pop_back();
  check_mesh(m, 0);
  m.report.file = "box.stl";
  const std::string text = refusal([&] { ClosedSurface{m}; });
  EXPECT_CONTAINS(text, "mesh box.stl: the mesh is not watertight: 3 open edges, the first about (1, ");
  EXPECT_CONTAINS(text, "only a closed surface has an inside");
}

TEST(Region, ARegionContinuesThroughAPeriodicSide) {
  const Domain d = periodic_domain();  // x in [0, 1]
  const Region g = sphere_region({0.1, 0.5, 0.5}, 0.2);
  EXPECT_TRUE(inside(d, g, {0.95, 0.5, 0.5}));
  EXPECT_FALSE(inside(g, {0.95, 0.5, 0.5}));
  EXPECT_FALSE(inside(d, g, {0.85, 0.5, 0.5}));
  EXPECT_FALSE(inside(d, sphere_region({0.5, 0.1, 0.5}, 0.2), {0.5, 0.95, 0.5}));  // that side is a wall
  EXPECT_NEAR(share_inside(d, g, {0.05, 0.5, 0.5}, 0.01), 1, 1e-15);
  EXPECT_NEAR(share_inside(d, g, {0.95, 0.5, 0.5}, 0.01), 1, 1e-15);
}

TEST(Region, ASphereThatSticksThroughAPeriodicSideCountsWhereItComesIn) {
  const Domain d = periodic_domain();
  const Region low = box_region({0, 0, 0}, {0.5, 1, 1}), high = box_region({0.5, 0, 0}, {1, 1, 1});
  const Vec3 x{0.99, 0.5, 0.5};
  EXPECT_GT(share_inside(d, low, x, 0.02), 0.1);
  EXPECT_NEAR(share_inside(d, low, x, 0.02) + share_inside(d, high, x, 0.02), 1, 1e-15);
  EXPECT_NEAR(share_inside(d, box_region({0, 0, 0}, {1, 1, 1}), x, 0.02), 1, 1e-15);
}

TEST(Region, SharesOfManySpheresAddUpToTheVolumeOfEveryShape) {
  // Spheres on a fine lattice: their shares count the region's volume, in units of the lattice's cell.
  Region mesh = mesh_region(box_mesh({0.21, 0.23, 0.22}, {0.71, 0.78, 0.74}));
  const Region shapes[] = {
      box_region({0.21, 0.23, 0.22}, {0.71, 0.78, 0.74}), box_region({0.2, 0.2, 0.2}, {0.8, 0.8, 0.7}, 0.3),
      cylinder_region({0.3, 0.3, 0.3}, {1, 1, 1}, 0.6, 0.2), sphere_region({0.5, 0.5, 0.5}, 0.3), mesh};
  const Domain d;
  const double h = 0.02;
  for (const Region& g : shapes) {
    double sum = 0;
    for (double x = 0.5 * h; x < 1; x += h)
      for (double y = 0.5 * h; y < 1; y += h)
        for (double z = 0.5 * h; z < 1; z += h) sum += share_inside(d, g, {x, y, z}, 0.5 * h);
    EXPECT_NEAR(sum * h * h * h / volume(g), 1, 0.01) << static_cast<int>(g.shape);
  }
}

/// Of a sphere's volume, by points in it.
double counted_share(const Region& g, Vec3 c, double r) {
  const CounterRng rng(11, 4);
  int in = 0, all = 0;
  for (std::uint64_t n = 0; n < 60000; ++n) {
    const Vec3 q{rng.uniform(3 * n, -1, 1), rng.uniform(3 * n + 1, -1, 1), rng.uniform(3 * n + 2, -1, 1)};
    if (norm2(q) > 1) continue;
    ++all;
    in += inside(g, c + r * q) ? 1 : 0;
  }
  return static_cast<double>(in) / all;
}

// Grains that are not small beside a round region: as if its surface were flat, the share was up to 0.1 too large, the
// solid fraction of a ball of three grains' width 7 %.
TEST(Region, RoundRegionsHoldTheTrueShareOfASphereThatIsNotSmall) {
  const Region ball = sphere_region({0.5, 0.5, 0.5}, 0.12),
               upright = box_region({0.38, 0.38, 0.42}, {0.62, 0.62, 0.6}, 0.12),
               bar = cylinder_region({0.4, 0.45, 0.5}, {1, 2, -0.5}, 0.3, 0.09);
  const CounterRng rng(3, 9);
  std::uint64_t draw = 0;
  int cut = 0;
  for (const Region& g : {ball, upright, bar})
    for (const double r : {0.03, 0.1, 0.2})
      for (int n = 0; n < 12; ++n) {
        const Vec3 x{rng.uniform(draw, 0.3, 0.7), rng.uniform(draw + 1, 0.3, 0.7), rng.uniform(draw + 2, 0.3, 0.7)};
        draw += 3;
        const double share = share_inside(Domain{}, g, x, r), counted = counted_share(g, x, r);
        cut += share > 0.01 && share < 0.99 ? 1 : 0;
        EXPECT_NEAR(share, counted, 4 * std::sqrt(0.25 / 31000)) << static_cast<int>(g.shape) << " " << r;
      }
  EXPECT_GT(cut, 30);
  // closed forms: equal balls, one within the other, half of a sphere and the half of its cap in a flat end
  EXPECT_NEAR(share_in_ball(1, 1, 1), 5.0 / 16, 1e-15);
  EXPECT_EQ(share_in_ball(1, 0.2, 2), 0.125);
  EXPECT_NEAR(share_in_bar(1e3, 0, 1e3, 1e3, 1), 0.25, 1e-3);
  EXPECT_NEAR(share_in_bar(2, 0.5, 9, 0.3, 1), 0.15625, 1e-6);
  // Steinmetz' neighbour: of a sphere of radius 1 a bar of 1/2 through its middle keeps 1 - (3/4)^(3/2)
  EXPECT_NEAR(share_in_bar(0.5, -2, 2, 0, 1), 1 - std::pow(0.75, 1.5), 1e-6);
  // Viviani: a bar of diameter 1 that touches the middle takes (2 pi/3 - 8/9) of 4 pi/3
  EXPECT_NEAR(share_in_bar(0.5, -2, 2, 0.5, 1), (2 * k_pi / 3 - 8.0 / 9) / (4 * k_pi / 3), 1e-5);
}

// --- scene files

constexpr const char* k_scene = R"(
[domain]
lower = [0, 0, 0]
upper = [1, 1, 2]
[time]
step = 1e-5
steps = 10
[[material]]
name = "glass"
density = 2500
[contact]
normal_stiffness = 1e5
)";

Scene with_region(const std::string& region) {
  return parse_scene(
      std::string(k_scene) + "[[source]]\nkind = \"lattice\"\nsize = {diameter = 0.05}\n[source.region]\n" + region,
      "scene.toml", wall_test::folder().string());
}

TEST(RegionKeys, EveryShapeIsReadWithItsBounds) {
  const Region c = with_region("shape = \"cylinder\"\npoint = [0.5, 0.2, 1]\nend = [0.5, 0.8, 1]\nradius = 0.25\n")
                       .sources[0]
                       .region;
  EXPECT_EQ(c.shape, Region::Shape::cylinder);
  EXPECT_NEAR(c.length, 0.6, 1e-15);
  EXPECT_NEAR(c.upper.z, 1.25, 1e-15);
  EXPECT_NEAR(c.upper.y, 0.8, 1e-15);
  const Region s = with_region("shape = \"sphere\"\ncentre = [0.5, 0.5, 1]\nradius = 0.5\n").sources[0].region;
  EXPECT_EQ(s.lower.z, 0.5);
  EXPECT_EQ(s.upper.x, 1);
}

TEST(RegionKeys, WhatAShapeNeedsAndDoesNotKnowIsSaid) {
  const auto said = [&](const std::string& text) { return refusal([&] { with_region(text); }); };
  EXPECT_CONTAINS(said("upper = [1, 1, 1]\n"), "source.0.region.lower");
  EXPECT_CONTAINS(said("shape = \"sphere\"\nradius = 0.2\n"), "source.0.region.centre");
  EXPECT_CONTAINS(said("shape = \"cylinder\"\npoint = [0.5, 0.5, 0]\nradius = 0.2\n"), "source.0.region.length");
  EXPECT_CONTAINS(said("shape = \"sphere\"\ncentre = [0.5, 0.5, 1]\nradius = 0.2\nlower = [0, 0, 0]\n"),
                  "has no effect with shape = sphere");
  EXPECT_CONTAINS(said("shape = \"cylinder\"\npoint = [0.5, 0.5, 0]\nradius = 0.2\nlength = 1\nend = [0.5, 0.5, 1]\n"),
                  "source.0.region.end");
  EXPECT_CONTAINS(said("shape = \"cylinder\"\npoint = [0.5, 0.5, 0]\nend = [0.5, 0.5, 0]\nradius = 0.2\n"),
                  "must differ from 'point'");
  EXPECT_CONTAINS(said("shape = \"mesh\"\n"), "source.0.region.file");
}

TEST(RegionKeys, SourceRegionsBeyondTheDomainAreRefusedWithTheAxis) {
  EXPECT_CONTAINS(refusal([&] { with_region("shape = \"sphere\"\ncentre = [0.5, 0.5, 0.1]\nradius = 0.2\n"); }),
                  "source.0.region.centre: [0.5, 0.5, 0.1]: the region must lie within the domain: it reaches from z = "
                  "-0.1 to 0.3");
}

TEST(RegionKeys, AMeshIsReadWithTheSceneAndRefusedWhereItHasHoles) {
  wall_test::write_obj("region_cube.obj", box_mesh({0, 0, 0}, {1, 1, 1}).points,
                       {{0, 2, 1},
                        {1, 2, 3},
                        {4, 5, 6},
                        {5, 7, 6},
                        {0, 1, 4},
                        {1, 5, 4},
                        {2, 6, 3},
                        {3, 6, 7},
                        {0, 4, 2},
                        {2, 4, 6},
                        {1, 3, 5},
                        {3, 7, 5}});
  const std::string keys = "shape = \"mesh\"\nfile = \"region_cube.obj\"\nscale = 0.5\n";
  Scene s = with_region(keys + "shift = [0.25, 0.25, 1]\n");
  EXPECT_CONTAINS(refusal([&] { require_loaded(s); }), "has not been read");
  load_regions(s);
  require_loaded(s);
  EXPECT_NEAR(volume(s.sources[0].region), 0.125, 1e-9);
  EXPECT_TRUE(inside(s.sources[0].region, {0.7, 0.7, 1.4}));
  Scene outside = with_region(keys + "shift = [0.75, 0.25, 1]\n");
  const std::string text = refusal([&] { load_regions(outside); });
  EXPECT_CONTAINS(text,
                  "source 'source_0', region: mesh region_cube.obj: the region must lie within the domain: it "
                  "reaches from x = 0.75 to 1.25");
  wall_test::write_obj("region_open.obj", box_mesh({0, 0, 0}, {1, 1, 1}).points, {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}});
  Scene open = with_region("shape = \"mesh\"\nfile = \"region_open.obj\"\n");
  EXPECT_CONTAINS(refusal([&] { load_regions(open); }), "the mesh is not watertight: ");
}

}  // namespace
}  // namespace talus
