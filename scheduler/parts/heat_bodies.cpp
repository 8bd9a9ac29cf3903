// See heat_bodies.hpp.
#include "scheduler/parts/heat_bodies.hpp"

#include "core/shapes/surface_area.hpp"
#include "scheduler/nodes/surface.hpp"
#include "scheduler/parts/heat.hpp"
#include "scheduler/team/pools.hpp"

namespace talus {

std::vector<double> areas_of_shapes(const Scene& scene) {
  std::vector<double> areas;
  for (const ShapeSpec& s : scene.shapes) {
    const BodyShape& body = *s.body;
    areas.push_back(body.quadric ? shapes::surface_area(body.quadric->surface) : shapes::surface_area(body.spheres));
  }
  return areas;
}

const BodyShape* shaped_body(const PartView& w, Row i) {
  return w.rules.has.superquadrics ? superquadric_of(w.rules, w.rows, i) : nullptr;
}

Row end_of_grain(const PartView& w, Row i) {
  const std::int32_t b = w.rows.body_of(i);
  return b < 0 ? i + 1 : i + static_cast<Row>(shape_of(w.rules, w.rows.bodies, b).spheres.size());
}

bool same_body(const PartView& w, Row i, Row j) {
  const std::int32_t b = w.rows.body_of(i);
  return b >= 0 && b == w.rows.body_of(j);
}

double heat_size(const PartView& w, Row i) {
  const std::int32_t b = w.rows.body_of(i);
  if (b < 0) return w.rows.p[4L * i + 3];
  return w.rows.bodies.scale(b) * shape_of(w.rules, w.rows.bodies, b).equal_radius;
}

double contact_radius(const PartView& w, Row i, Vec3 n) {
  if (shaped_body(w, i) == nullptr) return w.rows.p[4L * i + 3];
  return hertz_radius_of(surface_of(w.rules, w.rows, i), n);
}

std::optional<ShapedMeeting> shaped_contact(const PartView& w, const Chunk& c, std::int64_t q) {
  if (!w.rules.has.superquadrics) return {};
  const auto at = static_cast<std::size_t>(q);
  const double share = c.scratch->depth[at];
  if (share < 0) return {};
  const Row i = c.scratch->ci[at], j = c.scratch->cj[at];
  const Column<double>* n = c.contacts.h + w.rules.has.law_columns;
  const double inner = fmin2(surface_of(w.rules, w.rows, i).inner, surface_of(w.rules, w.rows, j).inner);
  return ShapedMeeting{share * inner, {n[0][at], n[1][at], n[2][at]}};
}

std::optional<ShapedMeeting> shaped_contact(const PartView& w, Row i, Row j) {
  if (shaped_body(w, i) == nullptr && shaped_body(w, j) == nullptr) return {};
  const bool swapped = i > j;
  const Row a = swapped ? j : i, o = swapped ? i : j;
  const double *x = w.rows.p.data() + 4L * a, *y = w.rows.p.data() + 4L * o;
  const Vec3 way = w.rules.scene.domain.box().nearest({y[0] - x[0], y[1] - x[1], y[2] - x[2]});
  shapes::PairMemory memory;
  shapes::PairCount count;
  const shapes::PairContact c = shapes::solve_pair(surface_of(w.rules, w.rows, a).body({}),
                                                   surface_of(w.rules, w.rows, o).body(way), memory, count);
  return ShapedMeeting{c.overlap, swapped ? -c.normal : c.normal};
}

void share_with_body(HeatState& s, const PartView& w, Row i) {
  const auto at = static_cast<std::size_t>(i);
  for (Row k = i + 1; k < end_of_grain(w, i); ++k) {
    const auto to = static_cast<std::size_t>(k);
    s.next_enthalpy[to] = s.enthalpy[to];
    s.next_temperature[to] = s.next_temperature[at];
    if (s.molten.any) s.molten.next[to] = s.molten.next[at];
    if (s.scene.friction) s.loss[to] = 0;
  }
}

}  // namespace talus
