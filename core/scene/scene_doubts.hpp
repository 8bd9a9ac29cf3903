// What a scene says that is allowed and rarely meant. Who calls it: forgotten_keys(). Invariant: notes, no refusals.
#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace talus {

/// One line each: events, sources, walls and motions that the run ends before; walls that no grain can reach;
/// temperatures that look like degrees Celsius, coefficients like angles in degrees, gas that conducts like none;
/// averages over space that is not there, or smaller than bodies that are no spheres. `cut`: as forgotten_keys().
std::vector<std::string> doubts_of(const Scene& scene, bool cut);

}  // namespace talus
