// Which key of a scene was meant by a path that is none: "friction" -> contact.friction, "size.radius" ->
// source.size.diameter. Who calls it: core/scene/scene_table (unknown keys and sections), scene_help, cases/ (options
// that are keys). Invariant: looks at the whole path and at what words mean in other codes, not at the last letters
// alone.
#pragma once

#include <string>
#include <string_view>

#include "core/scene/scene_keys.hpp"

namespace talus {

struct KeySuggestion {
  const SceneKey* key = nullptr;  ///< nullptr: nothing is near
  std::string_view remark;        ///< why, where the name means another quantity; often empty
};

/// `path` as typed: "contact.frictoin", "source.0.size.radius", "friction".
KeySuggestion suggest_key(std::string_view path);

/// The key's path as --set takes it, with the indices of `typed` where it has some and 0 where it has none.
std::string settable_path(const SceneKey& key, std::string_view typed);

/// " (did you mean 'source.size.diameter'? sizes are diameters)", or "" where nothing is near.
std::string key_hint(std::string_view path, bool settable);

}  // namespace talus
