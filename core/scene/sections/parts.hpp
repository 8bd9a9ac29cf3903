// Sections and keys of optional parts (scheduler/parts): each in a file of its own, which this list names. Who uses it:
// core/scene/scene_keys.cpp and scene_file.cpp.
#pragma once

#include <vector>

#include "core/scene/sections/sections.hpp"

namespace talus {

struct PartSections {
  std::vector<const SectionKeys*> keys;                ///< sections of its own, and keys that it adds to others
  void (*read)(const SceneTable& root, Scene& scene);  ///< after all other sections. Error{scene}
};

const PartSections &shape_sections(), &tracer_sections(), &heat_sections(), &laser_sections(), &conversion_sections(),
    &gas_sections();

/// In the order in which they are read.
inline std::vector<const PartSections*> part_sections() {
  return {&tracer_sections(),     &heat_sections(), &laser_sections(),
          &conversion_sections(), &gas_sections(),  &shape_sections()};
}

}  // namespace talus
