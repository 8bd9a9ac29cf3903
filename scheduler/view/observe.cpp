// See observe.hpp.
#include "scheduler/view/observe.hpp"

#include "scheduler/step/world.hpp"

namespace talus {

namespace {

std::size_t bytes_of(const Chunk& c) {
  const auto size = [](const auto& column) { return column.capacity() * sizeof(column[0]); };
  const WallContacts& t = c.wall;
  std::size_t b = size(c.outer.pi) + size(c.outer.pj) + size(c.list.pi) + size(c.list.pj) + size(c.list.mask) +
                  size(c.contacts.distributed) + size(c.result.out) + size(t.row) + size(t.begin) + size(t.element) +
                  size(t.distance) + size(t.nearest) + size(t.radius) + size(t.state) + size(t.next) + size(t.force) +
                  size(t.point) + size(t.moment) + size(t.moment_next) + size(t.torque);
  for (const auto& h : c.contacts.h) b += size(h);
  return b;
}

std::size_t bytes_of(const CellGrid& g) {
  const auto size = [](const auto& column) { return column.capacity() * sizeof(column[0]); };
  return size(g.cell_of_row) + size(g.place_in_cell) + size(g.sx) + size(g.sy) + size(g.sz) + size(g.sr) +
         size(g.reach) + size(g.sorted_row) + size(g.cell_start);
}

}  // namespace

Energies energies_of(const World& w) {
  const bool start = w.rules.has.energies && w.clock.step == 0;
  const Column<double> springs = start ? energy_rows(w) : Column<double>{};
  Energies e = energies_of(w.rules, w.clock, w.rows, w.ledger, w.counters.steps,
                           start ? springs.data() : w.ledger.rows.data());
  if (!w.rules.has.energies || (!start && (w.counters.steps == 0 || !w.rows.velocity_at_old_step))) return e;
  for (const auto& p : w.parts.all) {
    e.wall_work += p->work();
    if (w.ledger.start_known) e.residual -= p->work();
  }
  return e;
}

std::size_t bytes_of(const World& w) {
  std::size_t b = w.rows.columns.bytes() + w.rows.bodies.columns.bytes() +
                  w.ledger.blocks.capacity() * sizeof(StepWork) + bytes_of(w.lists.grid) + w.team.list_scratch.bytes() +
                  w.team.scratch.bytes();
  if (w.rules.has.walls) b += w.walls.bytes();
  for (const auto& c : w.contacts.chunks) b += bytes_of(*c);
  return b;
}

}  // namespace talus
