// Claims about wall poses: functions of the step number, velocities that equal displacements, skins that bound travel.
#include "core/walls/wall_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "wall_support.hpp"

namespace talus {
namespace {

using namespace wall_test;

WallPose pose(const WallMotion& m, std::int64_t n, double dt) { return pose_at(m, 0, k_never, n, dt); }

TEST(WallMotion, TranslationWindowMovesThenRests) {
  WallMotion m;
  m.velocity = {0.5, 0, -1};
  m.start = 0.1;
  m.end = 0.3;
  const double dt = 1e-3;
  EXPECT_EQ(pose(m, 50, dt).translation.x, 0);
  EXPECT_FALSE(pose(m, 50, dt).moving);
  EXPECT_NEAR(pose(m, 200, dt).translation.x, 0.05, 1e-15);
  EXPECT_EQ(pose(m, 200, dt).velocity.z, -1);
  EXPECT_NEAR(pose(m, 5000, dt).translation.z, -0.2, 1e-15);
  EXPECT_FALSE(pose(m, 5000, dt).moving);
  EXPECT_EQ(pose(m, 5000, dt).velocity.x, 0);
}

TEST(WallMotion, VelocityIsTheDisplacementOfTheStepAlsoAtWindowEndsAndUnderVibration) {
  WallMotion m;
  m.velocity = {0.5, 0.25, 0};
  m.amplitude = {0, 0, 2e-3};
  m.frequency = 50;
  m.phase = 0.1;
  m.start = 0.10037;
  m.end = 0.20051;
  const double dt = 1e-3;
  for (std::int64_t n = 1; n < 300; ++n) {
    const WallPose a = pose(m, n - 1, dt), b = pose(m, n, dt);
    ASSERT_NEAR(length((b.translation - a.translation) - dt * b.velocity), 0, 1e-16) << n;
  }
  // Vibration amplitude and phase as documented: at a quarter turn the displacement is the whole amplitude.
  WallMotion v;
  v.amplitude = {0, 0, 2e-3};
  v.frequency = 50;
  EXPECT_NEAR(pose(v, 5, dt).translation.z, 2e-3, 1e-18);
  EXPECT_NEAR(pose(v, 10, dt).translation.z, 0, 1e-17);
  EXPECT_NEAR(pose(v, 15, dt).translation.z, -2e-3, 1e-18);
}

TEST(WallMotion, RotationIsExactAtQuarterTurnsAndAnIsometryAfterManyTurns) {
  WallMotion m;
  m.rotation_axis = {0, 0, 2};
  m.rotation_rate = 2 * M_PI;
  m.rotation_origin = {1, 0, 0};
  const WallPose quarter = pose(m, 250, 1e-3);
  const Vec3 x = to_world(quarter, {2, 0, 0.5});
  EXPECT_NEAR(length(x - Vec3{1, 1, 0.5}), 0, 4e-16);
  m.rotation_axis = {1, 2, -2};
  const WallPose p = pose(m, 123456789, 1e-3);
  const auto& r = p.rotation;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double s = 0;
      for (int k = 0; k < 3; ++k) s += r[3 * i + k] * r[3 * j + k];
      EXPECT_NEAR(s, i == j ? 1 : 0, 1e-15);
    }
  EXPECT_NEAR(length(to_body(p, to_world(p, {0.3, -0.2, 0.9})) - Vec3{0.3, -0.2, 0.9}), 0, 1e-15);
}

TEST(WallMotion, ContactVelocityIsTheMidStepVelocityOfTheMaterialPoint) {
  WallMotion m;
  m.velocity = {0.1, 0, 0};
  m.rotation_axis = {0, 1, 1};
  m.rotation_rate = 30;
  m.rotation_origin = {0.2, 0.1, 0};
  const double dt = 1e-4;
  const WallPose a = pose(m, 999, dt), b = pose(m, 1000, dt);
  const Vec3 body{0.5, 0.4, -0.3}, now = to_world(b, body);
  const Vec3 mean = (1 / dt) * (now - to_world(a, body));
  EXPECT_NEAR(length(velocity_at(b, now, dt) - mean), 0, 2e-5 * length(mean));
  // The lever of step n alone is first order in omega*dt: the correction must earn its place.
  EXPECT_GT(length(b.velocity + cross(b.omega, now - b.origin - b.translation) - mean), 1e-3 * length(mean));
}

TEST(WallMotion, PoseIsAFunctionOfTheStepNumberAlone) {
  Scene s = scene_with({box_wall({0, 0, 0}, {0.1, 0.1, 0.1})});
  s.walls[0].motion.rotation_rate = 3;
  s.walls[0].motion.amplitude = {0.01, 0, 0};
  s.walls[0].motion.frequency = 7;
  WallSet a(s, 0.02), b(s, 0.02);
  for (std::int64_t n = 0; n <= 1000; ++n) a.set_step(n, 1e-4);
  b.set_step(1000, 1e-4);
  for (int k = 0; k < 9; ++k) EXPECT_EQ(a.pose(0).rotation[k], b.pose(0).rotation[k]);
  EXPECT_EQ(a.pose(0).translation.x, b.pose(0).translation.x);
}

TEST(WallMotion, ContactFollowsTheRotatedWall) {
  Scene s = scene_with({plane_wall({0, 0, 0}, {0, 0, 1})});
  s.walls[0].motion.rotation_axis = {0, 1, 0};
  s.walls[0].motion.rotation_rate = M_PI / 2;  // a quarter turn per second: z -> x
  s.walls[0].motion.velocity = {0.1, 0, 0};
  WallSet walls(s, 0.05);
  walls.set_step(1000, 1e-3);
  const auto a = touch(walls, {0.109, 0.2, 0.3}, 0.01);
  ASSERT_EQ(a.size(), 1u);
  EXPECT_NEAR(a[0].normal.x, 1, 1e-15);
  EXPECT_NEAR(a[0].distance, 0.009, 1e-15);
  EXPECT_NEAR(a[0].velocity.x, 0.1 + M_PI / 2 * 0.3, 1e-3);
}

TEST(WallMotion, WallsActOnlyBetweenAppearAndVanish) {
  Scene s = scene_with({plane_wall({0, 0, 0}, {0, 0, 1})});
  s.walls[0].appear = 0.25;
  s.walls[0].vanish = 0.5;
  WallSet walls(s, 0.05);
  EXPECT_TRUE(walls.any_moving());
  const double dt = 0.125;
  for (std::int64_t n = 0; n < 8; ++n) {
    walls.set_step(n, dt);
    EXPECT_EQ(touch(walls, {0, 0, 0.009}, 0.01).size(), n == 2 || n == 3 ? 1u : 0u) << n;
    EXPECT_EQ(walls.surfaces()[0].triangles.empty(), !(n == 2 || n == 3));
  }
  walls.set_step(1, dt);
  walls.mark(0, dt, 0, 0);
  EXPECT_FALSE(walls.expired());
  walls.set_step(2, dt);
  EXPECT_TRUE(walls.expired());
}

TEST(WallSkin, IsClampedStoredAndZeroForRestingWalls) {
  Scene s = scene_with({plane_wall({0, 0, 0}, {0, 0, 1}), plane_wall({0, 0, 0}, {0, 0, 1})});
  s.walls[1].motion.velocity = {0, 0, 2};
  WallSet walls(s, 0.05);
  walls.set_step(10, 1e-4);
  walls.mark(50, 1e-4, 1e-4, 0.02);
  EXPECT_EQ(walls.skin(0), 0);
  EXPECT_NEAR(walls.skin(1), 50 * 2 * 1e-4, 1e-15);
  walls.mark(500, 1e-4, 1e-4, 0.02);
  EXPECT_EQ(walls.skin(1), 0.02);
  walls.mark(0, 1e-4, 1e-3, 0.02);
  EXPECT_EQ(walls.skin(1), 1e-3);
  walls.set_step(14, 1e-4);
  EXPECT_FALSE(walls.expired());  // 0.8 mm
  walls.set_step(16, 1e-4);
  EXPECT_TRUE(walls.expired());  // 1.2 mm
}

TEST(WallSkin, MotionsThatLeaveTheSurfaceInPlaceNeverExpire) {
  Scene s = scene_with({cone_wall({0.1, 0, 0}, {0, 1, 0}, 0.5, 0.3, 0.3), plane_wall({0, 0, -1}, {0, 0, 1})});
  s.walls[0].motion.rotation_axis = {0, -1, 0};
  s.walls[0].motion.rotation_origin = {0.1, 7, 0};
  s.walls[0].motion.rotation_rate = 10;    // a drum
  s.walls[1].motion.velocity = {3, 0, 0};  // a belt
  WallSet walls(s, 0.05);
  walls.mark(0, 1e-3, 1e-6, 1e-3);
  walls.set_step(777, 1e-3);
  EXPECT_FALSE(walls.expired());
  const auto drum = touch(walls, {0.1, 0.2, -0.295}, 0.01);
  ASSERT_EQ(drum.size(), 1u);
  EXPECT_NEAR(length(drum[0].velocity), 3, 1e-3);  // the velocity still is the material's
  EXPECT_NEAR(dot(drum[0].velocity, drum[0].normal), 0, 0.02);
}

// I2 for walls: as long as expired() is false, every particle within its own reach is in the list made at mark().
TEST(WallSkin, NoContactIsMissedUntilTheSkinExpires) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  random_plane(8, 0.05, 0.1, 5, points, facets);
  const std::string file = write_obj("moving.obj", points, facets);
  Scene s = scene_with({mesh_wall(file), cone_wall({0, 0, -0.2}, {0, 1, 1}, 0.3, 0.1, 0.05),
                        plane_wall({0, 0, 0}, {0, 1, 3}), box_wall({-0.3, -0.3, -0.3}, {-0.1, 0, 0.2})});
  s.domain.lower = {-0.5, -0.5, -0.5};
  s.domain.upper = {0.5, 0.5, 0.5};
  for (WallSpec& w : s.walls) {
    w.motion.rotation_axis = {1, 0.5, 0.2};
    w.motion.rotation_rate = 4;
    w.motion.rotation_origin = {0.1, 0.1, 0};
    w.motion.amplitude = {0, 0.01, 0.02};
    w.motion.frequency = 10;
  }
  const double dt = 1e-4, radius = 0.01;
  WallSet walls(s, 0.03);
  const CounterRng rng(77, 2);
  std::uint64_t draw = 0;
  std::int64_t seen = 0, intervals = 0;
  std::vector<std::vector<std::int32_t>> lists;
  std::vector<Vec3> x;
  for (int k = 0; k < 3000; ++k) {
    const double a = rng.uniform(draw++, -0.5, 0.5), b = rng.uniform(draw++, -0.5, 0.5),
                 c = rng.uniform(draw++, -0.5, 0.5);
    x.push_back({a, b, c});
  }
  for (std::int64_t n = 0; n < 400; ++n) {
    walls.set_step(n, dt);
    if (n == 0 || walls.expired()) {
      walls.mark(8, dt, 1e-3, 0.02);
      ++intervals;
      lists.assign(x.size(), {});
      for (std::size_t k = 0; k < x.size(); ++k) walls.candidates(x[k], radius, lists[k]);
    }
    WallContact listed[WallSet::k_max_contacts];
    for (std::size_t k = 0; k < x.size(); ++k) {
      const auto all = touch(walls, x[k], radius);
      const int m = walls.contacts(x[k], radius, lists[k], listed);
      ASSERT_EQ(static_cast<std::size_t>(m), all.size()) << "step " << n << " particle " << k;
      for (int i = 0; i < m; ++i) {
        ASSERT_EQ(listed[i].element, all[i].element);
        ASSERT_EQ(listed[i].distance, all[i].distance);
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, 20000);
  EXPECT_GT(intervals, 20);
  EXPECT_LT(intervals, 200);
}

}  // namespace
}  // namespace talus
