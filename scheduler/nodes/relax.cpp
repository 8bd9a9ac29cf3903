// Limited-velocity relaxation of overlapping starts: what integrates the first scene.relax.steps steps instead of the
// kernel. Invariants: a function of the rows of the chunk and their forces alone (I3, I8); only + - * / sqrt, min and
// select (I4); scenes without [relax] never come here.
// Each particle slides down its own force: v keeps its part along the force (so that it gathers speed while it is
// pushed on) and nothing else, gains F dt / m, and is cut to `displacement` radii per step. No gravity, no spin, no
// history.
#include <algorithm>

#include "scheduler/nodes/integrate.hpp"

namespace talus {

void relax_chunk(const Rules& rules, const Clock& clock, Rows& rows, const Lists& lists, Chunk& c) {
  const Scratch& s = *c.scratch;
  const double dt = rules.scene.dt;
  const bool first = clock.step == 0, last = clock.step + 1 == rules.scene.relax.steps;
  c.result.out_count = 0;
  c.result.expired = 0;
  c.result.unstable_row = -1;
  const Box box = rules.scene.domain.box();
  for (Row i = c.lo; i < c.hi; ++i) {
    const double *p = rows.p.data() + 4L * i, *v = rows.v.data() + static_cast<long>(rules.stride) * i;
    double *p2 = rows.p2.data() + 4L * i, *v2 = rows.v2.data() + static_cast<long>(rules.stride) * i;
    std::copy(v, v + rules.stride, v2);
    std::copy(p, p + 4, p2);
    const double invm = v[rules.stride - 1];
    if (!rows.is_alive(i) || rows.body_of(i) >= 0) continue;  // bodies: body_motion.cpp
    if (invm > 0) {
      const double* force = s.f.data() + static_cast<long>(rules.stride) * (i - c.lo);
      const Vec3 f{force[0], force[1], force[2]};
      const double f2 = norm2(f);
      const double along = first ? 0.0 : dot(Vec3{v[0], v[1], v[2]}, f);
      Vec3 u = along > 0 ? (along / f2) * f : Vec3{};
      u = u + (dt * invm) * f;
      const double cap = rules.scene.relax.displacement * p[3] / dt, speed = norm(u);
      if (speed > cap) u = (cap / speed) * u;
      for (int k = 0; k < 3; ++k) p2[k] = p[k] + dt * u[k];
      for (int k = 0; k < 3; ++k) v2[k] = last ? 0.0 : u[k];
      if (rules.has.rotation)
        for (int k = 4; k < 7; ++k) v2[k] = 0;
    } else {  // fixed and driven particles go their way
      for (int k = 0; k < 3; ++k) p2[k] = p[k] + dt * v[k];
    }
    bool out = false;
    const double* ref = lists.x0.data() + 4L * i;
    double moved = 0;
    for (int k = 0; k < 3; ++k) {
      const double side = rules.size[k];
      double d = 0;
      if (rules.scene.domain.periodic(k)) {
        if (p2[k] < 0) p2[k] = p2[k] + side;
        if (!(p2[k] < side)) p2[k] = p2[k] - side;
        d = box.nearest(k, p2[k] - ref[k]);
      } else {
        out = out || !(p2[k] >= 0 && p2[k] < side);
        d = p2[k] - ref[k];
      }
      moved += d * d;
    }
    if (out) c.result.out[static_cast<std::size_t>(c.result.out_count++)] = i;
    if (!(moved <= ref[3])) c.result.expired = 1;
  }
  // No memory of how the particles were pushed apart: the springs start unloaded.
  for (int q = 0; q < rules.has.history_columns; ++q)
    std::fill_n(c.contacts.h[q].begin(), static_cast<std::ptrdiff_t>(c.contacts.end[2]), 0.0);
  for (WallState& t : c.wall.state) std::fill(std::begin(t.h), std::end(t.h), 0.0);
  std::fill(c.wall.moment.begin(), c.wall.moment.end(), 0.0);
}

}  // namespace talus
