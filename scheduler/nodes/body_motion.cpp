// See body_motion.hpp. Kick and drift as for spheres; the free rotation is that of core/shapes/rigid_motion.hpp.
// Invariants: I3 (rows of a body are summed in their order), I4, I7 (a body's rows lie in one chunk).
//   v(n+1/2) = v(n-1/2) + (F/m + g) dt,  L(n+1/2) = L(n-1/2) + T dt,  T = sum of r x F + own torques
// A sphere's velocity row is the chord of its way, (x(n+1) - x(n)) / dt, as it is for a free sphere; its spin the mean
// of the angular velocities at both ends.
#include "scheduler/nodes/body_motion.hpp"

#include <algorithm>

#include "core/base/det_math.hpp"
#include "scheduler/lists/skin_check.hpp"

namespace talus {

namespace {

using shapes::Quaternion;
using shapes::Rotation;

/// What all bodies of a chunk have in common.
struct Motion {
  const Rules& rules;
  const Clock& clock;
  Rows& rows;
  const Lists& lists;
  Column<double>& energy;
  Chunk& c;
  double kick, per_step;  ///< [s], 1/dt [1/s]
  bool relaxing, last;    ///< it relaxes, for the last time
};

/// Sum over the rows of a body.
struct Load {
  Vec3 force, torque;
  double stiffness = 0;  ///< of superquadrics: times what answers each contact over 1/m
  double levered = 0;    ///< stiffness times (1 + m arm^2 / I) at most: force on a sphere turns the body, too
};

double* force_row(const Motion& m, Row i) {
  return m.c.scratch->f.data() + static_cast<std::ptrdiff_t>(m.rows.stride) * (i - m.c.lo);
}

Load load_of(const Motion& m, const BodyShape& shape, double scale, const Rotation& r, Row i) {
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
void relax(const Motion& m, const BodyShape& shape, double scale, double inverse_mass, double inverse_inertia,
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
double kick_body(const Motion& m, const BodyShape& shape, double mass, double inverse_mass, double inverse_inertia,
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

/// wrapped(), told apart at once where no side has been passed.
Vec3 in_domain(const Rules& rules, Vec3 x) {
  const Vec3 end = rules.size;
  const bool in = x.x >= 0 && x.x < end.x && x.y >= 0 && x.y < end.y && x.z >= 0 && x.z < end.z;
  return in ? x : wrapped(rules, x);
}

/// The row of a sphere: `centre` not wrapped.
void write_row(const Motion& m, Row i, Vec3 centre, Vec3 before, Vec3 off, Vec3 velocity, Vec3 spin,
               double inverse_mass) {
  const Rules& rules = m.rules;
  const double* p = m.rows.p.data() + 4L * i;
  double *p2 = m.rows.p2.data() + 4L * i, *v2 = m.rows.v2.data() + static_cast<long>(m.rows.stride) * i;
  const Vec3 x = in_domain(rules, centre + off), v = velocity + m.per_step * (off - before);
  for (int k = 0; k < 3; ++k) p2[k] = x[k], v2[k] = m.last ? 0.0 : v[k];
  p2[3] = p[3];
  if (rules.has.rotation) {
    v2[3] = 0;
    for (int k = 0; k < 3; ++k) v2[4 + k] = m.relaxing ? 0.0 : p[3] * spin[k];
  }
  v2[m.rows.stride - 1] = inverse_mass;
}

/// Has the row left the guarantee of its list (kernels/passes/integrate.hpp)?
bool expired(const Motion& m, Row i) {
  const double *x = m.rows.p2.data() + 4L * i, *ref = m.lists.x0.data() + 4L * i;
  Vec3 d{x[0] - ref[0], x[1] - ref[1], x[2] - ref[2]};
  if (m.lists.skin.drifts())
    d = d - (static_cast<double>(m.clock.step + 1 - m.lists.frame.built) * m.rules.scene.dt) * m.lists.drift_of(i);
  bool far = false;  // from a place before a side has wrapped it
  for (int k = 0; k < 3; ++k) far = far || !(d[k] < 0.4 * m.rules.size[k] && d[k] > -0.4 * m.rules.size[k]);
  if (far) d = m.rules.scene.domain.box().nearest_of_any(d);
  return !(norm2(d) <= ref[3]);
}

void write_body(Bodies& bodies, std::int32_t b, const BodyState& s) {
  double *x = bodies.x2.data() + 4L * b, *v = bodies.v2.data() + 4L * b, *q = bodies.turn2.data() + 4L * b,
         *l = bodies.spin2.data() + 4L * b;
  for (int k = 0; k < 3; ++k) x[k] = s.x[k], v[k] = s.v[k], l[k] = s.spin[k];
  x[3] = bodies.x[4L * b + 3];
  v[3] = bodies.v[4L * b + 3];
  l[3] = 0;
  q[0] = s.turn.w, q[1] = s.turn.x, q[2] = s.turn.y, q[3] = s.turn.z;
}

/// Rows and body of one that is gone keep their dead values.
void keep_dead(const Motion& m, std::int32_t b, Row i, Row count) {
  const long stride = m.rows.stride;
  std::copy_n(m.rows.p.data() + 4L * i, 4L * count, m.rows.p2.data() + 4L * i);
  std::copy_n(m.rows.v.data() + stride * i, stride * count, m.rows.v2.data() + stride * i);
  std::fill_n(force_row(m, i), stride * count, 0.0);
  write_body(m.rows.bodies, b, state_of(m.rows.bodies, b));
}

bool outside(const Rules& rules, Vec3 x) {
  bool out = false;
  for (int k = 0; k < 3; ++k) out = out || (!rules.scene.domain.periodic(k) && !(x[k] >= 0 && x[k] < rules.size[k]));
  return out;
}

/// As spin_of().
Vec3 spin_by(Vec3 inverse, const Rotation& r, Vec3 l) {
  return shapes::to_space(r, {l.x * inverse.x, l.y * inverse.y, l.z * inverse.z});
}

void move_body(const Motion& m, std::int32_t b, Row i) {
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
    // the stiffness of superquadrics counts what turns, too: six motions share it instead of three
    const double bound = shape.quadric && !shape.quadric->ball ? 2 * m.rules.bounds.unstable : m.rules.bounds.unstable;
    if (!m.relaxing && load.stiffness * inverse_mass > bound) m.c.result.unstable_row = i;
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
    const Vec3 x = scale * part.x;
    write_row(m, row, centre, shapes::to_space(before, x), shapes::to_space(after, x), s.v, spin, inverse_mass);
    if (expired(m, row)) m.c.result.expired = 1;
    ++row;
  }
  s.x = in_domain(m.rules, centre);
  if (m.last && inverse_mass > 0) s.v = s.spin = {};
  write_body(bodies, b, s);
  if (outside(m.rules, s.x)) m.c.result.out[static_cast<std::size_t>(m.c.result.out_count++)] = i;
}

}  // namespace

void move_bodies(const Rules& rules, const Clock& clock, Rows& rows, const Lists& lists, Column<double>& energy,
                 Chunk& c) {
  const Scene& scene = rules.scene;
  const bool half = clock.step == 0 && scene.integrator == Integrator::velocity_verlet;
  const Motion m{rules,
                 clock,
                 rows,
                 lists,
                 energy,
                 c,
                 half ? 0.5 * scene.dt : scene.dt,
                 1 / scene.dt,
                 clock.step < scene.relax.steps,
                 clock.step + 1 == scene.relax.steps};
  c.result.body_row = 0;
  for (Row i = c.lo; i < c.hi;) {
    const std::int32_t b = rows.body[static_cast<std::size_t>(i)];
    if (b < 0) {
      ++i;
      continue;
    }
    move_body(m, b, i);
    i += static_cast<Row>(shape_of(rules, rows.bodies, b).spheres.size());
  }
  std::sort(c.result.out.begin(), c.result.out.begin() + c.result.out_count);  // removed in row order (I3)
}

}  // namespace talus
