// See body_motion.hpp. Kick and drift as for spheres; the free rotation is that of core/shapes/rigid_motion.hpp.
// Invariants: I3 (rows of a body are summed in their order), I4, I7 (a body's rows lie in one chunk).
//   v(n+1/2) = v(n-1/2) + (F/m + g) dt,  L(n+1/2) = L(n-1/2) + T dt,  T = sum of r x F + own torques
// A sphere's velocity row is the chord of its way, (x(n+1) - x(n)) / dt, as it is for a free sphere; its spin the mean
// of the angular velocities at both ends.
#include "scheduler/nodes/body_motion.hpp"

#include <algorithm>

#include "core/base/det_math.hpp"
#include "scheduler/nodes/body_batch.hpp"
#include "scheduler/nodes/body_rows.hpp"

namespace talus {

namespace {

using shapes::Quaternion;
using shapes::Rotation;

/// Sum over the rows of a body.
struct Load {
  Vec3 force, torque;
  double stiffness = 0;  ///< of superquadrics: times what answers each contact over 1/m
  double levered = 0;    ///< stiffness times (1 + m arm^2 / I) at most: force on a sphere turns the body, too
};

Load load_of(const BodyMotion& m, const BodyShape& shape, double scale, const Rotation& r, Row i) {
  Load sum;
  for (const shapes::SubSphere& part : shape.spheres) {
    double* f = force_row(m, i);
    const Vec3 force{f[0], f[1], f[2]};
    sum.force = sum.force + force;
    sum.torque = sum.torque + cross(shapes::to_space(r, scale * part.x), force);
    if (m.rules.has.rotation) sum.torque = sum.torque + (scale * part.r) * Vec3{f[4], f[5], f[6]};
    sum.stiffness = sum.stiffness + f[3];
    if (m.clock.sampled) sum.levered = sum.levered + f[3] * (1 + norm2(part.x) * shape.rotor.inverse.x);
    std::fill(f, f + m.rows.stride, 0.0);
    ++i;
  }
  return sum;
}

/// A turn about an axis in space by a rotation vector.
Quaternion turned(Quaternion q, Vec3 angle) {
  const double size = norm(angle);
  if (!(size > 0)) return q;
  const auto t = det::sincos_turns(size * (0.25 / det::k_pi));
  const Vec3 axis = (t.sin / size) * angle;
  return shapes::normalised(Quaternion{t.cos, axis.x, axis.y, axis.z} * q);
}

/// Part of v along f, which it follows; at most `most`.
Vec3 following(Vec3 v, Vec3 f, Vec3 gain, double most) {
  const double f2 = norm2(f), along = dot(v, f);
  Vec3 u = gain;
  if (along > 0 && f2 > 0) u = (along / f2) * f + gain;
  const double size = norm(u);
  return size > most ? (most / size) * u : u;
}

/// While an overlapping start relaxes: relax.cpp says how.
void relax(const BodyMotion& m, const BodyShape& shape, double scale, double inverse_mass, double inverse_inertia,
           const Load& load, const Rotation& r, BodyState& s) {
  const double dt = m.rules.scene.dt, way = m.rules.scene.relax.displacement * scale * shape.smallest;
  const bool first = m.clock.step == 0;
  s.v = following(first ? Vec3{} : s.v, load.force, (dt * inverse_mass) * load.force, way / dt);
  const Vec3 torque = shapes::to_body(r, load.torque);
  s.spin = following(first ? Vec3{} : s.spin, torque, dt * torque, 1e300);
  const double turn = norm(spin_of(shape, inverse_inertia, r, s.spin)) * dt * scale * shape.bound;
  if (turn > way) s.spin = (way / turn) * s.spin;
}

/// Cundall's local damping: a fraction of each component that opposes the motion. Returns what it takes away.
Vec3 local_drag(double share, Vec3 v, Vec3 f) {
  Vec3 drag;
  for (int k = 0; k < 3; ++k) {
    const double size = f[k] < 0 ? -f[k] : f[k];
    drag[k] = v[k] != 0 ? (v[k] > 0 ? share : -share) * size : 0.0;
  }
  return drag;
}

/// Velocity and angular momentum from n-1/2 to n+1/2. Returns what local damping has dissipated [J].
double kick_body(const BodyMotion& m, const BodyShape& shape, double mass, double inverse_mass, double inverse_inertia,
                 const Load& load, const Rotation& r, BodyState& s) {
  const Scene& scene = m.rules.scene;
  const Vec3 gravity = m.clock.gravity;
  Vec3 torque = load.torque, a = inverse_mass * load.force + gravity;
  const Vec3 v = s.v;
  double lost = 0;
  if (scene.local_damping == 0 && scene.viscous_damping == 0) {
    s.v = s.v + m.kick * (inverse_mass * load.force) + m.kick * gravity;
    s.spin = s.spin + m.kick * shapes::to_body(r, torque);
    return 0;
  }
  const Vec3 w = spin_of(shape, inverse_inertia, r, s.spin);
  const Vec3 drag = local_drag(scene.local_damping, v, a), brake = local_drag(scene.local_damping, w, torque);
  s.v = v + m.kick * ((a - drag) - scene.viscous_damping * v);
  s.spin = s.spin + m.kick * (shapes::to_body(r, torque - brake) - scene.viscous_damping * s.spin);
  if (scene.local_damping != 0)
    lost = mass * dot(drag, 0.5 * (v + s.v)) + dot(brake, 0.5 * (w + spin_of(shape, inverse_inertia, r, s.spin)));
  return scene.dt * lost;
}

/// Rows and body of one that is gone keep their dead values.
void keep_dead(const BodyMotion& m, std::int32_t b, Row i, Row count) {
  const long stride = m.rows.stride;
  std::copy_n(m.rows.p.data() + 4L * i, 4L * count, m.rows.p2.data() + 4L * i);
  std::copy_n(m.rows.v.data() + stride * i, stride * count, m.rows.v2.data() + stride * i);
  std::fill_n(force_row(m, i), stride * count, 0.0);
  write_body(m.rows.bodies, b, state_of(m.rows.bodies, b));
}

/// As spin_of().
Vec3 spin_by(Vec3 inverse, const Rotation& r, Vec3 l) {
  return shapes::to_space(r, {l.x * inverse.x, l.y * inverse.y, l.z * inverse.z});
}

}  // namespace

void move_body(const BodyMotion& m, std::int32_t b, Row i) {
  Bodies& bodies = m.rows.bodies;
  const BodyShape& shape = shape_of(m.rules, bodies, b);
  const auto count = static_cast<Row>(shape.spheres.size());
  if (!m.rows.is_alive(i)) return keep_dead(m, b, i, count);
  const double scale = bodies.scale(b), mass = bodies.mass(b), inverse_mass = bodies.v[4L * b + 3],
               dt = m.rules.scene.dt;
  const double inverse_inertia = 1 / (mass * (scale * scale));  // as inertia_scale()
  const Vec3 inverse = inverse_inertia * shape.rotor.inverse;
  BodyState s = state_of(bodies, b);
  const Rotation before = shapes::rotation(s.turn);
  const Load load = load_of(m, shape, scale, before, i);
  Vec3 spin = s.spin;
  if (inverse_mass > 0) {
    if (!m.relaxing && load.stiffness * inverse_mass > stiffest(m, shape)) m.c.result.unstable_row = i;
    if (load.levered * inverse_mass > m.c.result.body_row) {
      m.c.result.body_row = load.levered * inverse_mass;
      m.c.result.body_row_of = m.rows.id[i];
    }
    if (m.relaxing) {
      relax(m, shape, scale, inverse_mass, inverse_inertia, load, before, s);
    } else {
      const double lost = kick_body(m, shape, mass, inverse_mass, inverse_inertia, load, before, s);
      if (m.rules.has.energies && m.rules.scene.local_damping != 0) m.energy[4L * i + 3] = lost;
    }
    spin = spin_by(inverse, before, s.spin);
    shapes::rotate(s.turn, s.spin, shape.rotor, dt * inverse_inertia);
  } else {
    s.turn = turned(s.turn, dt * s.spin);
  }
  const Rotation after = shapes::rotation(s.turn);
  if (inverse_mass > 0) spin = 0.5 * (spin + spin_by(inverse, after, s.spin));
  const Vec3 centre = s.x + dt * s.v;
  Row row = i;
  for (const shapes::SubSphere& part : shape.spheres) {
    const Vec3 x = scale * part.x, arm = shapes::to_space(after, x);
    write_row(m, row, centre + arm, s.v + m.per_step * (arm - shapes::to_space(before, x)), spin, inverse_mass);
    ++row;
  }
  s.x = in_domain(m.rules, centre);
  if (m.last && inverse_mass > 0) s.v = s.spin = {};
  write_body(bodies, b, s);
  note_outside(m, i, s.x);
}

void move_bodies(const Rules& rules, const Clock& clock, Rows& rows, const Lists& lists, Column<double>& energy,
                 Chunk& c) {
  const Scene& scene = rules.scene;
  const bool half = clock.step == 0 && scene.integrator == Integrator::velocity_verlet;
  const BodyMotion m{.rules = rules,
                     .clock = clock,
                     .rows = rows,
                     .lists = lists,
                     .energy = energy,
                     .c = c,
                     .kick = half ? 0.5 * scene.dt : scene.dt,
                     .per_step = 1 / scene.dt,
                     .relaxing = clock.step < scene.relax.steps,
                     .last = clock.step + 1 == scene.relax.steps,
                     .drifts = lists.skin.drifts()};
  c.result.body_row = 0;
  BodyBatch* batch = begin_batch(m);
  for (Row i = c.lo; i < c.hi;) {
    const std::int32_t b = rows.body[static_cast<std::size_t>(i)];
    if (b < 0) {
      ++i;
      continue;
    }
    const BodyShape& shape = shape_of(rules, rows.bodies, b);
    if (batch != nullptr && fits_batch(m, b, i, shape))
      enter_batch(m, *batch, b, i, shape);
    else
      move_body(m, b, i);
    i += static_cast<Row>(shape.spheres.size());
  }
  if (batch != nullptr) move_batch(m, *batch);
  std::sort(c.result.out.begin(), c.result.out.begin() + c.result.out_count);  // removed in row order (I3)
}

}  // namespace talus
