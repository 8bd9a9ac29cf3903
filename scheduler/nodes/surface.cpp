// See surface.hpp.
#include "scheduler/nodes/surface.hpp"

namespace talus {

const BodyShape* superquadric_of(const Rules& rules, const Rows& rows, Row i) {
  const std::int32_t b = rows.body_of(i);
  if (b < 0) return nullptr;
  const BodyShape& shape = shape_of(rules, rows.bodies, b);
  return shape.quadric && !shape.quadric->ball ? &shape : nullptr;
}

Pose pose_of(const Rules& rules, const Rows& rows, Row i) {
  Pose pose;
  const BodyShape* shape = pose.shape = superquadric_of(rules, rows, i);
  if (shape == nullptr) {
    const double r = rows.p[4L * i + 3];
    pose.form = {{r * r, r * r, r * r}, 2, 2};
    return pose;
  }
  const std::int32_t b = rows.body_of(i);
  const double scale = rows.bodies.scale(b), s2 = scale * scale;
  pose.form = shape->quadric->form;
  pose.form.axes2 = {s2 * pose.form.axes2.x, s2 * pose.form.axes2.y, s2 * pose.form.axes2.z};
  pose.turn = shapes::rotation(state_of(rows.bodies, b).turn);
  return pose;
}

Surface surface_of(const Rules& rules, const Rows& rows, Row i, const Pose& pose) {
  const double *p = rows.p.data() + 4L * i, *v = rows.v.data() + static_cast<long>(rows.stride) * i;
  Surface s;
  s.v = {v[0], v[1], v[2]};
  s.w = (1 / p[3]) * Vec3{v[4], v[5], v[6]};
  s.inverse_mass = v[7];
  s.form = pose.form;
  s.turn = pose.turn;
  const BodyShape* shape = pose.shape;
  if (shape == nullptr) {
    s.size = s.roundness = s.inner = s.middle = p[3];
    return s;
  }
  const std::int32_t b = rows.body_of(i);
  s.quadric = &*shape->quadric;
  s.scale = rows.bodies.scale(b);
  s.size = s.scale * s.quadric->size;
  s.roundness = s.scale * s.quadric->roundness;
  s.inner = s.scale * shape->smallest;
  s.middle = s.scale * shape->equal_radius;
  if (s.inverse_mass > 0) s.inverse_inertia = (1 / inertia_scale(rows.bodies, b)) * shape->rotor.inverse;
  return s;
}

double answer_of(const Surface& s, Vec3 arm, Vec3 n) {
  if (s.quadric == nullptr) return s.inverse_mass;
  const Vec3 u = shapes::to_body(s.turn, cross(arm, n)), i = s.inverse_inertia;
  return s.inverse_mass + ((u.x * u.x * i.x + u.y * u.y * i.y) + u.z * u.z * i.z);
}

double weight_of(const Surface& s, double answer) { return s.inverse_mass > 0 ? answer / s.inverse_mass : 1; }

double hertz_radius_of(const Surface& s, Vec3 n) {
  if (s.quadric == nullptr) return s.size;
  const shapes::Radii r = shapes::radii_of_curvature(s.quadric->surface, shapes::to_body(s.turn, n));
  return s.scale * shapes::hertz_radius(r, s.quadric->flat);
}

}  // namespace talus
