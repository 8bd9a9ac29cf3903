// Passages through flux planes, counted in every step. Who calls it: the node behind integrate, and finish_step; scenes
// without planes have neither. Invariants: I3 (masses are added in storage order, whatever the chunks), I7 (a chunk
// writes only its own crossings); nothing here influences the trajectory. Cost
// of a plane: 17 instructions per grain and step, 49 where it is oblique and cuts a periodic axis (a step of a loose
// bed with friction takes 380).
#include "scheduler/step/world.hpp"

namespace talus {

void plane_chunk(World& w, Chunk& c) {
  NodeTimer timer(w, c, Node::plane_count);
  c.crossings.clear();
  const std::vector<CountedPlane>& planes = w.planes.planes();
  for (std::size_t q = 0; q < planes.size(); ++q)
    planes[q].find(w.p.data(), w.p2.data(), c.lo, c.hi, [&c, q](Row row, int net) {
      c.crossings.push_back({row, static_cast<std::int32_t>(q), net});
    });
}

void add_crossings(World& w) {
  w.planes.begin_step();
  for (const auto& c : w.chunks)
    for (const Crossing& x : c->crossings) w.planes.add(x.plane, x.net, w.mass(x.row));
}

}  // namespace talus
