// The serial parts of a step that see the whole: its decision, its end, its failure.
#include "scheduler/step/step.hpp"

#include <algorithm>
#include <chrono>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/walls/wall_motion.hpp"
#include "scheduler/lists/skin_check.hpp"
#include "scheduler/nodes/check.hpp"
#include "scheduler/nodes/events.hpp"
#include "scheduler/nodes/leavers.hpp"
#include "scheduler/nodes/plane_count.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/team/parallel.hpp"
#include "scheduler/view/observe.hpp"

namespace talus {

namespace {

/// Energies of the last step, where the monitor wants to judge their balance.
bool balance_due(const World& w) {
  return w.rules.has.energies && w.ledger.start_known && (w.clock.step - 1) % k_energy_every == 0 &&
         !w.contacts.chunks.empty() && w.contacts.chunks.front()->result.extremes.filled;
}

void check_results(World& w) {
  if (!w.contacts.news.load(std::memory_order_relaxed)) return;
  report_failures(w.rules, w.clock, w.rows, w.contacts, w.walls);
  if (balance_due(w)) {
    const Energies e = energies_of(w);
    judge_step(w.rules, w.clock, w.contacts, w.walls, w.monitor, &e);
  } else {
    judge_step(w.rules, w.clock, w.contacts, w.walls, w.monitor, nullptr);
  }
  // Grains that have left take the springs of their contacts along. Where two of them touch, the contacts of the
  // present positions tell which springs would count twice.
  LeavingSprings s;
  if (!w.ledger.pairs.empty()) s = springs_of_leavers(w.rules, w.rows, w.contacts, w.ledger);
  const auto present = [&] { return elastic_in(energy_rows(w, w.clock.step), w.rows); };
  double gone = s.meet ? present() : s.all;
  remove_leavers(w.rules, w.clock, w.rows, w.contacts, w.lists, w.ledger, w.counters, w.parts);
  if (s.meet) gone -= present();
  w.ledger.inserted -= gone;
  w.ledger.left = s.left - (s.all - gone);
  w.contacts.news.store(false, std::memory_order_relaxed);
}

/// Adds what the chunks have solved in the step; both owners of a pair across chunks have.
void count_solved(World& w) {
  std::int64_t twice[2] = {0, 0};
  for (const auto& c : w.contacts.chunks)
    for (int k = 0; k < 2; ++k) twice[k] += c->contacts.solved[k];
  Counters& n = w.counters;
  n.step_solved_pairs = twice[0] / 2;
  n.step_safe_pairs = twice[1] / 2;
  n.solved_pairs += n.step_solved_pairs;
  n.safe_pairs += n.step_safe_pairs;
}

/// A wall appears or vanishes at this step: contacts begin or end with all their energy.
bool walls_change(const Scene& scene, std::int64_t step) {
  return step > 0 && std::any_of(scene.walls.begin(), scene.walls.end(), [&](const WallSpec& wall) {
           return acts_at(wall, step, scene.dt) != acts_at(wall, step - 1, scene.dt);
         });
}

}  // namespace

void run_node(World& w, const NodeSpec& node, Chunk& c) {
  if (node.every > 1 && (w.clock.step + 1) % node.every != 0) return;
  const int index = node.phase == Phase::chunk ? c.index : -1;
  w.team.failure.guard(index, [&] {
    const NodeTimer timer(w.team.times, index, node.id);
    node.run(w, c);
  });
}

void check_step(World& w) {
  check_results(w);
  Clock& clock = w.clock;
  const Scene& scene = w.rules.scene;
  clock.stop = clock.step >= clock.target;
  clock.rebuild = false;
  if (clock.stop) return;
  if (w.rules.has.walls) w.walls.set_step(clock.step, scene.dt);
  if (w.rules.has.energies && walls_change(scene, clock.step))
    w.ledger.inserted +=
        elastic_in(energy_rows(w, clock.step), w.rows) - elastic_in(energy_rows(w, clock.step - 1), w.rows);
  if (w.rules.has.moving_walls) judge_walls(w.rules, w.rows, w.walls);
  const bool insertion = w.rules.has.insertion && w.insertion->next_step(clock.step) == clock.step;
  const bool epoch = clock.step % scene.sort_every == 0;
  clock.structure = insertion || event_due(w.rules, clock) || epoch;
  clock.sampled = clock.step >= scene.relax.steps &&
                  (clock.structure || clock.step % k_sample_every == 0 || clock.step == scene.relax.steps);
  clock.rebuild = clock.structure || !w.lists.valid || lists_expired(w.rules, clock, w.contacts, w.lists, w.walls);
}

void finish_step(World& w, const std::vector<NodeSpec>& table) {
  std::swap(w.rows.p, w.rows.p2);
  std::swap(w.rows.v, w.rows.v2);
  w.rows.bodies.swap();
  w.rows.velocity_at_old_step = true;
  note_travel(w.contacts, w.lists);
  for (const NodeSpec& node : table)
    if (node.in && node.phase == Phase::finish) run_node(w, node, *w.contacts.chunks.front());
  for (const auto& p : w.parts.all)
    for (const PartConcern& found : p->concerns()) warn_of_part(w.clock, p->name(), found, w.monitor);
  if (w.rules.has.planes) add_crossings(w.rules, w.rows, w.contacts, w.planes);
  if (w.rules.has.superquadrics) count_solved(w);
  const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
  w.team.lane_choice.step_done(now.count(), w.lists.last_rebuild_step != w.clock.step && !w.clock.structure);
  w.team.times.step = ++w.clock.step;
  ++w.counters.steps;
}

void cut_into_chunks(World& w) {
  w.contacts.chunk_size = choose_chunk(w.rules, w.rows);
  w.contacts.chunk_of = ChunkMap(w.contacts.chunk_size);
  make_chunks(w.contacts, w.rows);
  limit_lanes(w.rules, w.contacts, w.team);
}

void take_back(World& w, const StepFailure& failure) {
  w.monitor.culprits = failure.ids();
  if (failure.takes_back()) {
    if (w.counters.steps > 0 && w.rows.velocity_at_old_step) {
      std::swap(w.rows.p, w.rows.p2);
      std::swap(w.rows.v, w.rows.v2);
      w.rows.bodies.swap();
      w.rows.velocity_at_old_step = false;
      w.ledger.work = w.ledger.work_before;
      std::swap(w.ledger.grown, w.ledger.spare);
      w.planes.take_back();
      for (const auto& p : w.parts.all) p->take_back();
      w.team.times.step = --w.clock.step;
      --w.counters.steps;
      w.counters.solved_pairs -= w.counters.step_solved_pairs;
      w.counters.safe_pairs -= w.counters.step_safe_pairs;
      w.counters.step_solved_pairs = w.counters.step_safe_pairs = 0;
      if (w.rules.has.walls) w.walls.set_step(w.clock.step, w.rules.scene.dt);
    }
    forget_results(w.contacts);
    w.lists.valid = false;
  }
  throw Error(ErrorCode::physics, failure.what(), "step " + std::to_string(w.clock.step), failure.cure());
}

}  // namespace talus
