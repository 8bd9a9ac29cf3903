// See body_batch.hpp.
#include "scheduler/nodes/body_batch.hpp"

#include <algorithm>
#include <memory>

#include "scheduler/nodes/body_motion.hpp"

namespace talus {

namespace {

void put(MotionBatch::Lane* to, int lane, const double* from, int count) {
  for (int k = 0; k < count; ++k) to[k][lane] = from[k];
}

Vec3 taken(const MotionBatch::Lane* from, int lane) { return {from[0][lane], from[1][lane], from[2][lane]}; }

/// What does not change while the lane's bodies have one shape.
void put_shape(MotionBatch& to, int lane, const BodyShape& shape) {
  const shapes::Rotor& rotor = shape.rotor;
  put(to.inverse, lane, &rotor.inverse.x, 3);
  to.reference[lane] = rotor.reference;
  to.extra_p[lane] = rotor.extra_p;
  to.extra_q[lane] = rotor.extra_q;
  to.axis_p[lane] = rotor.p;
  to.axis_q[lane] = rotor.q;
  for (std::size_t k = 0; k < shape.spheres.size(); ++k) {
    put(to.sphere[k].place, lane, &shape.spheres[k].x.x, 3);
    to.sphere[k].radius[lane] = shape.spheres[k].r;
  }
}

void put_force(const BodyMotion& m, MotionBatch::Sphere& to, int lane, Row i) {
  const double* f = force_row(m, i);
  put(to.force, lane, f, 3);
  to.stiffness[lane] = f[3];
  if (m.rules.has.rotation) put(to.torque, lane, f + 4, 3);
}

/// Lanes of fewer spheres than the largest bring no force behind their own.
void pad(BodyBatch& batch) {
  MotionBatch& to = batch.lanes;
  for (int lane = 0; lane < to.bodies; ++lane)
    for (int k = batch.spheres[static_cast<std::size_t>(lane)]; k < to.spheres; ++k) {
      const double none[3] = {};
      put(to.sphere[k].place, lane, none, 3);
      put(to.sphere[k].force, lane, none, 3);
      put(to.sphere[k].torque, lane, none, 3);
      to.sphere[k].radius[lane] = to.sphere[k].stiffness[lane] = 0;
      batch.shape[static_cast<std::size_t>(lane)] = -1;  // its places behind the last are another's no more
    }
}

/// Writes the body of a lane and its rows, leaves zeros in its force rows.
void leave(const BodyMotion& m, const BodyBatch& batch, int lane) {
  const MotionBatch& from = batch.lanes;
  const auto k = static_cast<std::size_t>(lane);
  const Row first = batch.row[k], count = batch.spheres[k];
  const Vec3 spin = taken(from.angular_velocity, lane);
  for (Row n = 0; n < count; ++n) {
    const MotionBatch::Sphere& one = from.sphere[n];
    write_row(m, first + n, taken(one.at, lane), taken(one.velocity, lane), spin, from.inverse_mass[lane]);
  }
  std::fill_n(force_row(m, first), static_cast<long>(m.rows.stride) * count, 0.0);
  const Vec3 x = in_domain(m.rules, taken(from.x, lane));
  const shapes::Quaternion turn{from.turn[0][lane], from.turn[1][lane], from.turn[2][lane], from.turn[3][lane]};
  write_body(m.rows.bodies, batch.body[k], {x, taken(from.v, lane), turn, taken(from.spin, lane)});
  note_outside(m, first, x);
}

}  // namespace

BodyBatch* begin_batch(const BodyMotion& m) {
  const Scene& scene = m.rules.scene;
  if (m.relaxing || m.clock.sampled || scene.local_damping != 0 || scene.viscous_damping != 0) return nullptr;
  Scratch& scratch = *m.c.scratch;
  if (!scratch.bodies) scratch.bodies = std::make_shared<BodyBatch>();
  MotionBatch& lanes = scratch.bodies->lanes;
  lanes.bodies = lanes.spheres = 0;
  lanes.rotation = m.rules.has.rotation ? 1 : 0;
  lanes.dt = scene.dt;
  lanes.kick = m.kick;
  lanes.per_step = m.per_step;
  for (int k = 0; k < 3; ++k) lanes.gravity[k] = m.clock.gravity[k];
  return scratch.bodies.get();
}

bool fits_batch(const BodyMotion& m, std::int32_t b, Row i, const BodyShape& shape) {
  return m.rows.is_alive(i) && m.rows.bodies.v[4L * b + 3] > 0 &&
         shape.spheres.size() <= static_cast<std::size_t>(MotionBatch::k_spheres);
}

void enter_batch(const BodyMotion& m, BodyBatch& batch, std::int32_t b, Row i, const BodyShape& shape) {
  const Bodies& bodies = m.rows.bodies;
  MotionBatch& to = batch.lanes;
  const int lane = to.bodies++;
  const auto k = static_cast<std::size_t>(lane);
  const auto count = static_cast<std::int32_t>(shape.spheres.size());
  batch.body[k] = b;
  batch.row[k] = i;
  batch.spheres[k] = count;
  if (const std::int32_t kind = bodies.shape[static_cast<std::size_t>(b)]; batch.shape[k] != kind) {
    put_shape(to, lane, shape);
    batch.shape[k] = kind;
  }
  put(to.x, lane, bodies.x.data() + 4L * b, 3);
  put(to.v, lane, bodies.v.data() + 4L * b, 3);
  put(to.turn, lane, bodies.turn.data() + 4L * b, 4);
  put(to.spin, lane, bodies.spin.data() + 4L * b, 3);
  to.scale[lane] = bodies.scale(b);
  to.mass[lane] = bodies.mass(b);
  to.inverse_mass[lane] = bodies.v[4L * b + 3];
  to.spheres = std::max(to.spheres, count);
  for (std::int32_t n = 0; n < count; ++n) put_force(m, to.sphere[n], lane, i + n);
  if (to.bodies == MotionBatch::k_bodies) move_batch(m, batch);
}

void move_batch(const BodyMotion& m, BodyBatch& batch) {
  MotionBatch& lanes = batch.lanes;
  pad(batch);
  m.rules.mover(lanes);
  for (int lane = 0; lane < lanes.bodies; ++lane) {
    const auto k = static_cast<std::size_t>(lane);
    const std::int32_t b = batch.body[k];
    if (lanes.wide[lane] != 0) {
      move_body(m, b, batch.row[k]);
      continue;
    }
    if (lanes.row[lane] > stiffest(m, shape_of(m.rules, m.rows.bodies, b))) m.c.result.unstable_row = batch.row[k];
    leave(m, batch, lane);
  }
  lanes.bodies = lanes.spheres = 0;
}

}  // namespace talus
