// Walls that would stand elsewhere after a resume with another motion: a motion counts from its start, so that a new
// rate moves the wall at once by what it would have made until now. Who calls it: cases/ (run --resume).
#pragma once

#include <cstdint>
#include <string>

#include "core/scene/scene.hpp"

namespace talus {

struct WallJump {
  std::string wall;
  double distance =
      0;  ///< largest of its points; of cylinders and cones the ends of the axis, of planes across them [m]
};

/// The wall of `after`, of those with the name and shape that they had before, that is farthest from where the motions
/// of `before` have brought it at this step. Error{scene} for a broken mesh.
WallJump largest_jump(const Scene& before, const Scene& after, std::int64_t step);

}  // namespace talus
