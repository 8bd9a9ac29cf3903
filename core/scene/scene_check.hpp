// The checks of one table of a scene against the key table, and where messages point. Who calls it: scene_table.cpp,
// scene_override.cpp. Invariant: what is unknown, of a wrong type, out of range or without effect never passes.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene_keys.hpp"
#include "core/scene/toml_tree.hpp"

namespace talus {

/// The text of a scene by name, and which paths were set on the command line.
struct SceneContext {
  std::string name;
  std::map<std::string, std::string> overrides;  ///< path -> "path=value"

  /// "--set path=value" where that, or what it lies in, was set so, else `written`.
  std::string where(const std::string& path, const std::string& written) const;
};

/// "section.name", or the name alone.
std::string join_path(std::string_view path, std::string_view name);
std::vector<std::string> choice_words(const SceneKey& key);
/// The value of a key: that of `table` (or null), also a section, for messages; else the default of the key table.
const TomlNode& node_of(const TomlNode* table, const std::string& section, std::string_view name);

[[noreturn]] void fail_value(const SceneContext& context, const std::string& path, const TomlNode& node,
                             const std::string& allowed);

/// Error{scene}: unknown keys, types, ranges.
void check_types(const SceneContext& context, const TomlNode& table, const std::string& section,
                 const std::string& path);
/// Error{scene}: keys that would have no effect.
void check_effects(const SceneContext& context, const TomlNode& table, const std::string& section,
                   const std::string& path);

}  // namespace talus
