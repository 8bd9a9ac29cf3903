// What a scene leaves out that most scenes have: said once, since zero may be meant or forgotten. Who calls it: cases/
// (run, check). Invariant: a key that is given, zero or "none" included, counts as meant.
#pragma once

#include <string>
#include <vector>

#include "core/scene/scene_changes.hpp"

namespace talus {

/// One line per forgotten thing: what follows from its absence, and what states that it is meant. `cut`: the run is
/// asked to end before the scene would, so that what comes later is no mistake.
std::vector<std::string> forgotten_keys(const SceneText& scene, bool cut = false);

}  // namespace talus
