// Conduction through the contacts of a chunk, and what a contact of two materials conducts. Invariants: I3 (terms of a
// grain in list order), antisymmetric to the bit.
#include <algorithm>

#include "core/heat/contact.hpp"
#include "scheduler/parts/heat.hpp"
#include "scheduler/team/pools.hpp"

namespace talus {

namespace {

/// [W/K]; of radii ri and rj at the contact
inline double conductance_of(const HeatState& s, const PartView& w, const GrainInside* inside, Row i, Row j,
                             double overlap, double ri, double rj) {
  const double radius = s.pair(s.material(w, i), s.material(w, j)).of(heat::reduced(ri, rj), overlap);
  return heat::contact_conductance(s.conductivity(w, inside, i), s.conductivity(w, inside, j), radius);
}

double conductance_of(const HeatState& s, const PartView& w, const GrainInside* inside, Row i, Row j,
                      const ShapedMeeting& m) {
  if (!(m.overlap > 0)) return 0;
  return conductance_of(s, w, inside, i, j, m.overlap, contact_radius(w, i, m.normal), contact_radius(w, j, m.normal));
}

}  // namespace

double conductance_between(const HeatState& s, const PartView& w, Row i, Row j, double overlap) {
  if (same_body(w, i, j)) return 0;
  const auto* inside = part_as<GrainInside>(w.parts);
  if (const auto shaped = shaped_contact(w, i, j)) return conductance_of(s, w, inside, i, j, *shaped);
  return overlap > 0 ? conductance_of(s, w, inside, i, j, overlap, w.rows.p[4L * i + 3], w.rows.p[4L * j + 3]) : 0.0;
}

double heat_of_pair(const HeatState& s, const PartView& w, Row i, Row j, double overlap) {
  const auto* inside = part_as<GrainInside>(w.parts);
  const double g = shaped_body(w, i) != nullptr || shaped_body(w, j) != nullptr
                       ? conductance_between(s, w, i, j, overlap)
                       : conductance_of(s, w, inside, i, j, overlap, w.rows.p[4L * i + 3], w.rows.p[4L * j + 3]);
  return g * (s.temperature[static_cast<std::size_t>(j)] - s.temperature[static_cast<std::size_t>(i)]);
}

void heat_contacts(HeatState& s, const PartView& w, const Chunk& c) {
  if (!s.ends(w)) return;
  const Scratch& t = *c.scratch;
  const double *T = s.temperature.data(), *p = w.rows.p.data();
  double *flow = s.flow.data(), *conductance = s.conductance.data();
  std::fill(flow + c.lo, flow + c.hi, 0.0);
  std::fill(conductance + c.lo, conductance + c.hi, 0.0);
  const Box box = w.rules.scene.domain.box();
  const auto* inside = part_as<GrainInside>(w.parts);
  const bool superquadrics = w.rules.has.superquadrics;
  for (std::int64_t q = 0; q < c.contacts.end[2]; ++q) {
    const Row i = t.ci[static_cast<std::size_t>(q)], j = t.cj[static_cast<std::size_t>(q)];
    const double *a = p + 4L * i, *b = p + 4L * j;
    const double d = norm(box.nearest({a[0] - b[0], a[1] - b[1], a[2] - b[2]}));
    const auto shaped = superquadrics ? shaped_contact(w, c, q) : std::nullopt;
    const double g = shaped ? conductance_of(s, w, inside, i, j, *shaped)
                            : conductance_of(s, w, inside, i, j, (a[3] + b[3]) - d, a[3], b[3]);
    const double f = g * (T[j] - T[i]);
    flow[i] = flow[i] + f;
    conductance[i] = conductance[i] + g;
    if (q < c.contacts.end[0] || q >= c.contacts.end[1]) continue;
    flow[j] = flow[j] - f;
    conductance[j] = conductance[j] + g;
  }
}

}  // namespace talus
