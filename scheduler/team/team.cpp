// See team.hpp.
#include "scheduler/team/team.hpp"

#include <oneapi/tbb/task_arena.h>

namespace talus {

int thread_slot(const Team& team) noexcept {
  const int slot = tbb::this_task_arena::current_thread_index();
  return slot >= 0 && slot < team.threads ? slot : -1;
}

}  // namespace talus
