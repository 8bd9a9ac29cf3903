// The whole state to and from a checkpoint (I6). Who calls it: Simulation.
#pragma once

#include <cstdint>
#include <vector>

#include "core/io/checkpoint.hpp"

namespace talus {

struct World;

void save_state(const World& w, CheckpointWriter& out);
/// Into a World that has no rows yet. `walls`: see Simulation. Error{io}.
void restore_state(World& w, const CheckpointReader& in, const std::vector<int>& walls);
std::int64_t step_of_checkpoint(const CheckpointReader& in);  ///< Error{io}

}  // namespace talus
