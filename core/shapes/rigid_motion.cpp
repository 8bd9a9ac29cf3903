// Implementation of rigid_motion.hpp.
#include "core/shapes/rigid_motion.hpp"

#include "core/base/det_math.hpp"

namespace talus::shapes {
namespace {

constexpr double k_half_turns = 0.25 / det::k_pi;  // half of an angle [rad], in turns

Quaternion about(Vec3 axis, double angle) noexcept {
  const auto t = det::sincos_turns(k_half_turns * angle);
  return {t.cos, t.sin * axis.x, t.sin * axis.y, t.sin * axis.z};
}

/// The body turns about its own axis k; its angular momentum, fixed in space, turns back in its frame.
void turn_about(int k, Quaternion& turn, Vec3& l, double inverse, double dt) noexcept {
  const double angle = l[k] * inverse * dt;
  Vec3 axis;
  axis[k] = 1;
  const auto t = det::sincos_turns(2 * k_half_turns * angle);
  const int a = (k + 1) % 3, b = (k + 2) % 3;
  const double la = l[a], lb = l[b];
  l[a] = t.cos * la + t.sin * lb;
  l[b] = t.cos * lb - t.sin * la;
  turn = turn * about(axis, angle);
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
  return rotor;
}

void rotate(Quaternion& turn, Vec3& l, const Rotor& rotor, double dt) noexcept {
  const double size = norm(l);
  if (size > 0) turn = turn * about((1 / size) * l, size * rotor.reference * dt);
  if (rotor.extra_p != 0) turn_about(rotor.p, turn, l, rotor.extra_p, 0.5 * dt);
  if (rotor.extra_q != 0) turn_about(rotor.q, turn, l, rotor.extra_q, dt);
  if (rotor.extra_p != 0) turn_about(rotor.p, turn, l, rotor.extra_p, 0.5 * dt);
  turn = normalised(turn);
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
