// Claims about candidates: complete against brute force, tight, ascending, and bounded in memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/walls/facet_grid.hpp"
#include "core/walls/wall_elements.hpp"
#include "wall_support.hpp"

namespace talus {
namespace {

using namespace wall_test;

/// A closed wavy sphere of 2*n*m facets, stretched along z.
void blob(int n, int m, double radius, std::vector<Vec3>& points, std::vector<std::array<int, 3>>& facets) {
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i < n; ++i) {
      const double a = 2 * M_PI * i / n, b = M_PI * j / m, r = radius * (1 + 0.1 * std::sin(5 * a) * std::sin(7 * b));
      points.push_back({r * std::cos(a) * std::sin(b), r * std::sin(a) * std::sin(b), 1.5 * r * std::cos(b)});
    }
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * n + i, b = j * n + (i + 1) % n, c = a + n, d = b + n;
      if (j > 0) facets.push_back({a, b, d});
      if (j < m - 1) facets.push_back({a, d, c});
    }
}

TEST(WallCandidates, CompleteAndTightAgainstBruteForce) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  blob(60, 40, 0.4, points, facets);
  // Three huge slanted facets through everything, besides 4680 small ones.
  const int base = static_cast<int>(points.size());
  for (const Vec3 p :
       {Vec3{-1.9, -1.8, -1.7}, Vec3{1.9, 1.7, -1.5}, Vec3{0.1, 0.3, 1.9}, Vec3{-1.5, 1.6, 0.2}, Vec3{1.2, -1.9, 0.9}})
    points.push_back(p);
  facets.push_back({base, base + 1, base + 2});
  facets.push_back({base, base + 3, base + 4});
  facets.push_back({base + 1, base + 2, base + 3});
  const WallSet walls(scene_with({mesh_wall(write_obj("blob.obj", points, facets))}), 0.03);
  ASSERT_EQ(walls.element_count(), static_cast<std::int64_t>(facets.size()));
  for (Vec3& p : points)
    p = {static_cast<double>(static_cast<float>(p.x)), static_cast<double>(static_cast<float>(p.y)),
         static_cast<double>(static_cast<float>(p.z))};
  const CounterRng rng(9, 9);
  std::int64_t found = 0;
  for (std::uint64_t k = 0; k < 4000; ++k) {
    const double box = k % 2 == 0 ? 0.6 : 2;
    const Vec3 c{rng.uniform(4 * k, -box, box), rng.uniform(4 * k + 1, -box, box), rng.uniform(4 * k + 2, -box, box)};
    // Beyond 0.03 the grid does not reach: still complete.
    const double reach = rng.uniform(4 * k + 3, 0.001, k % 8 == 0 ? 0.06 : 0.0299);
    std::vector<std::int32_t> got, must, may;
    walls.candidates(c, reach, got);
    for (std::size_t f = 0; f < facets.size(); ++f) {
      const auto& t = facets[f];
      const double d = closest(make_triangle(points[t[0]], points[t[1]], points[t[2]]), c).distance;
      if (d <= reach) must.push_back(static_cast<std::int32_t>(f));
      if (d <= reach + 2e-6) may.push_back(static_cast<std::int32_t>(f));
    }
    found += static_cast<std::int64_t>(must.size());
    ASSERT_TRUE(std::is_sorted(got.begin(), got.end()));
    ASSERT_TRUE(std::includes(got.begin(), got.end(), must.begin(), must.end())) << "sample " << k;
    ASSERT_TRUE(std::includes(may.begin(), may.end(), got.begin(), got.end())) << "sample " << k;
  }
  EXPECT_GT(found, 1000);
}

TEST(WallCandidates, HundredThousandFacetsStayWithinBoundedMemory) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  blob(320, 160, 0.4, points, facets);
  ASSERT_GT(facets.size(), 100000u);
  const WallSet fine(scene_with({mesh_wall(write_obj("fine.obj", points, facets))}), 0.004);
  EXPECT_LT(fine.bytes(), std::size_t{64} << 20);
  // A reach far above the facets' size: every cell sees thousands of facets, so the cells must grow.
  const WallSet coarse(scene_with({mesh_wall((folder() / "fine.obj").string())}), 0.2);
  EXPECT_LT(coarse.bytes(), std::size_t{96} << 20);
  std::vector<std::int32_t> out;
  coarse.candidates({0.4, 0, 0}, 0.05, out);
  EXPECT_GT(out.size(), 100u);
}

TEST(WallCandidates, AFewHugeSlantedFacetsStayWithinBoundedMemory) {
  std::vector<Triangle> t;
  const CounterRng rng(4, 4);
  for (std::uint64_t k = 0; k < 40; ++k) {
    Triangle f;
    for (std::uint64_t i = 0; i < 9; ++i) f[i / 3][static_cast<int>(i % 3)] = rng.uniform(9 * k + i, -2, 2);
    t.push_back(f);
  }
  const WallSet walls(scene_with({mesh_wall(write_stl("huge.stl", t))}), 1e-4);
  EXPECT_LT(walls.bytes(), std::size_t{32} << 20);
}

TEST(WallCandidates, CellsListEachFacetOnceInAscendingOrder) {
  std::vector<TriangleElement> t;
  const CounterRng rng(8, 4);
  for (std::uint64_t k = 0; k < 300; ++k) {
    Triangle f;
    for (std::uint64_t i = 0; i < 9; ++i) f[i / 3][static_cast<int>(i % 3)] = rng.uniform(9 * k + i);
    t.push_back(make_triangle(f[0], f[1], f[2]));
  }
  const FacetGrid grid(t, 0.02, 0);
  std::size_t listed = 0;
  for (std::uint64_t k = 0; k < 500; ++k) {
    const auto near = grid.near({rng.uniform(9000 + 3 * k), rng.uniform(9001 + 3 * k), rng.uniform(9002 + 3 * k)});
    for (std::size_t i = 1; i < near.size(); ++i) ASSERT_LT(near[i - 1], near[i]);
    listed += near.size();
  }
  EXPECT_GT(listed, 1000u);
  EXPECT_TRUE(grid.near({3, 0, 0}).empty());
  EXPECT_TRUE(grid.near({NAN, 0, 0}).empty());
}

TEST(WallCandidates, ReachCountsTheWallsSkin) {
  Scene s = scene_with({plane_wall({0, 0, 0}, {0, 0, 1})});
  s.walls[0].motion.velocity = {0, 0, 1};
  WallSet walls(s, 0.05);
  std::vector<std::int32_t> out;
  walls.mark(10, 1e-3, 0, 0.02);  // skin 0.01
  walls.candidates({0, 0, 0.0195}, 0.01, out);
  EXPECT_EQ(out.size(), 1u);
  out.clear();
  walls.candidates({0, 0, 0.0205}, 0.01, out);
  EXPECT_TRUE(out.empty());
}

// Later steps leave out elements by it: distance at the list - way of the centre - way of the walls <= distance now.
TEST(WallCandidates, DistancesAreLowerBoundsThatHoldForMovedCentresAndWalls) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  blob(40, 20, 0.4, points, facets);
  Scene s = scene_with({mesh_wall(write_obj("moving.obj", points, facets)), plane_wall({0, 0, -0.5}, {0, 0.1, 1}),
                        cone_wall({0, 0, 0.4}, {0, 0, 1}, 0.3, 0.2, 0.1)});
  s.walls[0].motion.rotation_axis = {0, 1, 1};
  s.walls[0].motion.rotation_rate = 3;
  s.walls[0].motion.velocity = {0.2, 0, -0.1};
  s.walls[1].motion.velocity = {0, 0, 0.4};
  WallSet walls(s, 0.2);
  const CounterRng rng(3, 7);
  const double dt = 1e-3;
  int tight = 0, seen = 0, needs_walls = 0, needs_centre = 0;
  for (std::uint64_t k = 0; k < 3000; ++k) {
    const auto u = [&](std::uint64_t q, double a, double b) { return rng.uniform(16 * k + q, a, b); };
    const auto n = static_cast<std::int64_t>(u(0, 0, 300));
    walls.set_step(n, dt);
    walls.mark(20, dt, 0, 1);
    EXPECT_EQ(walls.largest_travel(), 0);
    const Vec3 c{u(1, -0.6, 0.6), u(2, -0.6, 0.6), u(3, -0.7, 0.7)};
    std::vector<std::int32_t> elements;
    std::vector<float> bounds;
    walls.candidates(c, 0.1, elements, &bounds);
    ASSERT_EQ(elements.size(), bounds.size());
    const Vec3 move{u(4, -0.02, 0.02), u(5, -0.02, 0.02), u(6, -0.02, 0.02)};
    std::vector<double> before(elements.size(), -1);
    WallContact contact[WallSet::k_max_contacts];
    for (std::size_t e = 0; e < elements.size(); ++e)
      if (walls.contacts(c, 0.5, std::span(&elements[e], 1), contact) == 1) before[e] = contact[0].distance;
    walls.set_step(n + static_cast<std::int64_t>(u(7, 0, 20)), dt);
    for (std::size_t e = 0; e < elements.size(); ++e) {
      if (before[e] < 0 || walls.contacts(c + move, 0.5, std::span(&elements[e], 1), contact) != 1) continue;
      ++seen;
      const double bound = bounds[e], now = contact[0].distance, way = norm(move);
      ASSERT_LE(bound, before[e]);
      tight += bound > before[e] * (1 - 1e-5) - 3e-7 ? 1 : 0;
      ASSERT_LE(bound - way - walls.largest_travel(), now) << "sample " << k;
      needs_walls += bound - way > now ? 1 : 0;
      needs_centre += bound - walls.largest_travel() > now ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 3000);
  EXPECT_EQ(tight, seen);
  EXPECT_GT(needs_walls, 0);
  EXPECT_GT(needs_centre, 0);
}

TEST(WallSurfaces, PrimitivesAreTessellatedAndPlanesClippedToTheDomain) {
  Scene s = scene_with({plane_wall({0, 0, 0.5}, {0, 0, 1}), cone_wall({0, 0, 0}, {0, 0, 1}, 1, 0.5, 0),
                        box_wall({0, 0, 0}, {1, 1, 1}), plane_wall({0, 0, 9}, {0, 0, 1})});
  const WallSet walls(s, 0.02);
  const auto surfaces = walls.surfaces();
  ASSERT_EQ(surfaces.size(), 4u);
  auto area = [](const WallSurface& w) {
    double a = 0;
    for (const auto& t : w.triangles)
      a += 0.5 * length(cross(w.points[t[1]] - w.points[t[0]], w.points[t[2]] - w.points[t[0]]));
    return a;
  };
  EXPECT_NEAR(area(surfaces[0]), 16, 1e-12);
  EXPECT_NEAR(area(surfaces[1]), M_PI * 0.5 * std::sqrt(1.25), 0.01);
  EXPECT_NEAR(area(surfaces[2]), 6, 1e-12);
  EXPECT_EQ(surfaces[2].points.size(), 8u);
  EXPECT_TRUE(surfaces[3].triangles.empty());
}

}  // namespace
}  // namespace talus
