// Loops over blocks and chunks outside the step graph. Who calls it: the rebuild, the sort epoch, set-up from a
// checkpoint. Invariant: the waiting thread is isolated, it may steal no node of the graph.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "scheduler/state/contacts.hpp"
#include "scheduler/team/team.hpp"

namespace talus {

/// Runs fn(block) for blocks 0..n-1 in parallel; in their order by a team of one, wherever it is called: what such a
/// team runs counts without atomics. Timed as a loop and its blocks.
template <class F>
void parallel(Team& team, int n, F fn) {
  const NodeTimer loop(team.times, Timed::loop, -1);
  const auto timed = [&](int k) {
    const NodeTimer block(team.times, Timed::block, k);
    fn(k);
  };
  if (n == 1 || team.threads == 1) {
    for (int k = 0; k < n; ++k) timed(k);
    return;
  }
  team.gate.dismiss();  // the threads of waiting lanes are wanted here
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(0, n, timed, tbb::simple_partitioner{}); });
}

/// Runs fn() with the threads of the run; for what happens outside of the step graph.
template <class F>
void with_threads(const Team& team, F fn) {
  const int threads = team.lane_choice.threads();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute(fn);
}

/// Runs fn(chunk) over all chunks in parallel, each on the thread of its share, isolated from the graph (a waiting
/// thread may steal no graph node).
template <class F>
void for_chunks(Team& team, Contacts& contacts, F fn) {
  const int chunks = contacts.count();
  team.shares.prepare(chunks, team.lane_choice.threads());
  team.shares.begin_round();
  parallel(team, chunks, [&](int) { fn(contacts[team.shares.take(thread_slot(team))]); });
}

/// No more lanes than chunks. Chunks of a chosen size are not smaller than what pays a thread; who asks for a size asks
/// for the threads, too.
inline void limit_lanes(const Rules& rules, const Contacts& contacts, Team& team) {
  if (rules.options.chunk == 0) team.lane_choice.limit(contacts.count());
}

/// Equal blocks of n elements.
struct Blocks {
  std::int64_t n;
  int count;
  std::int64_t from(int b) const { return n * b / count; }
  std::int64_t to(int b) const { return n * (b + 1) / count; }
};

/// Blocks of a loop that counts into `bins` per block: as many as chunks whatever the threads (a recorded run is
/// replayed on more), within 4 Mi counters and where adding up 256 blocks is no work yet.
inline Blocks counting_blocks(const Contacts& contacts, std::int64_t n, std::int64_t bins) {
  const std::int64_t most = std::clamp<std::int64_t>((std::int64_t{1} << 22) / std::max<std::int64_t>(bins, 1), 1, 256);
  return {n, static_cast<int>(std::clamp<std::int64_t>(static_cast<std::int64_t>(contacts.chunks.size()), 1, most))};
}

/// Counts per block and bin, [block][bin], become first positions within the bin: those of the blocks before. Returns
/// the totals of the bins.
inline std::vector<std::int32_t> scan_blocks(std::vector<std::int32_t>& counts, int blocks) {
  const std::size_t bins = counts.size() / static_cast<std::size_t>(blocks);
  std::vector<std::int32_t> total(bins, 0);
  for (int b = 0; b < blocks; ++b) {
    std::int32_t *c = counts.data() + static_cast<std::size_t>(b) * bins, *t = total.data();
    for (std::size_t k = 0; k < bins; ++k) {
      const std::int32_t before = t[k];
      t[k] += c[k];
      c[k] = before;
    }
  }
  return total;
}

}  // namespace talus
