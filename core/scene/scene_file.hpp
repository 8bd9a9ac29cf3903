// Scene files: TOML text -> validated Scene. Who calls it: cases/ (every command), tests. Invariants: every key, type
// and range comes from core/scene/sections; an unknown, wrong or contradictory key never passes silently.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.hpp"

namespace talus {

/// Reads and checks a scene file. `overrides` are texts "section.key=value" (TOML value, or a bare text where that does
/// not parse; repeated tables by index: "wall.0.material=steel"); overriding time.steps drops time.duration and the
/// other way round. Error{scene} as "file:line:col: key: value: what is allowed"; for an override "--set key=value"
/// takes the place of file:line:col. Files that the scene names are not opened here.
Scene load_scene(const std::string& path, const std::vector<std::string>& overrides = {});

/// The two parts of that: the text of a scene file, Error{scene}; the base of its relative paths.
std::string read_scene_file(const std::string& path);
std::string scene_directory(const std::string& path);

/// The same from text; `name` stands for the file in messages, `directory` is the base of relative paths.
Scene parse_scene(std::string_view text, std::string name, std::string directory,
                  const std::vector<std::string>& overrides = {});

}  // namespace talus
