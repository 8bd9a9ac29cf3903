// Poses of moving walls as functions of the step number, and bounds on how far a wall travels between two poses.
// Who calls it: core/walls/walls.cpp. Invariants: I4 (a pose depends on n, dt and the motion only and is never
// accumulated), I2 (travel bounds the displacement of every material point of the box given by its corners).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/scene/scene.hpp"
#include "core/walls/walls.hpp"

namespace talus {

/// Body-frame coordinates of a world point: inverse rotation about the pose's origin, after the inverse translation.
inline Vec3 to_body(const WallPose& p, Vec3 x) noexcept {
  if (!p.rotated) return x - p.translation;
  const Vec3 d = (x - p.translation) - p.origin;
  const auto& m = p.rotation;
  return Vec3{m[0] * d.x + m[3] * d.y + m[6] * d.z, m[1] * d.x + m[4] * d.y + m[7] * d.z,
              m[2] * d.x + m[5] * d.y + m[8] * d.z} +
         p.origin;
}

/// Within [appear, vanish).
inline bool acts_at(const WallSpec& w, std::int64_t n, double dt) noexcept {
  const double t = static_cast<double>(n) * dt;
  return t >= w.appear && t < w.vanish;
}

/// World direction of a body-frame direction.
inline Vec3 direction_to_world(const WallPose& p, Vec3 d) noexcept {
  if (!p.rotated) return d;
  const auto& m = p.rotation;
  return {m[0] * d.x + m[1] * d.y + m[2] * d.z, m[3] * d.x + m[4] * d.y + m[5] * d.z,
          m[6] * d.x + m[7] * d.y + m[8] * d.z};
}

/// World coordinates of a body-frame point.
inline Vec3 to_world(const WallPose& p, Vec3 x) noexcept {
  if (!p.rotated) return x + p.translation;
  return (direction_to_world(p, x - p.origin) + p.origin) + p.translation;
}

/// Pose of a wall at step n [t = n*dt, s]. Within [start, end) of the motion: translation by velocity, rotation by
/// rotation_rate about rotation_axis through rotation_origin (carried along by the translation), vibration
/// amplitude * sin(2 pi (frequency * (t - start) + phase)); outside the window the wall rests where the window left it.
/// A window that starts at 0 or earlier is taken as steady motion: the wall has its velocity at step 0 already.
/// velocity and omega are the means over the step [n-1, n], that is the mid-step values.
WallPose pose_at(const WallMotion& motion, double appear, double vanish, std::int64_t n, double dt);

/// Velocity at the mid-step n-1/2 of the material point that lies at world point x at step n [m/s].
inline Vec3 velocity_at(const WallPose& p, Vec3 x, double dt) noexcept {
  if (!p.moving) return {};
  const Vec3 arm = x - (p.origin + p.translation);
  // The arm half a step ago: with it the displacement over the step is right to third order in omega*dt.
  return p.velocity + cross(p.omega, arm - (0.5 * dt) * cross(p.omega, arm));
}

/// Largest displacement [m] between two poses of any material point inside the convex hull of body-frame `corners`
/// (a displacement is affine in the point, its length convex: the maximum is at a corner).
double travel(const WallPose& from, const WallPose& to, std::span<const Vec3> corners) noexcept;

/// At rest both, or the same motion.
bool move_alike(const WallMotion& a, const WallMotion& b) noexcept;

/// Part of a run in which a wall that acts within [appear, vanish) moves: [from, to) [s]; empty where it never does
/// while it acts. `end` [s]: of the run.
struct MovingTime {
  double from = 0, to = 0;
  bool any() const noexcept { return from < to; }
};
MovingTime moving_time(const WallMotion& motion, double appear, double vanish, double end) noexcept;

/// Largest speed [m/s] of a point at distance `arm` [m] from the axis of rotation while the wall moves, whatever its
/// direction then: translation and the peak of the vibration V = v +- 2 pi f A, whose part across the axis adds to
/// |omega| arm once per turn.
double peak_speed(const WallMotion& motion, double arm) noexcept;

/// The same of a wall with velocity v and angular velocity omega.
double peak_speed(Vec3 v, Vec3 omega, double arm) noexcept;

/// Largest distance [m] of the points from the line through `origin` along `axis` (any length).
double farthest_from_axis(Vec3 origin, Vec3 axis, std::span<const Vec3> points) noexcept;

/// Largest speed [m/s] at this pose of any material point inside the hull of body-frame `corners`.
double fastest(const WallPose& p, std::span<const Vec3> corners) noexcept;

}  // namespace talus
