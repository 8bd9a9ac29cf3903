// Claims about walls on periodic axes: contacts and candidates equal those of explicit copies of the wall at every
// period, seams at a side are no features, what is not periodic is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "wall_support.hpp"

namespace talus {
namespace {

using namespace wall_test;

/// The domain [0, 1)^3 with the named axes periodic.
Scene periodic_scene(const std::vector<WallSpec>& walls, const std::string& axes = "xyz") {
  Scene s = scene_with(walls);
  s.domain.lower = {0, 0, 0};
  s.domain.upper = {1, 1, 1};
  for (int k = 0; k < 3; ++k)
    if (axes.find("xyz"[k]) != std::string::npos)
      s.domain.boundary[static_cast<std::size_t>(k)] = {Boundary::periodic, Boundary::periodic};
  return s;
}

WallSpec moved(WallSpec w, Vec3 by) {
  for (Vec3* at : {&w.point, &w.lower, &w.upper, &w.shift, &w.motion.rotation_origin}) *at = *at + by;
  return w;
}

std::string refusal(const std::vector<WallSpec>& walls, const std::string& axes = "xyz") {
  try {
    const WallSet set(periodic_scene(walls, axes), 0.1);
    return "";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
}

/// An irregular closed body of 8 facets around the origin, 0.1 to 0.3 in size.
std::string body_file(std::uint64_t seed) {
  const CounterRng rng(seed, 5);
  std::vector<Vec3> points;
  for (std::uint64_t k = 0; k < 6; ++k) {
    Vec3 p;
    p[static_cast<int>(k / 2)] = (k % 2 == 0 ? 1 : -1) * rng.uniform(3 * k, 0.1, 0.3);
    p[static_cast<int>((k / 2 + 1) % 3)] = rng.uniform(3 * k + 1, -0.05, 0.05);
    points.push_back(p);
  }
  std::vector<std::array<int, 3>> facets;
  for (int a = 0; a < 2; ++a)
    for (int b = 2; b < 4; ++b)
      for (int c = 4; c < 6; ++c) facets.push_back({a, b, c});
  return write_obj("body" + std::to_string(seed) + ".obj", points, facets);
}

WallSpec random_wall(std::uint64_t seed, const std::string& axes) {
  const CounterRng rng(seed, 6);
  const auto u = [&](std::uint64_t q, double a, double b) { return rng.uniform(q, a, b); };
  Vec3 at;
  for (std::uint64_t k = 0; k < 3; ++k) {
    const bool anywhere = axes.find("xyz"[k]) != std::string::npos;
    at[static_cast<int>(k)] = anywhere ? u(k, -2, 3) : u(k, 0.2, 0.8);
  }
  WallSpec w;
  switch (seed % 4) {
    case 0:
      w = box_wall(at, at + Vec3{u(3, 0.05, 0.5), u(4, 0.05, 1.7), u(5, 0.05, 0.5)});
      break;
    case 1:
      w = cone_wall(at, {u(3, -1, 1), u(4, -1, 1), u(5, -1, 1)}, u(6, 0.2, 1.5), 0.15, u(7, 0, 1) < 0.5 ? 0.15 : 0.05);
      break;
    case 2:
      w = mesh_wall(body_file(seed));
      w.shift = at;
      break;
    default:
      w = box_wall(at, at + Vec3{0.2, 0.2, 0.2});
      w.motion.velocity = {u(3, -30, 30), u(4, -30, 30), u(5, -30, 30)};
  }
  if (seed % 3 == 1) {  // shorter than the period: images that overlap and turn about different points disagree
    w.length = std::min(w.length, 0.8);
    w.upper.y = std::min(w.upper.y, w.lower.y + 0.8);
    w.motion.rotation_axis = {u(8, -1, 1), u(9, -1, 1), 1};
    w.motion.rotation_rate = 20;
    w.motion.rotation_origin = at + Vec3{0.3, 0.1, -0.2};
  }
  if (seed % 3 == 2) {
    w.motion.amplitude = {0.3, 0.1, 0.2};
    w.motion.frequency = 7;
  }
  w.name = "wall" + std::to_string(seed);
  return w;
}

/// Contacts that name no element: what a particle feels.
std::vector<WallContact> by_normal(std::vector<WallContact> c) {
  std::sort(c.begin(), c.end(), [](const WallContact& a, const WallContact& b) {
    return std::lround(a.normal.x * 1e6) != std::lround(b.normal.x * 1e6) ? a.normal.x < b.normal.x
                                                                          : a.normal.y < b.normal.y;
  });
  return c;
}

/// The wall at every period at which a ball around it comes near the domain.
std::vector<WallSpec> copies(const WallSpec& w, const WallPose& pose, const std::string& axes) {
  const WallMotion& m = w.motion;
  Vec3 centre =
      w.shape == WallShape::box ? 0.5 * (w.lower + w.upper) : (w.shape == WallShape::mesh ? w.shift : w.point);
  // turned about its origin it is at the same distance from it, somewhere
  const double away = m.rotation_rate != 0 ? 2 * length(centre - m.rotation_origin) : 0;
  const double ball = away + 0.6 + (w.shape == WallShape::box ? 0.5 * length(w.upper - w.lower) : w.length);
  centre = centre + pose.translation;
  std::vector<WallSpec> all;
  std::array<std::array<int, 2>, 3> range{};
  for (int k = 0; k < 3; ++k)
    if (axes.find("xyz"[k]) != std::string::npos)
      range[static_cast<std::size_t>(k)] = {static_cast<int>(std::floor(-ball - centre[k])),
                                            static_cast<int>(std::ceil(1 + ball - centre[k]))};
  for (int i = range[0][0]; i <= range[0][1]; ++i)
    for (int j = range[1][0]; j <= range[1][1]; ++j)
      for (int k = range[2][0]; k <= range[2][1]; ++k) all.push_back(moved(w, {1.0 * i, 1.0 * j, 1.0 * k}));
  return all;
}

// 24 walls of all kinds at random places within and beyond the box, moving through several periods.
TEST(WallPeriodic, ContactsEqualThoseOfExplicitCopies) {
  std::int64_t touched = 0, through_a_side = 0, several = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const std::string axes = seed % 5 == 0 ? "x" : (seed % 5 == 1 ? "yz" : "xyz");
    const WallSpec w = random_wall(seed, axes);
    const double radius = seed % 2 == 0 ? 0.12 : 0.2;
    WallSet wall(periodic_scene({w}, axes), radius);
    const double dt = 1e-3;
    const CounterRng rng(seed, 7);
    for (const std::int64_t step : {0, 977}) {
      wall.set_step(step, dt);
      Scene plain = scene_with(copies(w, wall.pose(0), axes));
      plain.domain = {{-9, -9, -9}, {9, 9, 9}, plain.domain.boundary, 0};
      WallSet explicitly(plain, radius);
      explicitly.set_step(step, dt);
      for (std::uint64_t k = 0; k < 150; ++k) {
        const std::uint64_t q = 1000 * static_cast<std::uint64_t>(step) + 3 * k;
        const Vec3 c{rng.uniform(q), rng.uniform(q + 1), rng.uniform(q + 2)};
        const auto got = by_normal(touch(wall, c, radius)), want = by_normal(touch(explicitly, c, radius));
        ASSERT_EQ(got.size(), want.size()) << w.name << " step " << step << " sample " << k;
        for (std::size_t n = 0; n < got.size(); ++n) {
          EXPECT_NEAR(got[n].distance, want[n].distance, 1e-12);
          EXPECT_NEAR(length(got[n].normal - want[n].normal), 0, 1e-9);
          EXPECT_NEAR(length(got[n].velocity - want[n].velocity), 0, 1e-9);
          const Vec3 shift = c - got[n].centre;
          for (int x = 0; x < 3; ++x) EXPECT_NEAR(shift[x], std::round(shift[x]), 1e-12);
          through_a_side += length(shift) > 0.5 ? 1 : 0;
        }
        touched += static_cast<std::int64_t>(got.size());
        several += got.size() > 1 ? 1 : 0;
        std::vector<std::int32_t> near, all;
        wall.candidates(c, radius, near);
        wall.audit_candidates(c, radius, all);
        std::sort(near.begin(), near.end());
        std::sort(all.begin(), all.end());
        ASSERT_EQ(near, all);
      }
    }
  }
  EXPECT_GT(touched, 1000);
  EXPECT_GT(through_a_side, 500);
  EXPECT_GT(several, 50);
}

TEST(WallPeriodic, CandidatesStayValidWhileTheWallMovesThroughPeriodsAndTheCentreWraps) {
  WallSpec w = box_wall({0.7, 0.2, 0.2}, {1.0, 0.8, 0.8});
  w.motion.velocity = {3, -2, 0};
  w.motion.rotation_axis = {0, 0, 1};
  w.motion.rotation_origin = {0.85, 0.5, 0.5};
  w.motion.rotation_rate = 5;
  WallSet walls(periodic_scene({w}, "xy"), 0.2);
  const CounterRng rng(3, 1);
  const double dt = 1e-3;
  std::int64_t contacts = 0, wrapped = 0;
  for (std::uint64_t k = 0; k < 4000; ++k) {
    const auto u = [&](std::uint64_t q, double a, double b) { return rng.uniform(16 * k + q, a, b); };
    const auto n = static_cast<std::int64_t>(u(0, 0, 3000));
    walls.set_step(n, dt);
    walls.mark(12, dt, 0, 1);
    const Vec3 c{u(1, 0, 1), u(2, 0, 1), u(3, 0, 1)};
    std::vector<std::int32_t> listed;
    walls.candidates(c, 0.05 + 0.05, listed);
    walls.set_step(n + 10, dt);
    ASSERT_FALSE(walls.expired());
    Vec3 now = c + Vec3{u(4, -0.028, 0.028), u(5, -0.028, 0.028), u(6, -0.028, 0.028)};
    WallSet::Wraps wraps{};
    for (std::size_t q = 0; q < 2; ++q) {
      double& x = now[static_cast<int>(q)];
      if (x < 0) x += 1, wraps[q] = 1;
      if (x >= 1) x -= 1, wraps[q] = -1;
    }
    std::vector<WallContact> got(WallSet::k_max_contacts);
    got.resize(static_cast<std::size_t>(walls.contacts(now, 0.05, listed, got.data(), wraps)));
    const auto want = touch(walls, now, 0.05);
    ASSERT_EQ(got.size(), want.size()) << "sample " << k;
    for (std::size_t q = 0; q < got.size(); ++q) {
      EXPECT_EQ(got[q].element, want[q].element);
      EXPECT_EQ(got[q].distance, want[q].distance);
      EXPECT_EQ(got[q].centre.x, want[q].centre.x);
    }
    contacts += static_cast<std::int64_t>(got.size());
    wrapped += !got.empty() && (wraps[0] != 0 || wraps[1] != 0) ? 1 : 0;
  }
  EXPECT_GT(contacts, 300);
  EXPECT_GT(wrapped, 10);
}

// A floor that is cut at the sides: no edge and no corner of the cut is felt, whichever facets meet there.
TEST(WallPeriodic, CutFloorIsOneSurfaceAcrossSidesAndCorners) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  random_plane(5, 0.25, 0.25, 11, points, facets);  // exact in single precision at the rim
  for (Vec3& p : points) p = {0.8 * p.x, 0.8 * p.y, p.z};
  std::vector<Vec3> wide;
  std::vector<std::array<int, 3>> squares;
  random_plane(1, 1, 0.25, 1, wide, squares);
  for (const std::string& file : {write_obj("cut.obj", points, facets), write_obj("one.obj", wide, squares)})
    for (const double shift : {0.0, 0.375, -0.625}) {
      WallSpec w = mesh_wall(file);
      w.shift = {shift, 0.5 * shift, 0};
      const WallSet walls(periodic_scene({w}, "xy"), 0.15);
      const CounterRng rng(5, 1);
      for (std::uint64_t k = 0; k < 3000; ++k) {
        const auto at = [&](std::uint64_t q) {  // half of them near a side
          const double x = rng.uniform(3 * k + q), near = 0.02 * (x - 0.5);
          return k % 2 == 0 ? x : (near < 0 ? near + 1 : near);
        };
        const double height = rng.uniform(3 * k + 2, 0.02, 0.09);
        const auto c = touch(walls, {at(0), k % 4 < 2 ? at(1) : 0.0, 0.25 + height}, 0.1);
        ASSERT_EQ(c.size(), 1u) << "sample " << k;
        EXPECT_NEAR(c[0].normal.z, 1, 1e-12);
        EXPECT_NEAR(c[0].distance, height, 1e-12);
      }
    }
}

// The axis of the cylinder is the periodic one and its length the period: an endless pipe.
TEST(WallPeriodic, CylinderOfOnePeriodIsEndless) {
  for (const double start : {0.0, 0.3, -2.75})
    for (const double length : {1.0, 2.5}) {
      const WallSet walls(periodic_scene({cone_wall({0.5, start, 0.5}, {0, 1, 0}, length, 0.4, 0.4)}, "y"), 0.15);
      const CounterRng rng(6, 1);
      for (std::uint64_t k = 0; k < 2000; ++k) {
        const double y = k % 7 == 0 ? 0 : rng.uniform(3 * k), a = rng.uniform(3 * k + 1, 0, 6.28);
        const double rho = rng.uniform(3 * k + 2, 0.31, 0.49);
        const auto c = touch(walls, {0.5 + rho * std::cos(a), y, 0.5 + rho * std::sin(a)}, 0.1);
        ASSERT_EQ(c.size(), 1u);
        EXPECT_NEAR(c[0].distance, std::fabs(rho - 0.4), 1e-14);
        EXPECT_NEAR(c[0].normal.y, 0, 1e-14);
      }
    }
}

TEST(WallPeriodic, ABlockWiderThanTheBoxIsABar) {
  const WallSet walls(periodic_scene({box_wall({-0.3, 0, 0}, {1.45, 1, 0.5})}, "x"), 0.15);
  const CounterRng rng(6, 2);
  for (std::uint64_t k = 0; k < 2000; ++k) {
    const auto c = touch(walls, {rng.uniform(2 * k), rng.uniform(2 * k + 1, 0.2, 0.8), 0.58}, 0.1);
    ASSERT_EQ(c.size(), 1u);
    EXPECT_NEAR(c[0].distance, 0.08, 1e-14);
    EXPECT_EQ(c[0].normal.z, 1);
  }
}

TEST(WallPeriodic, AWallInTheSideActsOnBothOfItsFaces) {
  const WallSet walls(
      periodic_scene(
          {mesh_wall(write_obj("screen.obj", {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}}, {{0, 1, 2}, {0, 2, 3}}))},
          "x"),
      0.1);
  const auto right = touch(walls, {0.03, 0.5, 0.5}, 0.1), left = touch(walls, {0.97, 0.5, 0.5}, 0.1);
  ASSERT_EQ(right.size(), 1u);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(right[0].normal.x, 1);
  EXPECT_EQ(left[0].normal.x, -1);
  EXPECT_NEAR(left[0].distance, 0.03, 1e-15);
  const auto s = walls.surfaces();
  EXPECT_EQ(s[0].triangles.size(), 2u);
}

// A ramp of three periods: at every place it passes over itself, and a grain between two turns touches one facet twice.
TEST(WallPeriodic, TwoImagesOfOneFacetAreTwoContactsWithTheirOwnHistory) {
  const double rise = 0.15;
  const WallSet walls(
      periodic_scene(
          {mesh_wall(write_obj("ramp.obj", {{-1, -9, 0.0}, {2, -9, 3 * rise}, {0.5, 9, 1.5 * rise}}, {{0, 1, 2}}))},
          "x"),
      0.15);
  const Vec3 c{0.5, -3, 1.5 * rise + 0.5 * rise};
  auto before = touch(walls, c, 0.1);
  ASSERT_EQ(before.size(), 2u);
  EXPECT_EQ(before[0].element, before[1].element);
  EXPECT_LT(dot(before[0].normal, before[1].normal), -0.999);
  std::vector<std::int32_t> from(2);
  walls.match(before, before, from.data());
  EXPECT_EQ(from, (std::vector<std::int32_t>{0, 1}));
  std::swap(before[0], before[1]);
  const auto now = touch(walls, c + Vec3{0.001, 0, 0}, 0.1);
  walls.match(before, now, from.data());
  EXPECT_EQ(from, (std::vector<std::int32_t>{1, 0}));
  // one image left alone keeps its own history, and does not take that of the other
  const std::vector<WallContact> one{now[1]};
  walls.match(std::span(before).subspan(1), one, from.data());
  EXPECT_EQ(from[0], -1);
  walls.match(before, one, from.data());
  EXPECT_EQ(from[0], 0);
}

TEST(WallPeriodic, HistoryPassesThroughTheSide) {
  std::vector<Vec3> wide;
  std::vector<std::array<int, 3>> squares;
  random_plane(1, 1, 0.25, 1, wide, squares);
  const WallSet walls(periodic_scene({mesh_wall(write_obj("pass.obj", wide, squares))}, "xy"), 0.15);
  for (const Vec3 to : {Vec3{0.0004, 0.3, 0.34}, Vec3{0.3, 0.0004, 0.34}, Vec3{0.0004, 0.0003, 0.34}}) {
    Vec3 back = to;
    for (int k = 0; k < 2; ++k)
      if (to[k] < 0.01) back[k] = 1 - 0.0005;
    const auto before = touch(walls, back, 0.1), now = touch(walls, to, 0.1);
    ASSERT_EQ(before.size(), 1u);
    ASSERT_EQ(now.size(), 1u);
    std::int32_t from = -1;
    walls.match(before, now, &from);
    EXPECT_EQ(from, 0);
  }
}

TEST(WallPeriodic, WallsClearOfTheSidesCostNothing) {
  const WallSet inside(periodic_scene({box_wall({0.3, 0.3, 0.3}, {0.6, 0.6, 0.6})}), 0.1);
  EXPECT_FALSE(inside.has_images());
  WallSpec gate = box_wall({0.3, 0.3, 0.3}, {0.6, 0.6, 0.6});
  gate.motion.velocity = {0.1, 0, 0};
  gate.motion.end = 2;
  EXPECT_FALSE(WallSet(periodic_scene({gate}), 0.1).has_images());
  gate.motion.end = 5;
  EXPECT_TRUE(WallSet(periodic_scene({gate}), 0.1).has_images());
  EXPECT_FALSE(WallSet(periodic_scene({gate}, "yz"), 0.1).has_images());
  const WallSet floor(periodic_scene({plane_wall({0, 0, 0.1}, {0, 0, 1})}, "xy"), 0.1);
  EXPECT_FALSE(floor.has_images());
  EXPECT_TRUE(WallSet(periodic_scene({box_wall({0.3, 0.3, 0.3}, {0.95, 0.6, 0.6})}), 0.1).has_images());
}

TEST(WallPeriodic, PlanesThatAPeriodicAxisCrossesAreRefusedByName) {
  for (const Vec3 normal : {Vec3{1, 0, 0}, Vec3{1e-6, 0, 1}, Vec3{-1, 1, 1}}) {
    WallSpec w = plane_wall({0.5, 0.5, 0.5}, normal);
    w.name = "ramp";
    const std::string text = refusal({w}, "x");
    EXPECT_NE(text.find("wall \"ramp\""), std::string::npos) << text;
    EXPECT_NE(text.find("cuts the periodic axis x"), std::string::npos) << text;
    EXPECT_NE(text.find("tilt gravity"), std::string::npos) << text;
  }
  EXPECT_EQ(refusal({plane_wall({0.5, 0.5, 0.5}, {1, 0, 0})}, "yz"), "");
  EXPECT_EQ(refusal({plane_wall({0.5, 0.5, 0.5}, {6e-17, 1, 2})}, "x"), "");  // cos(90 degrees)
  // a turning plane: about the periodic axis it stays parallel to it, about another one it does not
  WallSpec turning = plane_wall({0.5, 0.5, 0.5}, {0, 0, 1});
  turning.motion.rotation_rate = 1;
  turning.motion.rotation_axis = {1, 0, 0};
  EXPECT_EQ(refusal({turning}, "x"), "");
  EXPECT_NE(refusal({turning}, "xy").find("turns across the periodic axis y"), std::string::npos);
  turning.motion.rotation_axis = {0, 0, 2};
  EXPECT_EQ(refusal({turning}, "xy"), "");
}

TEST(WallPeriodic, WallsOfManyPeriodsAndMeshesBeyondTheBox) {
  const std::string text = refusal({box_wall({0, 0, 0}, {0.5, 1000, 0.5})}, "y");
  EXPECT_NE(text.find("1000 times as long as the domain along the periodic axis y"), std::string::npos) << text;
  EXPECT_EQ(refusal({box_wall({0, 0, 0}, {0.5, 1000, 0.5})}, "x"), "");
  // beyond the box along a periodic axis a mesh acts all the same, along another one it is lost
  WallSpec mesh = mesh_wall(body_file(1));
  mesh.shift = {7.5, 0.5, 0.5};
  EXPECT_EQ(refusal({mesh}, "x"), "");
  EXPECT_NE(refusal({mesh}, "y").find("outside the domain"), std::string::npos);
  const WallSet walls(periodic_scene({mesh}, "x"), 0.1);
  EXPECT_FALSE(touch(walls, {0.5, 0.5, 0.5}, 0.3).empty());
}

TEST(WallPeriodic, PicturesShowTheImagesInTheDomain) {
  const auto bounds = [](const WallSurface& s) {
    Vec3 lo{9, 9, 9}, hi{-9, -9, -9};
    for (const Vec3 p : s.points)
      for (int k = 0; k < 3; ++k) lo[k] = std::min(lo[k], p[k]), hi[k] = std::max(hi[k], p[k]);
    return std::pair(lo, hi);
  };
  WallSpec belt = box_wall({0.2, 0.1, 0.1}, {0.4, 0.2, 0.2});
  belt.motion.velocity = {1, 0, 0};
  WallSet walls(
      periodic_scene({box_wall({0.9, 0.1, 0.1}, {1.1, 0.2, 0.2}), box_wall({0.8, 0.1, 0.1}, {1, 0.2, 0.2}), belt}, "x"),
      0.05);
  walls.set_step(3250, 1e-3);
  const auto s = walls.surfaces();
  EXPECT_EQ(s[0].triangles.size(), 24u);  // the block that crosses: at both ends
  EXPECT_EQ(s[1].triangles.size(), 12u);  // the one that ends in the side: once
  EXPECT_EQ(bounds(s[1]).first.x, 0.8);
  EXPECT_EQ(s[2].triangles.size(), 12u);
  EXPECT_NEAR(bounds(s[2]).first.x, 0.45, 1e-12);  // three periods on
}

}  // namespace
}  // namespace talus
