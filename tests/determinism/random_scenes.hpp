// Random small scenes for the list audit: at most 500 grains, speeds over three decades, every kind of boundary, wall,
// wall motion, source and event that the list has to survive.
// Who calls it: exact_lists_test. Invariants: a scene is a pure function of its index.
#pragma once

#include "core/scene/scene.hpp"

namespace talus::determinism {

inline constexpr std::int64_t k_audit_steps = 200;

/// What a random scene contains, for the statistics.
struct RandomScene {
  Scene scene;
  double speed = 0;  ///< of the fastest source [m/s]
  double ratio = 1;  ///< largest / smallest diameter
  bool periodic = false, open = false, moving_walls = false, inserts = false, mesh = false, events = false;
};
RandomScene random_scene(int index);

/// Random way of running it with the given policy.
Scene with_random_list(const Scene& scene, ListPolicy policy, int index);
RunOptions random_options(int index);

}  // namespace talus::determinism
