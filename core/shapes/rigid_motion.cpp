// Implementation of rigid_motion.hpp.
#include "core/shapes/rigid_motion.hpp"

#include <utility>

#include "core/base/det_math.hpp"

namespace talus::shapes {
namespace {

/// Of the angle whose square is z: sine over angle, and cosine. Within rounding below 1/8 rad, which no turn of a step
/// exceeds but where grains spin wildly.
struct Turned {
  double sine, cosine;
};
constexpr double k_small2 = 0.125 * 0.125;
Turned small_turn(double z) noexcept {
  const double s = -1.0 / 6 + z * (1.0 / 120 + z * (-1.0 / 5040 + z * (1.0 / 362880 - z * (1.0 / 39916800))));
  const double c = 1.0 / 24 + z * (-1.0 / 720 + z * (1.0 / 40320 + z * (-1.0 / 3628800 + z * (1.0 / 479001600))));
  const double h = 0.5 * z, w = 1 - h;  // 1 - z/2 loses the low bits of z/2
  return {1 + z * s, w + (((1 - w) - h) + (z * z) * c)};
}

/// sin and cos of half of an angle [rad].
det::SinCos half_turn(double angle) noexcept {
  const double x = 0.5 * angle, z = x * x;
  if (!(z < k_small2)) return det::sincos_turns((0.25 / det::k_pi) * angle);
  const Turned t = small_turn(z);
  return {x * t.sine, t.cosine};
}

/// A turn about the vector `along` by `rate` times its length.
Quaternion about(Vec3 along, double rate) noexcept {
  const double half = 0.5 * rate, z = (half * half) * norm2(along);
  if (z < k_small2) {
    const Turned t = small_turn(z);
    const double s = half * t.sine;
    return {t.cosine, s * along.x, s * along.y, s * along.z};
  }
  const double size = norm(along);
  const auto t = half_turn(size * rate);
  const double s = t.sin / size;
  return {t.cos, s * along.x, s * along.y, s * along.z};
}

/// The body turns about its own axis k; its angular momentum, fixed in space, turns back in its frame.
void turn_about(int k, Quaternion& turn, Vec3& l, double inverse, double dt) noexcept {
  const auto t = half_turn(l[k] * inverse * dt);
  const double cos = 1 - 2 * (t.sin * t.sin), sin = 2 * (t.sin * t.cos);
  const int a = (k + 1) % 3, b = (k + 2) % 3;
  const double la = l[a], lb = l[b];
  l[a] = cos * la + sin * lb;
  l[b] = cos * lb - sin * la;
  Vec3 v{turn.x, turn.y, turn.z};
  const double w = turn.w, vk = v[k], va = v[a], vb = v[b];
  v[k] = t.cos * vk + t.sin * w;
  v[a] = t.cos * va + t.sin * vb;
  v[b] = t.cos * vb - t.sin * va;
  turn = {t.cos * w - t.sin * vk, v.x, v.y, v.z};
}

/// What rounding has taken from the length of a unit quaternion, to first order in it.
Quaternion restored(Quaternion q) noexcept {
  const double off = ((q.w * q.w + q.x * q.x) + (q.y * q.y + q.z * q.z)) - 1;
  if (!(off < 1e-8 && off > -1e-8)) return normalised(q);
  const double f = 1 - 0.5 * off;
  return {f * q.w, f * q.x, f * q.y, f * q.z};
}

}  // namespace

Rotor make_rotor(Vec3 moments) noexcept {
  int r = 1;
  for (int k = 0; k < 3; ++k) {
    const double here = moments[k], one = moments[(k + 1) % 3], two = moments[(k + 2) % 3];
    if ((one <= here && here <= two) || (two <= here && here <= one)) r = k;
  }
  Rotor rotor;
  rotor.inverse = {1 / moments.x, 1 / moments.y, 1 / moments.z};
  rotor.p = (r + 1) % 3;
  rotor.q = (r + 2) % 3;
  rotor.reference = rotor.inverse[r];
  rotor.extra_p = rotor.inverse[rotor.p] - rotor.reference;
  rotor.extra_q = rotor.inverse[rotor.q] - rotor.reference;
  if (rotor.extra_q == 0) {  // a body of revolution turns about its axis once per step, not in two halves
    std::swap(rotor.p, rotor.q);
    std::swap(rotor.extra_p, rotor.extra_q);
  }
  return rotor;
}

void rotate(Quaternion& turn, Vec3& l, const Rotor& rotor, double dt) noexcept {
  turn = turn * about(l, rotor.reference * dt);
  if (rotor.extra_p != 0) turn_about(rotor.p, turn, l, rotor.extra_p, 0.5 * dt);
  if (rotor.extra_q != 0) turn_about(rotor.q, turn, l, rotor.extra_q, dt);
  if (rotor.extra_p != 0) turn_about(rotor.p, turn, l, rotor.extra_p, 0.5 * dt);
  turn = restored(turn);
}

void drift(RigidState& s, const Rotor& rotor, double dt) noexcept {
  s.x = s.x + dt * s.v;
  rotate(s.turn, s.l, rotor, dt);
}

void kick(RigidState& s, double inverse_mass, Vec3 force, Vec3 torque, double dt) noexcept {
  s.v = s.v + (dt * inverse_mass) * force;
  s.l = s.l + dt * to_body(rotation(s.turn), torque);
}

Vec3 angular_velocity(const RigidState& s, const Rotor& rotor) noexcept {
  return to_space(rotation(s.turn), {s.l.x * rotor.inverse.x, s.l.y * rotor.inverse.y, s.l.z * rotor.inverse.z});
}

Vec3 angular_momentum(const RigidState& s) noexcept { return to_space(rotation(s.turn), s.l); }

double rotation_energy(const RigidState& s, const Rotor& rotor) noexcept {
  return 0.5 * ((s.l.x * s.l.x * rotor.inverse.x + s.l.y * s.l.y * rotor.inverse.y) + s.l.z * s.l.z * rotor.inverse.z);
}

Vec3 velocity_at(const RigidState& s, const Rotor& rotor, Vec3 point) noexcept {
  return s.v + cross(angular_velocity(s, rotor), point - s.x);
}

}  // namespace talus::shapes
