// Names of scratch files and folders: unguessable, and marked as made by Talus. Who calls it: core/io (atomic_file,
// run_folder, vtkhdf). Invariant: nothing is ever deleted because its name merely looks temporary; what carries the
// mark is deleted by the run that made it, or by a later one that holds the lock of the same run folder.
#pragma once

#include <string>
#include <string_view>

namespace talus {

/// A name beside `path` that nothing has: FOLDER/.talus-<16 hex digits from the system's random source>.
std::string scratch_beside(const std::string& path);
/// True for the file names that scratch_beside() makes.
bool is_scratch_name(std::string_view name) noexcept;
/// The folder part of a path: "." where there is none.
std::string folder_of(const std::string& path);

}  // namespace talus
