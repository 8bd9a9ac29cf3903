// How a body that has moved is written: its own columns and the rows of its spheres. Who calls it: body_motion.cpp (one
// by one) and body_batch.cpp (many at once). Invariants: I4, I7 (a body's rows lie in one chunk).
#pragma once

#include <algorithm>

#include "scheduler/lists/lists.hpp"
#include "scheduler/lists/skin_check.hpp"
#include "scheduler/state/contacts.hpp"

namespace talus {

/// What all bodies of a chunk have in common.
struct BodyMotion {
  const Rules& rules;
  const Clock& clock;
  Rows& rows;
  const Lists& lists;
  Column<double>& energy;
  Chunk& c;
  double kick, per_step;  ///< [s], 1/dt [1/s]
  bool relaxing, last;    ///< it relaxes, for the last time
  bool drifts;            ///< rows of lists have a velocity
};

inline double* force_row(const BodyMotion& m, Row i) {
  return m.c.scratch->f.data() + static_cast<std::ptrdiff_t>(m.rows.stride) * (i - m.c.lo);
}

/// Component by component: as a loop over Vec3 it goes through the stack, and wide loads wait for narrow stores.
inline void put3(double* to, Vec3 v) {
  to[0] = v.x;
  to[1] = v.y;
  to[2] = v.z;
}

/// wrapped(), told apart at once where no side has been passed.
inline Vec3 in_domain(const Rules& rules, Vec3 x) {
  const Vec3 end = rules.size;
  const bool in = x.x >= 0 && x.x < end.x && x.y >= 0 && x.y < end.y && x.z >= 0 && x.z < end.z;
  return in ? x : wrapped(rules, x);
}

/// Has the row left the guarantee of its list (kernels/passes/integrate.hpp)? x: its new place.
inline bool expired(const BodyMotion& m, Row i, Vec3 x) {
  const double* ref = m.lists.x0.data() + 4L * i;
  Vec3 d{x.x - ref[0], x.y - ref[1], x.z - ref[2]};
  if (m.drifts)
    d = d - (static_cast<double>(m.clock.step + 1 - m.lists.frame.built) * m.rules.scene.dt) * m.lists.drift_of(i);
  if (norm2(d) <= ref[3]) return false;  // its nearest image is no farther
  bool far = false;                      // from a place before a side has wrapped it
  for (int k = 0; k < 3; ++k) far = far || !(d[k] < 0.4 * m.rules.size[k] && d[k] > -0.4 * m.rules.size[k]);
  if (far) d = m.rules.scene.domain.box().nearest_of_any(d);
  return !(norm2(d) <= ref[3]);
}

/// The row of a sphere: `centre` not wrapped, `v` the chord of its way. Sees to it that an expired list is known.
inline void write_row(const BodyMotion& m, Row i, Vec3 centre, Vec3 v, Vec3 spin, double inverse_mass) {
  const Rules& rules = m.rules;
  const double radius = m.rows.p[4L * i + 3];
  double *p2 = m.rows.p2.data() + 4L * i, *v2 = m.rows.v2.data() + static_cast<long>(m.rows.stride) * i;
  const Vec3 x = in_domain(rules, centre);
  put3(p2, x);
  put3(v2, m.last ? Vec3{} : v);
  p2[3] = radius;
  if (rules.has.rotation) {
    v2[3] = 0;
    put3(v2 + 4, m.relaxing ? Vec3{} : radius * spin);
  }
  v2[m.rows.stride - 1] = inverse_mass;
  if (expired(m, i, x)) m.c.result.expired = 1;
}

inline void write_body(Bodies& bodies, std::int32_t b, const BodyState& s) {
  double *x = bodies.x2.data() + 4L * b, *v = bodies.v2.data() + 4L * b, *q = bodies.turn2.data() + 4L * b,
         *l = bodies.spin2.data() + 4L * b;
  put3(x, s.x);
  put3(v, s.v);
  put3(l, s.spin);
  x[3] = bodies.x[4L * b + 3];
  v[3] = bodies.v[4L * b + 3];
  l[3] = 0;
  q[0] = s.turn.w, q[1] = s.turn.x, q[2] = s.turn.y, q[3] = s.turn.z;
}

/// A body whose centre has left through an open side is handed to removal by its first row.
inline void note_outside(const BodyMotion& m, Row first, Vec3 x) {
  const Vec3 end = m.rules.size;
  if (x.x >= 0 && x.x < end.x && x.y >= 0 && x.y < end.y && x.z >= 0 && x.z < end.z) return;
  bool out = false;
  for (int k = 0; k < 3; ++k)
    out = out || (!m.rules.scene.domain.periodic(k) && !(x[k] >= 0 && x[k] < m.rules.size[k]));
  if (out) m.c.result.out[static_cast<std::size_t>(m.c.result.out_count++)] = first;
}

/// More stiffness on a body than any step can be stable with [1/s2]. That of superquadrics counts what turns, too: six
/// motions share it instead of three.
inline double stiffest(const BodyMotion& m, const BodyShape& shape) {
  return shape.quadric && !shape.quadric->ball ? 2 * m.rules.bounds.unstable : m.rules.bounds.unstable;
}

}  // namespace talus
