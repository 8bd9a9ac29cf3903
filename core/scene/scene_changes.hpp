// What a resumed run may change in its scene: the rules per key, the comparison of two scenes, and the record of a
// scene that a checkpoint carries. Who calls it: cases/ (run --resume). Invariant: a key is refused where the stored
// state would mean something else under the new value.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/scene/scene_contents.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/scene/scene_table.hpp"

namespace talus {

/// The rule of a key, which stands in its line. Throws std::logic_error for a key that is none.
ResumeRule resume_rule(std::string_view section, std::string_view name);

/// A scene with the values that its text gives.
struct SceneText {
  Scene scene;
  std::vector<SceneValue> values;
};
/// As parse_scene. Error{scene}.
SceneText read_scene_text(std::string_view text, const std::string& name, const std::string& directory,
                          const std::vector<std::string>& overrides);

/// The values that a trajectory depends on, as the text of a scene, and sums of the files that it names: what a
/// checkpoint carries.
std::string scene_record(const SceneText& scene);

struct SceneChange {
  std::string path, before, after;  ///< values as TOML; what is not given: "(none)" or the default
  AtResume rule = AtResume::physics;
  std::string why;
  bool content = false;  ///< the value is the same, but the file that it names holds something else
};

/// The scene that a checkpoint belongs to, from what is at hand: the record in it, the scene in its folder, or both.
struct SceneBefore {
  std::optional<SceneText> record, folder;
  std::vector<FileContent> contents{};  ///< of the record
};

/// Every key whose value differs for a run that continues at `step`; the refused ones first.
std::vector<SceneChange> scene_changes(const SceneBefore& before, const SceneText& after, std::int64_t step);

/// For every wall of the scene before (its own, then those of the domain's sides) the number that it has now; -1 where
/// it is gone or has another shape (another content of its mesh is among the changes), so that its contacts begin anew.
/// Empty if the walls are the same.
std::vector<int> wall_numbers(const Scene& before, const Scene& after, const std::vector<SceneChange>& changes = {});

/// "a.b: 1 -> 2"; long values are shortened.
std::string change_text(const SceneChange& change);

}  // namespace talus
