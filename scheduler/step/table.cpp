// The step at a glance: its nodes in order, what each reads and writes, when it is there, and what it runs. The graph
// (graph.cpp), `explain`, profile, trace and the test of I7 derive from this table.
//
//   displacement_check --(valid)--------------------------------> start -> narrow_phase[c] --(no chunk left)--> join
//          |                                                        ^        -> the other chunk nodes[c]       |
//          +--(expired, forced)--> insert -> sort_epoch -> rebuild -+        -> narrow_phase[the next c]       |
//          +---------------------------------------------------------------------------------------------------+
//
// Unordered are only chunk nodes of different chunks: what one of them writes, none of them may touch beyond the rows
// of its own chunk (I7). What threads prefetch of their next chunk are addresses, not values (next_chunk.hpp).
#include <fmt/format.h>

#include "scheduler/lists/rebuild.hpp"
#include "scheduler/nodes/check.hpp"
#include "scheduler/nodes/events.hpp"
#include "scheduler/nodes/force.hpp"
#include "scheduler/nodes/integrate.hpp"
#include "scheduler/nodes/leavers.hpp"
#include "scheduler/nodes/narrow.hpp"
#include "scheduler/nodes/plane_count.hpp"
#include "scheduler/nodes/resize.hpp"
#include "scheduler/nodes/size_push.hpp"
#include "scheduler/nodes/wall_contact.hpp"
#include "scheduler/step/step.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/view/observe.hpp"

namespace talus {

namespace {

using Names = std::vector<Access>;

// --- what the nodes run: the argument lists say what each may read and write --------------------------------------

void run_insert(World& w, Chunk&) {
  if (event_due(w.rules, w.clock)) {
    // events end contacts and begin some, with all the energy that is in them
    const bool counts = w.rules.has.energies && w.clock.step > 0;
    const double before = counts ? elastic_in(energy_rows(w, w.clock.step), w.rows) : 0;
    apply_events(w.rules, w.clock, w.rows, w.lists, w.ledger, w.counters, w.parts, w.monitor);
    if (counts) w.ledger.inserted += elastic_in(energy_rows(w, w.clock.step), w.rows) - before;
  }
  if (!w.rules.has.insertion || w.insertion->next_step(w.clock.step) != w.clock.step) return;
  const bool came =
      insert_batch(w.rules, w.clock, w.walls, *w.insertion, w.rows, w.contacts, w.ledger, w.counters, w.parts);
  warn_of_shortfalls(w.rules, w.clock, *w.insertion, w.monitor);
  if (came) limit_lanes(w.rules, w.contacts, w.team);
}

void run_sort(World& w, Chunk&) {
  check_finite(w.rows, w.contacts, w.walls, w.team);
  w.lists.tuner.interval_ends(w.rules, w.clock, w.rows, w.contacts, w.lists, w.team);
  note_displacements(w.rules, w.clock, w.rows, w.contacts, w.lists, w.team);
  sort_epoch(w.rules, w.rows, w.contacts, w.lists, w.counters, w.team);
}

bool sort_due(const World& w) { return w.clock.step % w.rules.scene.sort_every == 0; }

void run_rebuild(World& w, Chunk&) {
  const bool forced = sort_due(w) || !lists_expired(w.rules, w.clock, w.contacts, w.lists, w.walls);
  const bool cut = rebuild_tuned(w.rules, w.clock, w.rows, w.contacts, w.lists, w.counters, w.walls, w.team, !forced);
  w.lists.series.add(list_record(w.rules, w.clock, w.contacts, w.lists, w.counters));
  w.lists.valid = true;
  if (!cut) count_rebuild(w.clock, w.lists, w.counters, forced);
  w.lists.last_rebuild_step = w.clock.step;
}

void run_narrow(World& w, Chunk& c) {
  c.scratch = w.team.scratch.take(thread_slot(w.team));
  narrow_chunk(w.rules, w.clock, w.rows, c);
}

/// What this thread will most likely work on next; nothing where all rows stay near anyway.
NextChunk next_of(const World& w) {
  if (rows_stay_near(w.rows)) return {};
  const int k = w.team.shares.next(thread_slot(w.team));
  return k < 0 ? NextChunk() : NextChunk(w.rows, w.contacts[k]);
}

void run_force(World& w, Chunk& c) {
  force_chunk(w.rules, w.clock, w.rows, w.ledger.rows, c, next_of(w));
  if (!w.ledger.pairs.empty()) keep_pairs(w.ledger, c);
  if (!w.ledger.push.empty()) push_pairs(w.rules, w.rows, w.ledger, c);
}

void run_walls(World& w, Chunk& c) {
  wall_chunk(w.rules, w.clock, w.rows, w.lists, w.walls, w.ledger.rows, c);
  if (!w.ledger.push.empty()) push_walls(w.rules, w.rows, w.walls, w.ledger, c);
}

void run_integrate(World& w, Chunk& c) {
  if (w.rows.bodies.in && !w.ledger.push.empty()) push_bodies(w.rules, w.rows, w.ledger, c);
  integrate_chunk(w.rules, w.clock, w.rows, w.lists, w.ledger.rows, c);
  const ChunkResults& r = c.result;
  if (r.expired != 0) w.lists.any_expired.store(true, std::memory_order_relaxed);
  if (w.clock.sampled || r.out_count != 0 || r.unstable_row >= 0 || r.deep_slot >= 0 || r.deep_wall >= 0)
    w.contacts.news.store(true, std::memory_order_relaxed);
  w.team.scratch.give(c.scratch, thread_slot(w.team));
  c.scratch = nullptr;
}

void run_resize(World& w, Chunk& c) {
  resize_chunk(view_of(w), w.parts, w.rows, w.lists, c);
  if (c.result.expired != 0) w.lists.any_expired.store(true, std::memory_order_relaxed);
  if (c.result.out_count != 0) w.contacts.news.store(true, std::memory_order_relaxed);
}

void run_planes(World& w, Chunk& c) { plane_chunk(w.rows, w.planes, c); }

void run_energy(World& w, Chunk&) { add_step_work(w.rules, w.clock, w.rows, w.contacts, w.ledger, w.team); }

// --- the table -----------------------------------------------------------------------------------------------------

void add(std::vector<NodeSpec>& t, Node id, const char* name, Phase phase, Names reads, Names writes, bool in,
         std::string why, void (*run)(World&, Chunk&)) {
  t.push_back({id, name, phase, std::move(reads), std::move(writes), in, std::move(why), run});
}

void add_serial(const World& w, std::vector<NodeSpec>& t) {
  const Features& h = w.rules.has;
  const bool acts = h.insertion || h.events;
  add(t, Node::displacement_check, "displacement_check", Phase::decide, {{"results"}, {"x0"}, {"walls"}},
      {{"p"}, {"v"}, {"x0"}, {"counters"}, {"warnings"}}, true, "always",
      [](World& world, Chunk&) { check_step(world); });
  add(t, Node::insert, "insert", Phase::insert, {{"scene"}, {"walls"}, {"p"}, {"contacts"}, {"history"}},
      {{"p"}, {"v"}, {"x0"}, {"id"}, {"fixed"}, {"gravity"}, {"counters"}, {"chunks"}, {"warnings"}}, acts,
      acts ? "sources or events act during the run" : "no source or event acts during the run", run_insert);
  add(t, Node::sort_epoch, "sort_epoch", Phase::lists, {{"p"}, {"contacts"}, {"history"}},
      {{"order of all rows"}, {"history"}, {"wall history"}, {"x0"}, {"p2"}, {"v2"}, {"chunks"}}, true,
      "every " + std::to_string(w.rules.scene.sort_every) + " steps", run_sort);
  add(t, Node::rebuild, "rebuild", Phase::lists, {{"p"}, {"v"}, {"v2"}, {"mask"}},
      {{"x0"}, {"cells"}, {"list"}, {"mask"}, {"history"}, {"wall candidates"}}, true,
      "when a displacement exceeds its skin", run_rebuild);
}

void add_chunk(const World& w, std::vector<NodeSpec>& t) {
  const Features& h = w.rules.has;
  add(t, Node::narrow_phase, "narrow_phase", Phase::chunk, {{"p", true}, {"list"}, {"mask"}},
      {{"mask"}, {"contacts"}, {"history"}}, true, "always", run_narrow);
  add(t, Node::contact_force, "contact_force", Phase::chunk, {{"p", true}, {"v", true}, {"contacts"}},
      {{"history"}, {"force rows"}, {"energy rows"}, {"results"}}, true, "always", run_force);
  add(t, Node::wall_contact, "wall_contact", Phase::chunk, {{"p"}, {"v"}, {"x0"}, {"walls", true}, {"wall candidates"}},
      {{"wall history"}, {"force rows"}, {"energy rows"}, {"results"}}, h.walls,
      h.walls ? std::to_string(w.walls.size()) + " walls" : "no walls", run_walls);
}

void add_motion(const World& w, std::vector<NodeSpec>& t) {
  const Features& h = w.rules.has;
  // p beyond the own rows: the monitor looks at overlaps; the histories: dropped while an overlapping start relaxes
  add(t, Node::integrate, "integrate", Phase::chunk, {{"p", true}, {"v"}, {"force rows"}, {"x0"}, {"contacts"}},
      {{"p2"}, {"v2"}, {"results"}, {"force rows"}, {"energy rows"}, {"history"}, {"wall history"}}, true, "always",
      run_integrate);
  add(t, Node::resize, "resize", Phase::chunk, {{"p2"}, {"v2"}}, {{"p2"}, {"v2"}, {"x0"}, {"results"}}, w.rows.resized,
      w.rows.resized ? "a part changes sizes of grains" : "no part changes sizes of grains", run_resize);
  add(t, Node::plane_count, "plane_count", Phase::chunk, {{"p"}, {"p2"}}, {{"crossings"}}, h.planes,
      h.planes ? std::to_string(w.planes.totals().size()) + " flux planes" : "no flux planes", run_planes);
}

void add_finish(const World& w, std::vector<NodeSpec>& t) {
  const bool energies = w.rules.has.energies;
  add(t, Node::energy, "energy", Phase::finish, {{"energy rows"}, {"v"}, {"v2"}}, {{"energy totals"}}, energies,
      energies ? "output.energies" : "output.energies is off", run_energy);
}

/// Nodes of the parts that run at `when`.
void add_parts(const World& w, PartNode::When when, std::vector<NodeSpec>& t) {
  int id = static_cast<int>(Node::count);
  for (const auto& part : w.parts.all)
    for (PartNode& n : part->nodes()) {
      const Node number{id++};
      if (n.when != when) continue;
      const Phase phase = when == PartNode::When::step ? Phase::finish : Phase::chunk;
      const auto run = [fn = std::move(n.run)](World& world, Chunk& c) { fn(view_of(world), c); };
      t.push_back({number, n.name, phase, n.reads, n.writes, true, part->name(), run, n.every});
    }
}

std::string text_of(const NodeSpec& n) { return n.name + (n.phase == Phase::chunk ? "[c]" : ""); }

}  // namespace

std::vector<NodeSpec> step_table(const World& w) {
  std::vector<NodeSpec> t;
  add_serial(w, t);
  add_chunk(w, t);
  add_parts(w, PartNode::When::contacts, t);
  add_motion(w, t);
  add_parts(w, PartNode::When::rows, t);
  add_finish(w, t);
  add_parts(w, PartNode::When::step, t);
  return t;
}

std::string graph_picture(const World& w) {
  std::string chunk, lists;
  for (const NodeSpec& n : step_table(w)) {
    if (!n.in) continue;
    if (n.phase == Phase::chunk) chunk += text_of(n) + " -> ";
    if (n.phase == Phase::insert) lists += text_of(n) + " -> ";
  }
  return fmt::format(
      "displacement_check --valid--> {}join -> displacement_check\n"
      "displacement_check --expired--> {}rebuild (sort_epoch every {} steps) -> narrow_phase[c]\n",
      chunk, lists, w.rules.scene.sort_every);
}

}  // namespace talus
