// Team: the threads of a run, which of them works on what, what their time goes into, and how a node's failure gets out
// of the graph. Who uses it: the step graph, loops over chunks. Nothing here feeds the trajectory.
#pragma once

#include <atomic>
#include <exception>
#include <mutex>
#include <utility>

#include "scheduler/team/lane_choice.hpp"
#include "scheduler/team/pools.hpp"
#include "scheduler/team/profile.hpp"
#include "scheduler/team/shares.hpp"
#include "scheduler/team/step_gate.hpp"

namespace talus {

/// The failure of the lowest chunk; exceptions do not cross TBB.
class Failure {
 public:
  bool any() const noexcept { return failed_.load(std::memory_order_relaxed); }
  void mark() noexcept { failed_.store(true); }  ///< a state that may be looked at but does not go on
  /// Runs a node's body, unless something has failed already. chunk: -1 for serial nodes.
  template <class F>
  void guard(int chunk, F body) {
    if (any()) return;
    try {
      body();
    } catch (...) {
      keep(chunk, std::current_exception());
    }
  }
  /// Throws what was kept, once.
  void rethrow() {
    if (const std::exception_ptr e = std::exchange(error_, nullptr)) std::rethrow_exception(e);
  }

 private:
  void keep(int chunk, std::exception_ptr e) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!error_ || chunk < chunk_) {
      error_ = std::move(e);
      chunk_ = chunk;
    }
    failed_.store(true);
  }

  std::atomic<bool> failed_{false};
  std::mutex mutex_;
  int chunk_ = 0;
  std::exception_ptr error_;
};

struct Team {
  int threads;    ///< asked for; lane_choice says how many work at present
  int lanes = 0;  ///< loops over chunks that the step graph was built with
  NodeTimes times;
  ScratchPool scratch;
  ListScratchPool list_scratch;
  ChunkShares shares;
  StepGate gate;
  LaneChoice lane_choice;
  Failure failure;

  explicit Team(int threads_asked) : threads(threads_asked) {
    lane_choice.prepare(threads);
    times.prepare(threads);
    scratch.prepare(threads);
  }
};

/// Slot of the calling thread in the arena of the run, or -1.
int thread_slot(const Team& team) noexcept;

}  // namespace talus
