// Wall poses. Who calls it: core/walls/walls.cpp. Invariants: see the header.
#include "core/walls/wall_motion.hpp"

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/walls/wall_elements.hpp"

namespace talus {
namespace {

constexpr double k_turns_per_radian = 0.15915494309189533577;

/// Time spent in the motion's window up to time t [s].
double time_moved(const WallMotion& m, double t) {
  const double after_end = t < m.end ? t : m.end;
  const double tau = after_end - m.start;
  return m.start > 0 && tau < 0 ? 0 : tau;
}

/// Rodrigues' rotation matrix about the unit axis u by an angle in turns, row by row.
std::array<double, 9> rotation_matrix(Vec3 u, double turns) {
  const auto [s, c] = det::sincos_turns(turns);
  const double h = det::sincos_turns(0.5 * turns).sin;
  const double v = c > 0.5 ? 2 * (h * h) : 1 - c;  // 1 - cos without cancellation, exact at quarter turns
  return {c + v * u.x * u.x,       v * u.x * u.y - s * u.z, v * u.x * u.z + s * u.y,
          v * u.x * u.y + s * u.z, c + v * u.y * u.y,       v * u.y * u.z - s * u.x,
          v * u.x * u.z - s * u.y, v * u.y * u.z + s * u.x, c + v * u.z * u.z};
}

}  // namespace

WallPose pose_at(const WallMotion& m, double appear, double vanish, std::int64_t n, double dt) {
  WallPose p;
  const double t = static_cast<double>(n) * dt, before = static_cast<double>(n - 1) * dt;
  p.active = t >= appear && t < vanish;
  p.origin = m.rotation_origin;
  if (!m.any()) return p;

  const double tau = time_moved(m, t), tau_before = time_moved(m, before);
  p.translation = tau * m.velocity;
  // Over a step wholly inside the window the factor is 1 to rounding; it must be exact for a steady wall.
  const bool steady = t < m.end && (before >= m.start || m.start <= 0);
  const double share = steady ? 1 : (tau - tau_before) / dt;
  p.velocity = share * m.velocity;
  if (norm2(m.amplitude) > 0 && m.frequency != 0) {
    const double now = det::sincos_turns(m.frequency * tau + m.phase).sin;
    const double then = det::sincos_turns(m.frequency * tau_before + m.phase).sin;
    p.translation = p.translation + now * m.amplitude;
    p.velocity = p.velocity + ((now - then) / dt) * m.amplitude;
  }
  if (m.rotation_rate != 0) {
    const Vec3 u = unit(m.rotation_axis);
    p.rotation = rotation_matrix(u, (m.rotation_rate * tau) * k_turns_per_radian);
    p.rotated = tau != 0;
    p.omega = (share * m.rotation_rate) * u;
  }
  p.moving = norm2(p.velocity) > 0 || norm2(p.omega) > 0;
  return p;
}

double travel(const WallPose& from, const WallPose& to, std::span<const Vec3> corners) noexcept {
  if (!from.rotated && !to.rotated) return std::sqrt(norm2(to.translation - from.translation));
  double most = 0;
  for (const Vec3 x : corners) most = fmax2(most, norm2(to_world(to, x) - to_world(from, x)));
  return std::sqrt(most);
}

double fastest(const WallPose& p, std::span<const Vec3> corners) noexcept {
  if (!p.moving) return 0;
  double most = norm2(p.velocity);
  if (norm2(p.omega) > 0)
    for (const Vec3 x : corners) {
      const Vec3 arm = to_world(p, x) - (p.origin + p.translation);
      most = fmax2(most, norm2(p.velocity + cross(p.omega, arm)));
    }
  return std::sqrt(most);
}

MovingTime moving_time(const WallMotion& m, double appear, double vanish, double end) noexcept {
  if (!m.any()) return {};
  const double begin = m.start > 0 ? m.start : 0;  // a window that starts at 0 or earlier is steady motion
  return {fmax2(begin, appear), fmin2(m.end, fmin2(vanish, end))};
}

double peak_speed(Vec3 v, Vec3 omega, double arm) noexcept {
  const double w2 = norm2(omega);
  if (!(w2 > 0)) return std::sqrt(norm2(v));
  const double w = std::sqrt(w2), along = dot(v, omega) / w;
  const double across = std::sqrt(fmax2(0, norm2(v) - along * along)) + w * arm;
  return std::sqrt(along * along + across * across);
}

double peak_speed(const WallMotion& m, double arm) noexcept {
  const Vec3 omega = m.rotation_rate != 0 ? m.rotation_rate * unit(m.rotation_axis) : Vec3{};
  const Vec3 shake = (2 * det::k_pi * m.frequency) * m.amplitude;
  return fmax2(peak_speed(m.velocity + shake, omega, arm), peak_speed(m.velocity - shake, omega, arm));
}

double farthest_from_axis(Vec3 origin, Vec3 axis, std::span<const Vec3> points) noexcept {
  const Vec3 u = unit(axis);
  double most = 0;
  for (const Vec3 x : points) most = fmax2(most, norm2(cross(u, x - origin)));
  return std::sqrt(most);
}

bool move_alike(const WallMotion& a, const WallMotion& b) noexcept {
  if (!a.any() || !b.any()) return a.any() == b.any();
  const auto same = [](Vec3 u, Vec3 v) { return u.x == v.x && u.y == v.y && u.z == v.z; };
  const bool turn =
      a.rotation_rate == b.rotation_rate &&
      (a.rotation_rate == 0 || (same(a.rotation_axis, b.rotation_axis) && same(a.rotation_origin, b.rotation_origin)));
  const bool shake = same(a.amplitude, b.amplitude) && a.frequency == b.frequency && a.phase == b.phase;
  return same(a.velocity, b.velocity) && turn && shake && a.start == b.start && a.end == b.end;
}

}  // namespace talus
