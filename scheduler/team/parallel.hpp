// Loops over blocks and chunks outside the step graph. Who calls it: the rebuild, the sort epoch, set-up from a
// checkpoint. Invariant: the waiting thread is isolated, it may steal no node of the graph.
#pragma once

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "scheduler/step/world.hpp"

namespace talus {

/// Makes room for n elements and some more; the content is lost where it has to grow.
template <class T>
void grow_discarding(Column<T>& c, std::size_t n) {
  if (c.size() < n) {
    c.clear();  // nothing to copy
    c.resize(n + n / 8 + 64);
  }
}

/// Runs fn(block) for blocks 0..n-1 in parallel. Timed as a loop and its blocks.
template <class F>
void parallel(World& w, int n, F fn) {
  const NodeTimer loop(w, Timed::loop, -1);
  const auto timed = [&](int k) {
    const NodeTimer block(w, Timed::block, k);
    fn(k);
  };
  if (n == 1) {
    timed(0);
    return;
  }
  w.gate.dismiss();  // the threads of waiting lanes are wanted here
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(0, n, timed, tbb::simple_partitioner{}); });
}

/// Runs fn() with the threads of the run; for what happens outside of the step graph.
template <class F>
void with_threads(const World& w, F fn) {
  const int threads = w.lane_choice.threads();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute(fn);
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
inline Blocks counting_blocks(const World& w, std::int64_t n, std::int64_t bins) {
  const std::int64_t most = std::clamp<std::int64_t>((std::int64_t{1} << 22) / std::max<std::int64_t>(bins, 1), 1, 256);
  return {n, static_cast<int>(std::clamp<std::int64_t>(static_cast<std::int64_t>(w.chunks.size()), 1, most))};
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
