// How long a scene runs. Plain data, as scene.hpp.
#pragma once

#include "core/scene/scene.hpp"

namespace talus {

/// End of the run [s]; infinite for a scene without steps.
double end_of(const Scene& scene);

}  // namespace talus
