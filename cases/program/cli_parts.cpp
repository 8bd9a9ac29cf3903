// See cli_parts.hpp.
#include "cases/program/cli_parts.hpp"

#include <cstdlib>
#include <filesystem>
#include <vector>

#include "core/base/error.hpp"
#include "paths.hpp"

namespace talus::cli {
namespace fs = std::filesystem;

std::string part(const std::string& name) {
  std::vector<fs::path> places;
  // Who sets it wants this place and no other.
  if (const char* share = std::getenv("TALUS_SHARE"); share != nullptr && *share != '\0') {
    places = {share};
  } else {
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
    if (!program.empty()) places.push_back(program.parent_path().parent_path() / "share" / "talus");
    places.push_back(TALUS_SOURCE_DIR);
  }
  std::string tried;
  for (const fs::path& place : places) {
    std::error_code ignored;
    if (fs::is_regular_file(place / name, ignored)) return (place / name).string();
    tried += (tried.empty() ? "" : ", ") + place.string();
  }
  throw Error(ErrorCode::io, "this part of the program is not found in " + tried, name,
              "install Talus whole (cmake --install), or set TALUS_SHARE to the folder that holds it");
}

}  // namespace talus::cli
