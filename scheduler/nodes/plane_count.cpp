// Passages through flux planes, counted in every step. Who calls it: the node behind integrate, and finish_step; scenes
// without planes have neither. Invariants: I3 (masses are added in storage order, whatever the chunks), I7 (a chunk
// writes only its own crossings); nothing here influences the trajectory. Cost
// of a plane: 17 instructions per grain and step, 49 where it is oblique and cuts a periodic axis (a step of a loose
// bed with friction takes 380).
#include "scheduler/nodes/plane_count.hpp"

namespace talus {

void plane_chunk(const Rows& rows, const PlaneCounts& counts, Chunk& c) {
  c.crossings.clear();
  const std::vector<CountedPlane>& planes = counts.planes();
  for (std::size_t q = 0; q < planes.size(); ++q) {
    const auto found = [&c, q](Row row, int net) { c.crossings.push_back({row, static_cast<std::int32_t>(q), net}); };
    if (!rows.bodies.in) {
      planes[q].find(rows.p.data(), rows.p2.data(), c.lo, c.hi, found);
      continue;
    }
    // spheres by themselves, bodies by their centre of mass
    for (Row i = c.lo; i < c.hi; ++i) {
      const std::int32_t b = rows.body_of(i);
      if (b < 0)
        planes[q].find(rows.p.data(), rows.p2.data(), i, i + 1, found);
      else if (rows.leads(i) && rows.is_alive(i))
        planes[q].find(rows.bodies.x.data(), rows.bodies.x2.data(), b, b + 1, [&](Row, int net) { found(i, net); });
    }
  }
}

void add_crossings(const Rules& rules, const Rows& rows, const Contacts& contacts, PlaneCounts& planes) {
  planes.begin_step();
  for (const auto& c : contacts.chunks)
    for (const Crossing& x : c->crossings) planes.add(x.plane, x.net, mass_of(rules, rows, x.row));
}

}  // namespace talus
