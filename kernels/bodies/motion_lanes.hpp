// The body of motion_batch.hpp for one value type. Formulae and order of operations are those of quaternion.hpp,
// rigid_motion.cpp (core/shapes) and of body_motion.cpp (scheduler/nodes). Included by kernels/isa/bodies_*.cpp only.
#pragma once

#include "core/shapes/support.hpp"
#include "kernels/bodies/lanes.hpp"
#include "kernels/bodies/motion_batch.hpp"

namespace talus::kernels {

/// The lanes of one batch, from `at` on.
template <class S>
struct BodyLanes {
  using B = typename S::B;
  using Vec = shapes::Triple<S>;
  struct Turn {
    B w, x, y, z;
  };
  struct Matrix {
    Vec row[3];
  };

  static Vec add(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  static Vec sub(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  static Vec times(B s, const Vec& a) { return {s * a.x, s * a.y, s * a.z}; }
  static Vec cross(const Vec& a, const Vec& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
  static Vec load(const MotionBatch::Lane* from, int at) {
    return {S::load(from[0] + at), S::load(from[1] + at), S::load(from[2] + at)};
  }
  static void store(MotionBatch::Lane* to, int at, const Vec& v) {
    S::store(to[0] + at, v.x);
    S::store(to[1] + at, v.y);
    S::store(to[2] + at, v.z);
  }

  static Matrix matrix(const Turn& q) {
    const B one = S::set(1), two = S::set(2);
    const B xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
    const B wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return {{{one - two * (yy + zz), two * (xy - wz), two * (xz + wy)},
             {two * (xy + wz), one - two * (xx + zz), two * (yz - wx)},
             {two * (xz - wy), two * (yz + wx), one - two * (xx + yy)}}};
  }
  static Vec to_space(const Matrix& r, const Vec& v) {
    return {shapes::dot<S>(r.row[0], v), shapes::dot<S>(r.row[1], v), shapes::dot<S>(r.row[2], v)};
  }
  static Vec to_body(const Matrix& r, const Vec& v) {
    return {(r.row[0].x * v.x + r.row[1].x * v.y) + r.row[2].x * v.z,
            (r.row[0].y * v.x + r.row[1].y * v.y) + r.row[2].y * v.z,
            (r.row[0].z * v.x + r.row[1].z * v.y) + r.row[2].z * v.z};
  }
  static Turn product(const Turn& a, const Turn& b) {
    return {((a.w * b.w - a.x * b.x) - a.y * b.y) - a.z * b.z, ((a.w * b.x + a.x * b.w) + a.y * b.z) - a.z * b.y,
            ((a.w * b.y - a.x * b.z) + a.y * b.w) + a.z * b.x, ((a.w * b.z + a.x * b.y) - a.y * b.x) + a.z * b.w};
  }
};

/// Free rotation by small angles.
template <class S>
struct LaneRotation {
  using L = BodyLanes<S>;
  using B = typename S::B;
  using M = typename S::M;
  typename L::Turn turn;
  typename L::Vec spin;
  B wide;

  /// Sine over angle, and cosine, of the angle whose square is z; as small_turn().
  struct Small {
    B sine, cosine;
  };
  static Small small(B z) {
    const auto c = [](double value) { return S::set(value); };
    const B s = c(-1.0 / 6) + z * (c(1.0 / 120) + z * (c(-1.0 / 5040) + z * (c(1.0 / 362880) - z * c(1.0 / 39916800))));
    const B k =
        c(1.0 / 24) + z * (c(-1.0 / 720) + z * (c(1.0 / 40320) + z * (c(-1.0 / 3628800) + z * c(1.0 / 479001600))));
    const B h = c(0.5) * z, w = c(1) - h;
    return {c(1) + z * s, w + (((c(1) - w) - h) + (z * z) * k)};
  }
  void see(B z) { wide = S::select(S::lt(z, S::set(0.125 * 0.125)), wide, S::set(1)); }

  void about_spin(B rate) {
    const B half = S::set(0.5) * rate, z = (half * half) * shapes::dot<S>(spin, spin);
    see(z);
    const Small t = small(z);
    const B s = half * t.sine;
    turn = L::product(turn, {t.cosine, s * spin.x, s * spin.y, s * spin.z});
  }

  /// Components along the axis of each lane, and along the two behind it.
  struct Axes {
    M first, last;
    void out_of(const B& x, const B& y, const B& z, B& k, B& a, B& b) const {
      k = S::select(first, x, S::select(last, z, y));
      a = S::select(first, y, S::select(last, x, z));
      b = S::select(first, z, S::select(last, y, x));
    }
    void into(const B& k, const B& a, const B& b, B& x, B& y, B& z) const {
      x = S::select(first, k, S::select(last, a, b));
      y = S::select(first, a, S::select(last, b, k));
      z = S::select(first, b, S::select(last, k, a));
    }
  };

  /// As turn_about(), in the lanes whose rate is not 0.
  void about_axis(B axis, B inverse, B dt) {
    const M on = S::gt(S::abs(inverse), S::set(0));
    if (!S::any(on)) return;
    const Axes axes{S::lt(axis, S::set(0.5)), S::gt(axis, S::set(1.5))};
    B k, a, b, vk, va, vb;
    axes.out_of(spin.x, spin.y, spin.z, k, a, b);
    axes.out_of(turn.x, turn.y, turn.z, vk, va, vb);
    const B x = S::set(0.5) * ((k * inverse) * dt), z = x * x;
    see(z);
    const Small t = small(z);
    const B sine = x * t.sine, cosine = t.cosine;
    const B cos = S::set(1) - S::set(2) * (sine * sine), sin = S::set(2) * (sine * cosine);
    typename L::Vec l;
    axes.into(k, cos * a + sin * b, cos * b - sin * a, l.x, l.y, l.z);
    typename L::Turn q;
    q.w = cosine * turn.w - sine * vk;
    axes.into(cosine * vk + sine * turn.w, cosine * va + sine * vb, cosine * vb - sine * va, q.x, q.y, q.z);
    spin = {S::select(on, l.x, spin.x), S::select(on, l.y, spin.y), S::select(on, l.z, spin.z)};
    turn = {S::select(on, q.w, turn.w), S::select(on, q.x, turn.x), S::select(on, q.y, turn.y),
            S::select(on, q.z, turn.z)};
  }

  /// As restored().
  void restore() {
    const auto& q = turn;
    const B off = ((q.w * q.w + q.x * q.x) + (q.y * q.y + q.z * q.z)) - S::set(1);
    wide = S::select(S::lt(S::abs(off), S::set(1e-8)), wide, S::set(1));
    const B f = S::set(1) - S::set(0.5) * off;
    turn = {f * q.w, f * q.x, f * q.y, f * q.z};
  }
};

/// What the contacts do to the bodies, the arms of the spheres as the bodies lie at n.
template <class S>
struct BodyLoad {
  typename BodyLanes<S>::Vec force, torque;
  typename S::B stiffness;
};

template <class S>
BodyLoad<S> load_of(const MotionBatch& c, int at, const typename BodyLanes<S>::Matrix& r, typename S::B scale) {
  using L = BodyLanes<S>;
  const auto none = S::set(0);
  BodyLoad<S> sum{{none, none, none}, {none, none, none}, none};
  for (int k = 0; k < c.spheres; ++k) {
    const MotionBatch::Sphere& one = c.sphere[k];
    const auto force = L::load(one.force, at);
    const auto arm = L::to_space(r, L::times(scale, L::load(one.place, at)));
    sum.force = L::add(sum.force, force);
    sum.torque = L::add(sum.torque, L::cross(arm, force));
    if (c.rotation != 0)
      sum.torque = L::add(sum.torque, L::times(scale * S::load(one.radius + at), L::load(one.torque, at)));
    sum.stiffness = sum.stiffness + S::load(one.stiffness + at);
  }
  return sum;
}

template <class S>
void move_lanes(MotionBatch& c, int at) {
  using L = BodyLanes<S>;
  using B = typename S::B;
  const B dt = S::set(c.dt), kick = S::set(c.kick), scale = S::load(c.scale + at), mass = S::load(c.mass + at);
  const B inverse_mass = S::load(c.inverse_mass + at);
  const B inverse_inertia = S::set(1) / (mass * (scale * scale));
  const auto inverse = L::times(inverse_inertia, L::load(c.inverse, at));
  const auto spin_by = [&](const typename L::Matrix& r, const typename L::Vec& l) {
    return L::to_space(r, {l.x * inverse.x, l.y * inverse.y, l.z * inverse.z});
  };
  LaneRotation<S> rotation;
  rotation.turn = {S::load(c.turn[0] + at), S::load(c.turn[1] + at), S::load(c.turn[2] + at), S::load(c.turn[3] + at)};
  rotation.wide = S::set(0);
  const auto before = L::matrix(rotation.turn);
  const BodyLoad<S> load = load_of<S>(c, at, before, scale);
  S::store(c.row + at, load.stiffness * inverse_mass);

  const typename L::Vec gravity{S::set(c.gravity[0]), S::set(c.gravity[1]), S::set(c.gravity[2])};
  const auto v =
      L::add(L::add(L::load(c.v, at), L::times(kick, L::times(inverse_mass, load.force))), L::times(kick, gravity));
  rotation.spin = L::add(L::load(c.spin, at), L::times(kick, L::to_body(before, load.torque)));
  const auto spin_before = spin_by(before, rotation.spin);

  const B time = dt * inverse_inertia, half = S::set(0.5) * time;
  const B extra_p = S::load(c.extra_p + at), axis_p = S::load(c.axis_p + at);
  rotation.about_spin(S::load(c.reference + at) * time);
  rotation.about_axis(axis_p, extra_p, half);
  rotation.about_axis(S::load(c.axis_q + at), S::load(c.extra_q + at), time);
  rotation.about_axis(axis_p, extra_p, half);
  rotation.restore();

  const auto after = L::matrix(rotation.turn);
  const auto x = L::add(L::load(c.x, at), L::times(dt, v));
  L::store(c.angular_velocity, at, L::times(S::set(0.5), L::add(spin_before, spin_by(after, rotation.spin))));
  for (int k = 0; k < c.spheres; ++k) {
    MotionBatch::Sphere& one = c.sphere[k];
    const auto place = L::times(scale, L::load(one.place, at));
    const auto arm = L::to_space(after, place);
    L::store(one.at, at, L::add(x, arm));
    L::store(one.velocity, at, L::add(v, L::times(S::set(c.per_step), L::sub(arm, L::to_space(before, place)))));
  }
  L::store(c.x, at, x);
  L::store(c.v, at, v);
  L::store(c.spin, at, rotation.spin);
  S::store(c.turn[0] + at, rotation.turn.w);
  S::store(c.turn[1] + at, rotation.turn.x);
  S::store(c.turn[2] + at, rotation.turn.y);
  S::store(c.turn[3] + at, rotation.turn.z);
  S::store(c.wide + at, rotation.wide);
}

template <class S>
void move_batch(MotionBatch& c) {
  for (int at = 0; at < c.bodies; at += S::W) move_lanes<S>(c, at);
}

}  // namespace talus::kernels
