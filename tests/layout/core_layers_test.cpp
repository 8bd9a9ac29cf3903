// The order of core's folders (core/README.md): a file may include what stands before it, and no two headers include
// each other.
#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "tests/layout/sources.hpp"

namespace talus::layout {
namespace {

/// Place of a file of core in the order; files of one place may include each other.
int place_of(const std::string& file) {
  // plain data that everything is about, though it lies with the sections that fill it
  for (const char* data : {"core/scene/scene.hpp", "core/scene/scene.cpp", "core/scene/duration.hpp",
                           "core/scene/conversion.hpp", "core/scene/gas_settings.hpp", "core/scene/heat.hpp"})
    if (file == data) return 1;
  static const std::vector<std::string> order{"base",   "",      "heat",  "gas",   "meshes", "tables",     "walls", "shapes",
                                              "grains", "rules", "frame", "scene",  "conversion", "io"};
  const std::string folder = file.substr(5, file.find('/', 5) - 5);
  const auto at = std::find(order.begin(), order.end(), folder);
  return at == order.end() ? -1 : static_cast<int>(at - order.begin());
}

TEST(CoreLayers, EachFolderIncludesOnlyWhatStandsBeforeIt) {
  int looked_at = 0;
  for (const fs::path& file : sources_of("core")) {
    const std::string name = name_of(file);
    ASSERT_GE(place_of(name), 0) << name << " lies in a folder without a place";
    for (const std::string& target : includes_in(read(file))) {
      if (target.rfind("core/", 0) != 0) continue;
      ++looked_at;
      EXPECT_LE(place_of(target), place_of(name)) << name << " includes " << target;
    }
  }
  EXPECT_GT(looked_at, 200);
}

TEST(CoreLayers, KernelsSeeOnlyDataAndRulesOfCore) {
  for (const fs::path& file : sources_of("kernels"))
    for (const std::string& target : includes_in(read(file))) {
      if (target.rfind("core/", 0) != 0) continue;
      EXPECT_TRUE(place_of(target) <= 2 || target.rfind("core/rules/", 0) == 0 ||
                  target.rfind("core/shapes/", 0) == 0 || target.rfind("core/conversion/bed_", 0) == 0)
          << name_of(file) << " includes " << target;
    }
}

TEST(Includes, NoHeaderIncludesItselfRoundAbout) {
  std::map<std::string, std::vector<std::string>> graph;
  for (const char* folder : {"core", "kernels", "scheduler", "cases/program"})
    for (const fs::path& file : sources_of(folder)) graph[name_of(file)] = includes_in(read(file));
  std::map<std::string, int> state;  // 1: being visited, 2: done
  std::string circle;
  const std::function<void(const std::string&, const std::string&)> visit = [&](const std::string& file,
                                                                                const std::string& path) {
    if (state[file] == 2 || graph.count(file) == 0) return;
    if (state[file] == 1) {
      circle += path + file + "\n";
      return;
    }
    state[file] = 1;
    for (const std::string& next : graph[file]) visit(next, path + file + " -> ");
    state[file] = 2;
  };
  for (const auto& [file, includes] : graph) visit(file, "");
  EXPECT_EQ(circle, "");
  EXPECT_GT(graph.size(), 150u);
}

}  // namespace
}  // namespace talus::layout
