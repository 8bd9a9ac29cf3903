// Times of the step graph's nodes: what `--profile`, `--trace` and summary.json show. Who calls it: every node body
// opens a NodeTimer; simulation.cpp reports. Invariants: a thread writes only its own ThreadTimes (its slot in the
// arena), so timing shares nothing; times are exclusive (a node inside another one is not counted twice); nothing here
// feeds the trajectory.
#pragma once

#include <x86intrin.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "scheduler/reports.hpp"

namespace talus {

/// Nodes of the step graph, in order; those of optional parts follow from `count` on.
enum class Node : int {
  displacement_check,
  insert,
  sort_epoch,
  rebuild,
  narrow_phase,
  contact_force,
  wall_contact,
  integrate,
  resize,
  plane_count,
  energy,
  count
};
inline constexpr int k_most_nodes = 24;  ///< with those of optional parts

/// What a timer times: an execution of a node; a block of a parallel loop inside a serial node; the whole parallel
/// loop, of which the part that is not in own blocks is waiting for other threads.
enum class Timed : std::uint8_t { node, block, loop };

struct TraceEvent {
  std::int64_t step;
  std::uint64_t begin, end;  ///< [ticks]
  int chunk;                 ///< or block; -1: serial
  int loop;                  ///< number of the parallel loop within its serial node, from 1; 0: no block
  Node node;
};

/// What one thread has done since the last restart; one or more cache lines of its own.
struct alignas(128) ThreadTimes {
  std::uint64_t ticks[k_most_nodes] = {};
  std::int64_t calls[k_most_nodes] = {};
  std::uint64_t waiting = 0;   ///< inside a serial node, for other threads' blocks
  std::uint64_t children = 0;  ///< ticks of finished timers inside the open one
  std::uint64_t last_end = 0;  ///< of the last chunk node, for the time between chained nodes
  int last_chunk = -1;
  std::uint64_t hop_ticks = 0;
  std::int64_t hops = 0, timers = 0;
  std::vector<TraceEvent> trace;
};

/// The serial node that is open and the number of parallel loops it has run: written by its thread, read by the blocks.
struct SerialNode {
  Node node{-1};  ///< none
  int loops = 0;
};

/// All times of a run. Time stamps are the processor's cycle counter (a third of the cost of a library clock), scaled
/// at the end by the steady clock.
class NodeTimes {
 public:
  void prepare(int threads);  ///< forgets everything; before the first step
  void restart();             ///< times from now on; keeps the trace. Not while a graph runs
  void trace(std::int64_t first_step, std::int64_t steps) noexcept;
  bool tracing(std::int64_t step) const noexcept { return step >= trace_from_ && step < trace_until_; }
  void run_begins() noexcept;
  void run_ends(std::int64_t steps) noexcept;
  SerialNode serial;
  std::vector<std::string> names;  ///< of the nodes, by number (step table)
  std::int64_t step = 0;           ///< that a trace shows; written between two steps
  ThreadTimes* mine() noexcept;    ///< of the calling thread; null outside of a running graph
  Profile report() const;
  /// Of a node since the last restart, summed over threads [ticks]; only from a serial node.
  std::uint64_t ticks(Node node) const noexcept;
  /// Chrome trace JSON; `facts` are key and JSON value of what the reader needs to know. Error{io}.
  void write(const std::string& path, const std::vector<std::pair<std::string, std::string>>& facts) const;

 private:
  double seconds_per_tick() const;

  std::vector<ThreadTimes> threads_;
  bool running_ = false;
  std::uint64_t run_begin_ = 0, wall_ = 0;  ///< [ticks]
  std::int64_t steps_ = 0;
  std::int64_t trace_from_ = 0, trace_until_ = 0;
  std::uint64_t zero_ticks_ = 0;
  std::chrono::steady_clock::time_point zero_;
};

/// Times one execution of a node on a chunk (or -1) and records it for profile and trace.
class NodeTimer {
 public:
  NodeTimer(NodeTimes& times, int chunk, Node node);
  /// A block of a parallel loop, or (block -1) the loop itself, inside the serial node that is open.
  NodeTimer(NodeTimes& times, Timed timed, int block);
  ~NodeTimer();
  NodeTimer(const NodeTimer&) = delete;
  NodeTimer& operator=(const NodeTimer&) = delete;

 private:
  NodeTimes& all_;
  ThreadTimes* times_;
  int chunk_;
  Node node_;
  Timed timed_;
  SerialNode outer_;
  std::uint64_t outer_children_ = 0, begin_ = 0;
};

}  // namespace talus
