// What the sources say about themselves: pages of folders, and comments that a reader gets through.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/layout/sources.hpp"

namespace talus::layout {
namespace {

std::size_t lines_in(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(Words, EachFolderSaysWhatLivesThereInThirtyLines) {
  for (const char* folder : {"core", "core/scene", "core/walls", "core/frame", "core/io", "kernels", "scheduler",
                             "scheduler/lists", "cases/program"}) {
    const std::string page = read(fs::path(TALUS_SOURCE_DIR) / folder / "README.md");
    EXPECT_EQ(page.rfind("# " + std::string(folder), 0), 0u) << folder << " has no page";
    EXPECT_LE(lines_in(page), 30u) << folder;
    // a sub-folder that the page does not name is one that its reader does not find
    for (const auto& entry : fs::directory_iterator(fs::path(TALUS_SOURCE_DIR) / folder)) {
      const std::string name = entry.path().filename().string();
      if (!entry.is_directory() || name[0] == '.' || name == "__pycache__") continue;
      EXPECT_NE(page.find(name), std::string::npos) << folder << "/README.md does not name " << name;
    }
  }
}

TEST(Words, TheInvariantsThatCodeCitesStandOnThePageOfCore) {
  const std::string page = read(fs::path(TALUS_SOURCE_DIR) / "core/README.md");
  for (int k = 1; k <= 9; ++k) EXPECT_NE(page.find("- **I" + std::to_string(k) + " "), std::string::npos) << k;
}

/// Lines of the longest comment that nothing interrupts.
int longest_comment(const std::string& text) {
  std::istringstream lines(text);
  int longest = 0, now = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find_first_not_of(" \t");
    now = at != std::string::npos && line.compare(at, 2, "//") == 0 ? now + 1 : 0;
    longest = std::max(longest, now);
  }
  return longest;
}

TEST(Words, NoCommentIsLongerThanFifteenLines) {
  EXPECT_EQ(longest_comment("// a\n  /// b\nint x; // c\n// d\n"), 2);
  for (const char* folder : {"core", "kernels", "scheduler", "cases/program", "tests", "perf"})
    for (const fs::path& file : sources_of(folder)) EXPECT_LE(longest_comment(read(file)), 15) << name_of(file);
}

}  // namespace
}  // namespace talus::layout
