// The flow graph of the step table. There are as many loops over chunks ("lanes") as threads can work at once. The
// first chunk node takes the next chunk of its thread's share, or of another one's when that is used up (shares.hpp),
// so lanes balance themselves. Only that node is a task; the nodes behind it run within it (lightweight): a task for
// every node and chunk took 0.38 us per chunk of one thread instead of 0.22. A lane without chunks reports to the join
// and waits for the next step in place (step_gate.hpp), unless that begins with a rebuild: then, and for any other loop
// over chunks, the threads are sent away and start hands out all lanes. A merge is a function_node (a continue_node
// counts predecessors), a branch a multifunction_node.
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <deque>
#include <stdexcept>

#include "scheduler/lists/audit.hpp"
#include "scheduler/step/step.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/team/available_cores.hpp"

namespace talus {

namespace {

using namespace tbb::flow;
using Go = continue_msg;

/// The wall time of a run for the profile, also when it fails.
class TimedRun {
 public:
  explicit TimedRun(World& w) : w_(w), first_(w.clock.step) { w_.team.times.run_begins(); }
  ~TimedRun() { w_.team.times.run_ends(w_.clock.step - first_); }
  TimedRun(const TimedRun&) = delete;
  TimedRun& operator=(const TimedRun&) = delete;

 private:
  World& w_;
  std::int64_t first_;
};

/// One of the loops over chunks of the step graph, and the chunk that it works on.
struct alignas(128) Lane {
  int index;
  Chunk* chunk = nullptr;
};

int lanes_of(const World& w) { return std::max(1, std::min(w.team.lane_choice.threads(), w.contacts.count())); }

/// The graph for the present number of lanes; it stops where another number is wanted.
class StepGraph {
 public:
  StepGraph(World& w, const std::vector<NodeSpec>& table)
      : w_(w),
        table_(table),
        check_(g_, unlimited, [this](const Go&, Check::output_ports_type& ports) noexcept { check(ports); }),
        insert_(g_, serial,
                [this](const Go&) {
                  run_all(Phase::insert);
                  return Go();
                }),
        rebuild_(g_, serial, [this](const Go&, Single::output_ports_type& ports) { rebuild(ports); }),
        start_(g_, unlimited, [this](const Go&, LightSingle::output_ports_type& ports) noexcept { start(ports); }),
        join_(g_, [this](const Go&) noexcept {
          w_.team.failure.guard(-1, [this] { finish_step(w_, table_); });
          return Go();
        }) {
    w_.team.lanes = lanes_of(w_);
    w_.team.shares.prepare(w_.contacts.count(), w_.team.lane_choice.threads());
    static const int cores = available_cores();
    w_.team.gate.prepare(w_.team.lanes, w_.team.lane_choice.threads() <= cores);
    for (int k = 0; k < w_.team.lanes; ++k) add_lane(lanes_.emplace_back(Lane{k}));
    connect();
  }

  /// Runs steps until the target, a failure, or until another number of lanes is wanted; `at_start`: the lists have
  /// been made already. Returns whether the graph stopped between rebuild and start.
  bool run(bool at_start) {
    if (at_start)
      start_.try_put(Go());
    else
      check_.try_put(Go());
    g_.wait_for_all();
    return rebuilt_;
  }

 private:
  using Check = multifunction_node<Go, std::tuple<Go, Go>, lightweight>;
  using Single = multifunction_node<Go, std::tuple<Go>>;
  using LightSingle = multifunction_node<Go, std::tuple<Go>, lightweight>;
  using Narrow = multifunction_node<Go, std::tuple<Go, Go>>;

  void run_all(Phase phase) {
    for (const NodeSpec& n : table_)
      if (n.in && n.phase == phase) run_node(w_, n, w_.contacts[0]);
  }

  void check(Check::output_ports_type& ports) {
    if (lanes_of(w_) != w_.team.lanes && w_.clock.step < w_.clock.target) {  // another graph decides about this step
      w_.team.gate.dismiss();
      return;
    }
    run_all(Phase::decide);
    const bool stop = w_.clock.stop || w_.team.failure.any();
    if (stop || w_.clock.rebuild) w_.team.gate.dismiss();
    if (stop) return;
    if (w_.clock.rebuild)
      std::get<0>(ports).try_put(Go());
    else
      std::get<1>(ports).try_put(Go());
  }

  void rebuild(Single::output_ports_type& ports) {
    const bool epoch = w_.clock.step % w_.rules.scene.sort_every == 0;
    for (const NodeSpec& n : table_)
      if (n.phase == Phase::lists && (epoch || n.id != Node::sort_epoch)) run_node(w_, n, w_.contacts[0]);
    // another number of lanes needs another graph
    if (!w_.team.failure.any() && lanes_of(w_) == w_.team.lanes)
      std::get<0>(ports).try_put(Go());
    else
      rebuilt_ = true;
  }

  void start(LightSingle::output_ports_type& ports) {
    w_.team.failure.guard(-1, [this] {
      if (w_.rules.options.audit)
        w_.counters.missed_contacts += audit_lists(w_.rules, w_.rows, w_.contacts, w_.lists, w_.walls);
    });
    w_.team.shares.begin_round();
    if (w_.team.gate.dismissed()) {
      w_.team.gate.started();
      std::get<0>(ports).try_put(Go());
    } else {
      w_.team.gate.open([this](std::uint16_t lane) { first_[lane].try_put(Go()); });
    }
  }

  /// The first node of a lane: takes a chunk, or waits for the next step.
  void take_chunk(Lane& lane, const NodeSpec& node, Narrow::output_ports_type& ports) {
    const int slot = thread_slot(w_.team);
    int k = w_.team.shares.take(slot);
    while (k < 0) {
      const std::uint32_t round = w_.team.gate.round();
      std::get<1>(ports).try_put(Go());
      if (!w_.team.gate.await(round, lane.index)) return;
      k = w_.team.shares.take(slot);
    }
    lane.chunk = &w_.contacts[k];
    run_node(w_, node, *lane.chunk);
    std::get<0>(ports).try_put(Go());
  }

  /// The chunk nodes of the table, one behind the other, in a ring.
  void add_lane(Lane& lane) {
    Narrow* first = nullptr;
    continue_node<Go, lightweight>* last = nullptr;
    for (const NodeSpec& n : table_) {
      if (!n.in || n.phase != Phase::chunk) continue;
      if (first == nullptr) {
        first = &first_.emplace_back(
            g_, unlimited,
            [this, &lane, &n](const Go&, Narrow::output_ports_type& ports) noexcept { take_chunk(lane, n, ports); });
        continue;
      }
      auto& next = inner_.emplace_back(g_, [this, &lane, &n](const Go&) noexcept {
        run_node(w_, n, *lane.chunk);
        return Go();
      });
      if (last == nullptr)
        make_edge(output_port<0>(*first), next);
      else
        make_edge(*last, next);
      last = &next;
    }
    make_edge(*last, *first);
    make_edge(output_port<1>(*first), join_);
  }

  /// Halving ranges hand the lanes on: a thief takes half of what is left and becomes a victim itself. With all lanes
  /// in one thread's queue 27 others look for that one queue at random, 0.4 us per miss.
  receiver<Go>& fan_out(std::size_t lo, std::size_t hi) {
    if (hi - lo == 1) return first_[lo];
    auto& half = forks_.emplace_back(g_, [](const Go&) { return Go(); });
    make_edge(half, fan_out(lo, (lo + hi) / 2));
    make_edge(half, fan_out((lo + hi) / 2, hi));
    return half;
  }

  void connect() {
    make_edge(output_port<0>(start_), fan_out(0, first_.size()));
    const bool inserts =
        std::any_of(table_.begin(), table_.end(), [](const NodeSpec& n) { return n.in && n.phase == Phase::insert; });
    if (inserts) {
      make_edge(output_port<0>(check_), insert_);
      make_edge(insert_, rebuild_);
    } else {
      make_edge(output_port<0>(check_), rebuild_);
    }
    make_edge(output_port<0>(rebuild_), start_);
    make_edge(output_port<1>(check_), start_);
    make_edge(join_, check_);
  }

  World& w_;
  const std::vector<NodeSpec>& table_;
  bool rebuilt_ = false;
  graph g_;
  Check check_;
  function_node<Go, Go> insert_;
  Single rebuild_;
  LightSingle start_;
  continue_node<Go, lightweight> join_;
  std::deque<Lane> lanes_;
  std::deque<Narrow> first_;  ///< of every lane
  std::deque<continue_node<Go, lightweight>> inner_;
  std::deque<continue_node<Go>> forks_;
};

void give_back_scratch(World& w) {
  for (const auto& c : w.contacts.chunks)
    if (c->scratch != nullptr) {
      w.team.scratch.give(c->scratch);
      c->scratch = nullptr;
    }
}

}  // namespace

void run_graph(World& w, std::int64_t target) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(w.team.threads));
  const std::vector<NodeSpec> table = step_table(w);
  const TimedRun timed(w);
  w.clock.target = target;
  bool at_start = false;
  do {
    tbb::task_arena arena(w.team.lane_choice.threads());
    bool rebuilt = false;
    arena.execute([&] { rebuilt = StepGraph(w, table).run(at_start); });
    if (w.team.failure.any()) {
      give_back_scratch(w);
      taking_back(w, [&] { w.team.failure.rethrow(); });
    }
    at_start = w.clock.step < target && rebuilt;
    // it ends early only to be built anew: a lane that is lost must not become a step that is made twice
    if (w.clock.step < target && !rebuilt && lanes_of(w) == w.team.lanes) {
      w.team.failure.mark();
      throw std::logic_error("the step graph ended within step " + std::to_string(w.clock.step));
    }
  } while (w.clock.step < target);
}

}  // namespace talus
