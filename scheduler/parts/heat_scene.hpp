// What a scene says of heat that its grains contradict, beside what its section refuses by itself. Called by heat.cpp.
#pragma once

#include "scheduler/state/rules.hpp"

namespace talus {

/// Error{scene} where heat and the sizes of grains contradict each other.
void refuse_odd_heat(const Rules& rules);

}  // namespace talus
