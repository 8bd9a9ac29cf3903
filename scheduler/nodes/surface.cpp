// See surface.hpp.
#include "scheduler/nodes/surface.hpp"

namespace talus {

const BodyShape* superquadric_of(const Rules& rules, const Rows& rows, Row i) {
  const std::int32_t b = rows.body_of(i);
  if (b < 0) return nullptr;
  const BodyShape& shape = shape_of(rules, rows.bodies, b);
  return shape.quadric && !shape.quadric->ball ? &shape : nullptr;
}

Surface surface_of(const Rules& rules, const Rows& rows, Row i) {
  Surface s;
  set_surface(rules, rows, i, s);
  return s;
}

void set_surface(const Rules& rules, const Rows& rows, Row i, Surface& s) {
  const double *p = rows.p.data() + 4L * i, *v = rows.v.data() + static_cast<long>(rows.stride) * i;
  const double r = p[3], per_radius = 1 / r;
  s.v = {v[0], v[1], v[2]};
  s.w = {per_radius * v[4], per_radius * v[5], per_radius * v[6]};
  s.inverse_mass = v[7];
  s.shape = superquadric_of(rules, rows, i);
  if (s.shape == nullptr) {
    s.form = {{r * r, r * r, r * r}, 2, 2};
    s.turn = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    s.size = s.roundness = s.inner = s.middle = r;
    s.quadric = nullptr;
    s.scale = 1;
    s.inverse_inertia = {};
    return;
  }
  const std::int32_t b = rows.body_of(i);
  const double scale = rows.bodies.scale(b), s2 = scale * scale;
  const double* q = rows.bodies.turn.data() + 4L * b;
  s.quadric = &*s.shape->quadric;
  const auto& form = s.quadric->form;
  s.form = {{s2 * form.axes2.x, s2 * form.axes2.y, s2 * form.axes2.z}, form.p1, form.p2};
  s.turn = shapes::rotation({q[0], q[1], q[2], q[3]});
  s.scale = scale;
  s.size = scale * s.quadric->size;
  s.roundness = scale * s.quadric->roundness;
  s.inner = scale * s.shape->smallest;
  s.middle = scale * s.shape->equal_radius;
  s.inverse_inertia = {};
  if (s.inverse_mass > 0) s.inverse_inertia = (1 / inertia_scale(rows.bodies, b)) * s.shape->rotor.inverse;
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
