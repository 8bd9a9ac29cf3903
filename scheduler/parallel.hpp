// Loops over blocks and chunks outside the step graph. Who calls it: the rebuild and the sort epoch.
// Invariant: the waiting thread is isolated, it may steal no node of the graph.
#pragma once

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include "core/types.hpp"

namespace talus {

/// Makes room for n elements and some more; the content is lost where it has to grow.
template <class T>
void grow(Column<T>& c, std::size_t n) {
  if (c.size() < n) {
    c.clear();  // nothing to copy
    c.resize(n + n / 8 + 64);
  }
}

/// Runs fn(block) for blocks 0..n-1 in parallel.
template <class F>
void parallel(int n, F fn) {
  if (n == 1) {
    fn(0);
    return;
  }
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(0, n, fn, tbb::simple_partitioner{}); });
}

}  // namespace talus
