// What the files held that a scene names and its state depends on: a resumed run compares them with what they hold now.
// Who calls it: scene_changes.cpp, cases/ (run --resume).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace talus {

struct Scene;

struct FileContent {
  std::string path;  ///< of the key: "wall.0.file"
  std::string sum;   ///< of the file's bytes
};

/// Of meshes of walls, tables of shapes and files of grains; those that cannot be read are left out. Initial states are
/// no part: nothing of them is read after the start.
std::vector<FileContent> contents_of(const Scene& scene);

/// Comments at the end of a scene's record, and what they say.
std::string contents_text(const std::vector<FileContent>& contents);
std::vector<FileContent> contents_in(std::string_view record);

}  // namespace talus
