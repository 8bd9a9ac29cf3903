// Numbers of the house: lines of code, largest file, longest function, largest struct of each layer, and how many
// functions are given the whole World. They are printed, and held to bounds so that they cannot creep back.
// TALUS_HOUSE=folder: of another checkout (printed only).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "paths.hpp"

namespace {
namespace fs = std::filesystem;
using Lines = std::vector<std::string>;

std::string root() {
  const char* other = std::getenv("TALUS_HOUSE");
  return other != nullptr ? other : TALUS_SOURCE_DIR;
}

Lines lines_of(const fs::path& path) {
  std::ifstream in(path);
  Lines lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line.substr(0, line.find("//")));
  return lines;
}

std::vector<fs::path> sources(const std::string& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(root() + "/" + folder))
    if (entry.path().extension() == ".cpp" || entry.path().extension() == ".hpp") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

std::size_t indent_of(const std::string& line) { return std::min(line.find_first_not_of(' '), line.size()); }

struct Largest {
  int value = 0;
  std::string where;
  void offer(int v, const std::string& w) {
    if (v > value) value = v, where = w;
  }
};

/// The line at which what closes at `end` begins: the last one before it that is indented alike and closes nothing.
std::size_t head_of(const Lines& lines, std::size_t end) {
  const std::size_t indent = indent_of(lines[end]);
  for (std::size_t k = end; k-- > 0;)
    if (indent_of(lines[k]) == indent && lines[k].size() > indent &&
        std::string("}#:").find(lines[k][indent]) == std::string::npos)
      return k;
  return end;
}

/// Functions: what closes with a lone brace (the sources are formatted) and begins with neither a type nor a statement.
void offer_functions(const Lines& lines, const std::string& file, Largest& longest) {
  static const std::regex other(R"(^\s*(struct|class|enum|namespace|if|for|while|switch|else|do|try|case)\b.*)");
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const std::size_t indent = indent_of(lines[k]);
    if (indent > 2 || lines[k].substr(std::min(indent, lines[k].size())) != "}") continue;
    const std::size_t head = head_of(lines, k);
    if (std::regex_match(lines[head], other) || lines[head].find('(') == std::string::npos) continue;
    longest.offer(static_cast<int>(k - head + 1), file + ":" + std::to_string(head + 1));
  }
}

/// Data members of structs at file level: declarations one level in, a name for each comma outside of brackets.
void offer_structs(const Lines& lines, const std::string& file, Largest& most) {
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (lines[k] != "};") continue;
    const std::size_t head = head_of(lines, k);
    if (lines[head].rfind("struct ", 0) != 0 && lines[head].rfind("class ", 0) != 0) continue;
    int members = 0;
    for (std::size_t q = head + 1; q < k; ++q) {
      const std::string& line = lines[q];
      if (indent_of(line) != 2 || line.find(';') == std::string::npos) continue;
      static const std::regex no_member(
          R"(^\s*(using|static|friend|enum|struct|class|template|explicit|return)\b.*|.*[\w>&*]\s*\w+\(.*)");
      if (std::regex_match(line, no_member) || line.find("}") == 2) continue;
      int depth = 0;
      ++members;
      for (const char c : line) {
        depth +=
            c == '<' || c == '{' || c == '(' || c == '[' ? 1 : (c == '>' || c == '}' || c == ')' || c == ']' ? -1 : 0);
        members += c == ',' && depth == 0 ? 1 : 0;
      }
    }
    most.offer(members, file + ":" + std::to_string(head + 1));
  }
}

/// What is printed of one layer.
struct Numbers {
  Largest function, structure, file;
  int code = 0, over_400 = 0;

  explicit Numbers(const std::string& folder) {
    for (const fs::path& path : sources(folder)) {
      const Lines lines = lines_of(path);
      const std::string name = fs::relative(path, root()).string();
      file.offer(static_cast<int>(lines.size()), name);
      over_400 += lines.size() > 400 ? 1 : 0;
      for (const std::string& line : lines) code += line.find_first_not_of(' ') != std::string::npos ? 1 : 0;
      offer_functions(lines, name, function);
      offer_structs(lines, name, structure);
    }
  }
};

// Structs of plain data (what a file or a table has in columns) may have more members than those that own state.
TEST(House, LayersStaySmall) {
  std::printf("%-14s %7s %6s  longest function, largest struct, largest file\n", "", "lines", "> 400");
  int code = 0;
  for (const char* folder : {"core", "kernels", "scheduler", "cases/program"}) {
    const Numbers n(folder);
    code += n.code;
    std::printf("%-14s %7d %6d  %d lines (%s), %d members (%s), %d lines (%s)\n", folder, n.code, n.over_400,
                n.function.value, n.function.where.c_str(), n.structure.value, n.structure.where.c_str(), n.file.value,
                n.file.where.c_str());
    if (std::getenv("TALUS_HOUSE") != nullptr) continue;
    EXPECT_LE(n.over_400, std::string(folder) == "core" ? 1 : 0) << n.file.where;
    EXPECT_GT(n.structure.value, 10) << "the scanner sees something";
    EXPECT_GT(n.function.value, 30);
    EXPECT_LE(n.function.value, 60) << n.function.where;
    EXPECT_LE(n.structure.value, std::string(folder) == "scheduler" ? 25 : 70) << n.structure.where;
  }
  std::printf("%-14s %7d  lines of product code, without comments and blank lines\n", "", code);
}

TEST(House, FewFunctionsTakeTheWorld) {
  std::set<std::string> whole;
  static const std::regex taker(R"((\w+)\((const )?World& \w+)");
  for (const fs::path& path : sources("scheduler"))
    for (const std::string& line : lines_of(path))
      for (std::sregex_iterator m(line.begin(), line.end(), taker), none; m != none; ++m) whole.insert((*m)[1]);
  std::printf("functions that take the World: %zu\n", whole.size());
  if (std::getenv("TALUS_HOUSE") == nullptr) {
    EXPECT_LE(whole.size(), 60U);
  }
}

/// Only step/, view/, the benchmarks' access and Simulation see the whole.
TEST(House, OnlyStepAndViewSeeTheWorld) {
  for (const fs::path& path : sources("scheduler")) {
    const std::string name = fs::relative(path, root()).string();
    if (name.rfind("scheduler/step/", 0) == 0 || name.rfind("scheduler/view/", 0) == 0 ||
        name == "scheduler/simulation.cpp")
      continue;
    for (const std::string& line : lines_of(path)) EXPECT_EQ(line.find("step/world.hpp"), std::string::npos) << name;
  }
}

}  // namespace
