// Who may include what (the layering of the README): read from the sources themselves, so that a wrong include turns CI
// red. The scanner is tested first on made-up text; a scanner that sees nothing would let everything pass.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/layout/sources.hpp"

namespace talus::layout {
namespace {

struct Include {
  std::string file;    ///< relative to the repository
  std::string target;  ///< as written between the quotes or brackets
};

const std::vector<std::string> k_folders{"core", "kernels", "scheduler", "cases", "tests", "perf"};

std::string top_folder(const std::string& path) { return path.substr(0, path.find('/')); }

const std::vector<Include>& all_includes() {
  static const std::vector<Include> all = [] {
    std::vector<Include> list;
    for (const std::string& folder : k_folders) {
      for (const fs::path& file : sources_of(folder)) {
        const std::string name = name_of(file);
        for (const std::string& target : includes_in(read(file))) list.push_back({name, target});
      }
    }
    return list;
  }();
  return all;
}

bool starts_with_any(const std::string& s, const std::vector<std::string>& prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(), [&](const std::string& p) { return s.rfind(p, 0) == 0; });
}

/// Files below core, kernels, scheduler, cases that include something starting with one of the prefixes.
std::set<std::string> users_of(const std::vector<std::string>& prefixes) {
  std::set<std::string> files;
  for (const Include& i : all_includes()) {
    const std::string folder = top_folder(i.file);
    if (folder != "tests" && folder != "perf" && starts_with_any(i.target, prefixes)) files.insert(i.file);
  }
  return files;
}

std::string joined(const std::set<std::string>& names) {
  std::string s;
  for (const auto& n : names) s += n + " ";
  return s;
}

TEST(Includes, ScannerSeesEveryFormAndSkipsComments) {
  const auto found = includes_in(
      "#include <tbb/flow_graph.h>\n  #  include \"core/base/types.hpp\"\n// #include <no>\nint x;\n#include<y.h>");
  EXPECT_EQ(found, (std::vector<std::string>{"tbb/flow_graph.h", "core/base/types.hpp", "y.h"}));
  EXPECT_GT(all_includes().size(), 100u) << "the source tree was not found below " << TALUS_SOURCE_DIR;
}

TEST(Includes, FoldersDependInOneDirectionOnly) {
  const std::map<std::string, std::set<std::string>> allowed{
      {"core", {"core"}},
      {"kernels", {"core", "kernels"}},
      {"scheduler", {"core", "kernels", "scheduler"}},
      {"cases", {"core", "scheduler", "cases"}},
  };
  for (const Include& i : all_includes()) {
    const auto rule = allowed.find(top_folder(i.file));
    const std::string target = top_folder(i.target);
    const bool ours = i.target.find('/') != std::string::npos &&
                      std::find(k_folders.begin(), k_folders.end(), target) != k_folders.end();
    if (rule == allowed.end() || !ours) continue;
    EXPECT_TRUE(rule->second.count(target)) << i.file << " includes " << i.target;
  }
}

TEST(Includes, TbbOnlyInScheduler) {
  const auto users = users_of({"tbb/", "oneapi/tbb"});
  EXPECT_FALSE(users.empty());
  for (const auto& file : users) EXPECT_EQ(top_folder(file), "scheduler") << file;
}

TEST(Includes, XsimdOnlyInKernels) {
  const auto users = users_of({"xsimd/"});
  EXPECT_FALSE(users.empty());
  for (const auto& file : users) EXPECT_EQ(top_folder(file), "kernels") << file;
}

TEST(Includes, HeavyReadersAreInOneTranslationUnitEach) {
  const std::map<std::string, std::vector<std::string>> libraries{{"toml++", {"toml++/", "toml.hpp"}},
                                                                  {"HDF5", {"hdf5", "H5"}}};
  for (const auto& [name, prefixes] : libraries) {
    auto users = users_of(prefixes);
    EXPECT_FALSE(users.empty()) << name;
    // headers that only the files of VTKHDF include (below)
    std::erase_if(users, [](const std::string& file) { return file.rfind("core/io/hdf5_", 0) == 0; });
    EXPECT_LE(users.size(), 1u) << name << ": " << joined(users);
    for (const auto& file : users) {
      EXPECT_EQ(top_folder(file), "core") << name << ": " << file;
      EXPECT_EQ(fs::path(file).extension(), ".cpp") << name << " in a header reaches other units: " << file;
    }
  }
}

TEST(Includes, HeadersWithHdf5ReachItsFilesOnly) {
  for (const auto& file : users_of({"core/io/hdf5_"}))
    EXPECT_TRUE(file.rfind("core/io/vtkhdf", 0) == 0 || file.rfind("core/io/hdf5_", 0) == 0) << file;
}

TEST(Includes, CliParserOnlyInTheProgram) {
  EXPECT_EQ(users_of({"CLI/"}), (std::set<std::string>{"cases/program/talus.cpp"}));
}

TEST(Includes, NoEigenInInstructionSetUnits) {
  // Inline functions of Eigen compiled for AVX-512 could be the ones that the linker keeps for every caller.
  for (const auto& file : users_of({"Eigen/"})) EXPECT_NE(top_folder(file), "kernels") << file;
}

TEST(Sources, EveryHeaderHasPragmaOnceAndEveryFileAHeadComment) {
  for (const std::string& folder : k_folders) {
    for (const fs::path& file : sources_of(folder)) {
      const std::string text = read(file);
      EXPECT_EQ(text.rfind("//", 0), 0u) << file << " does not start with its purpose";
      if (file.extension() == ".hpp") {
        EXPECT_NE(text.find("#pragma once"), std::string::npos) << file;
      }
    }
  }
}

TEST(Sources, NoLibraryRandomNumbersAndNoLibmInKernels) {
  // I4: these change with the C library or the instruction set. Set-up uses core/base/det_math.hpp and
  // core/base/rng.hpp.
  for (const std::string folder : {"core", "kernels", "scheduler"}) {
    for (const fs::path& file : sources_of(folder)) {
      const std::string text = read(file);
      for (const char* word : {"_distribution<", "std::mt19937", "random_device"}) {
        EXPECT_EQ(text.find(word), std::string::npos) << file << " uses " << word;
      }
      if (folder != "kernels") continue;
      for (const char* word : {"std::exp(", "std::log(", "std::sin(", "std::cos(", "std::pow(", "std::fma(",
                               "std::floor(", "std::round(", "std::unordered_"}) {
        EXPECT_EQ(text.find(word), std::string::npos) << file << " uses " << word;
      }
    }
  }
}

TEST(Sources, BuildForbidsContractionAndFastMath) {
  const std::string build = read(fs::path(TALUS_SOURCE_DIR) / "CMakeLists.txt");
  EXPECT_NE(build.find("-ffp-contract=off"), std::string::npos);
  EXPECT_EQ(build.find("-ffast-math"), std::string::npos);
  EXPECT_EQ(build.find("-Ofast"), std::string::npos);
}

/// Targets of links and pictures in a page, without those to the web and within the page.
std::vector<std::string> links_in(const std::string& text) {
  std::vector<std::string> found;
  for (std::size_t at = text.find("]("); at != std::string::npos; at = text.find("](", at + 1)) {
    const std::string target = text.substr(at + 2, text.find(')', at) - at - 2);
    if (!target.empty() && target[0] != '#' && target.find("://") == std::string::npos)
      found.push_back(target.substr(0, target.find('#')));
  }
  return found;
}

TEST(Pages, LinksLeadSomewhereAndPicturesAreSmall) {
  EXPECT_EQ(links_in("[a](b.md#c) ![d](e.png) [f](#g) [h](https://i.org)"),
            (std::vector<std::string>{"b.md", "e.png"}));
  std::size_t pictures = 0;
  std::vector<fs::path> pages{fs::path(TALUS_SOURCE_DIR) / "README.md"};
  for (const char* folder : {"core", "kernels", "scheduler", "cases", "tests", "perf", ".github"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(TALUS_SOURCE_DIR) / folder))
      if (entry.path().extension() == ".md") pages.push_back(entry.path());
  for (const fs::path& page : pages)
    for (const std::string& target : links_in(read(page))) {
      const fs::path to = page.parent_path() / target;
      EXPECT_TRUE(fs::exists(to)) << page << " names " << target;
      if (to.extension() != ".png" || !fs::exists(to)) continue;
      ++pictures;
      EXPECT_LE(fs::file_size(to), 200000u) << to;
    }
  EXPECT_GT(pictures, 12u);
}

TEST(Pages, TheReadmeShowsTheResultsOfPerf) {
  EXPECT_EQ(std::system("PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 " TALUS_SOURCE_DIR "/perf/readme_table.py --check"),
            0);
}

TEST(Layout, NothingUnexpectedAtTheTop) {
  const std::set<std::string> allowed{"CMakeLists.txt", "README.md", "LICENSE", "core", "kernels",
                                      "scheduler",      "cases",     "tests",   "perf", "results"};
  for (const auto& entry : fs::directory_iterator(TALUS_SOURCE_DIR)) {
    const std::string name = entry.path().filename().string();
    if (name[0] == '.' || name.rfind("build", 0) == 0) continue;  // git's own, and build folders
    EXPECT_TRUE(allowed.count(name)) << name;
  }
}

}  // namespace
}  // namespace talus::layout
