// Loops over blocks and chunks outside the step graph. Who calls it: the rebuild and the sort epoch.
// Invariant: the waiting thread is isolated, it may steal no node of the graph.
#pragma once

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include "scheduler/world.hpp"

namespace talus {

/// Makes room for n elements and some more; the content is lost where it has to grow.
template <class T>
void grow(Column<T>& c, std::size_t n) {
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
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(0, n, timed, tbb::simple_partitioner{}); });
}

}  // namespace talus
