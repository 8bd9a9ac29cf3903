// A key of a scene given on the command line, "section.key=value". Who calls it: scene_table.cpp.
#pragma once

#include <string>

#include "core/scene/scene_check.hpp"

namespace talus {

/// Puts the value into the tree and notes the path in the context. Error{scene} for what names no section or entry.
void apply_override(TomlNode& root, const std::string& text, SceneContext& context);

}  // namespace talus
