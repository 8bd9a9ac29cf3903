// The repository's own sources as text, for tests of the layout.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "paths.hpp"

namespace talus::layout {
namespace fs = std::filesystem;

inline std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Sources below a folder of the repository, ascending.
inline std::vector<fs::path> sources_of(const std::string& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(TALUS_SOURCE_DIR) / folder)) {
    const fs::path extension = entry.path().extension();
    if (entry.is_regular_file() && (extension == ".cpp" || extension == ".hpp")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Name relative to the repository.
inline std::string name_of(const fs::path& path) { return fs::relative(path, TALUS_SOURCE_DIR).string(); }

/// Targets of all include directives; lines of comments and strings do not start with '#'.
inline std::vector<std::string> includes_in(const std::string& text) {
  std::vector<std::string> found;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::size_t at = line.find_first_not_of(" \t");
    if (at == std::string::npos || line[at] != '#') continue;
    at = line.find_first_not_of(" \t", at + 1);
    if (at == std::string::npos || line.compare(at, 7, "include") != 0) continue;
    const std::size_t open = line.find_first_of("<\"", at + 7);
    const std::size_t close = open == std::string::npos ? open : line.find_first_of(">\"", open + 1);
    if (close != std::string::npos) found.push_back(line.substr(open + 1, close - open - 1));
  }
  return found;
}

/// A line of product code that holds `word`, as "file:line".
inline std::vector<std::string> lines_with(const std::string& word) {
  std::vector<std::string> found;
  for (const char* folder : {"core", "kernels", "scheduler", "cases/program"})
    for (const fs::path& file : sources_of(folder)) {
      std::istringstream lines(read(file));
      int number = 0;
      for (std::string line; std::getline(lines, line);) {
        ++number;
        if (line.find(word) != std::string::npos && line.find_first_not_of(" ") != line.find("//"))
          found.push_back(name_of(file) + ":" + std::to_string(number));
      }
    }
  return found;
}

/// The files among such lines.
inline std::set<std::string> files_with(const std::string& word) {
  std::set<std::string> files;
  for (const std::string& line : lines_with(word)) files.insert(line.substr(0, line.rfind(':')));
  return files;
}

}  // namespace talus::layout
