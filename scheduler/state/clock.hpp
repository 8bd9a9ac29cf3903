// Clock: the present step, and what acts in it. Who writes it: the step (check_step, insert_step, finish_step).
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/types.hpp"

namespace talus {

struct Clock {
  std::int64_t step = 0;
  Vec3 gravity;                ///< [m/s2]
  std::size_t next_event = 0;  ///< of the scene, sorted by time
  std::int64_t target = 0;     ///< step that the run ends at
  bool stop = false;           ///< it is reached
  bool rebuild = false;        ///< the present step begins with new lists
  bool structure = false;      ///< an epoch, an insertion or an event acts in the present step
  bool sampled = false;        ///< the monitor looks at the present step
};

}  // namespace talus
