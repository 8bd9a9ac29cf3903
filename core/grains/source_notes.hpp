// What should be said about the sources of a scene before it runs. Who calls it: scheduler/ (construction), `talus
// check`. Invariant: nothing here influences a trajectory.
#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/walls/walls.hpp"

namespace talus {

/// Sources whose region lies on both sides of a closed wall (a box or a watertight mesh) when they begin, unless the
/// scene says which side is meant: such a wall may be a solid body or a container. `walls`: in the frame of the
/// domain's lower corner; left at another step.
std::vector<std::string> sides_of_closed_walls(const Scene& scene, WallSet& walls);

/// Sources that would place grains on both sides of a plane, a cylinder or a cone: grains cannot pass it, and those on
/// the far side are rarely meant. `walls` as above.
std::vector<std::string> sides_of_open_walls(const Scene& scene, WallSet& walls);

/// Packs and streams that begin after step 0 and do not even find room among the walls alone.
std::vector<std::string> later_shortfalls(const Scene& scene, WallSet& walls);

/// "source 'rain': 3 of 20 particles due were placed".
std::string shortfall_text(const Scene& scene, std::size_t source, std::int64_t placed, std::int64_t wanted);

}  // namespace talus
