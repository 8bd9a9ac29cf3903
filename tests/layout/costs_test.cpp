// What it costs to add one more of a kind, by examples that are there: where a thing is named beside its own line, the
// next one has to be named there, too.
#include <gtest/gtest.h>

#include "core/scene/key.hpp"
#include "core/scene/scene.hpp"
#include "tests/layout/sources.hpp"

namespace talus::layout {
namespace {

std::string joined(const auto& names) {
  std::string s;
  for (const std::string& n : names) s += n + " ";
  return s;
}

/// Folders of files, as "core/scene/sections".
std::set<std::string> folders_of(const std::set<std::string>& files) {
  std::set<std::string> folders;
  for (const std::string& f : files) folders.insert(fs::path(f).parent_path().string());
  return folders;
}

// A key of a scene: a member of scene.hpp and one line in core/scene/sections.
TEST(Cost, OfAKeyIsOneLine) {
  for (const char* key : {"onset_correction", "lever", "warn_travel", "velocity_jitter", "rotation_rate",
                          "uniform_skin", "viscous", "closed_walls", "stddev"}) {
    const auto lines = lines_with("\"" + std::string(key) + "\"");
    EXPECT_EQ(lines.size(), 1u) << key << " stands at " << joined(lines);
    EXPECT_EQ(folders_of(files_with("\"" + std::string(key) + "\"")), std::set<std::string>{"core/scene/sections"});
  }
}

TALUS_WORDS(Pace, slow, quick)
struct Example {
  double mass = 2.5;
  Pace pace = Pace::quick;
  Vec3 place{0, 1, 0};
  bool held = true;
};

TEST(Cost, OfAKeyIsOneLineThatSaysAllThatHelpAndChecksNeed) {
  const Keys<Example> keys({"example", false, "an example"}, k_free,
                           {
                               key("mass", &Example::mass, "kg", k_positive, "how heavy", "3").fixed("it is stored"),
                               key("pace", &Example::pace, "how fast", "\"slow\"").also({"speed"}),
                               key("place", &Example::place, "m", k_finite, "where", "[1, 2, 3]"),
                               key("held", &Example::held, "whether", "false").required(),
                           });
  const std::vector<SceneKey>& rows = keys.rows();
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].type, KeyType::number);
  EXPECT_EQ(rows[0].fallback, "2.5");
  EXPECT_EQ(allowed_text(rows[0]), "a number > 0 [kg]");
  EXPECT_EQ(rows[0].resume.rule, AtResume::fixed);
  EXPECT_EQ(rows[1].fallback, "\"quick\"");
  EXPECT_EQ(allowed_text(rows[1]), "one of slow, quick");
  EXPECT_EQ(rows[1].resume.rule, AtResume::free);
  EXPECT_EQ(rows[1].also.at(0).word, "speed");
  EXPECT_EQ(rows[2].fallback, "[0, 1, 0]");
  EXPECT_TRUE(rows[3].required());
  EXPECT_EQ(full_name(rows[3]), "example.held");
}

// An output quantity: its line, and where it is new data the member that holds it.
TEST(Cost, OfAQuantityIsOneLine) {
  for (const char* quantity : {"tangential_force", "granular_temperature", "solid_fraction", "dissipated_friction",
                               "balance_residual", "plane.<plane>.mass_flow"}) {
    const auto lines = lines_with("\"" + std::string(quantity) + "\"");
    EXPECT_EQ(lines.size(), 1u) << quantity << " stands at " << joined(lines);
  }
}

// A wall shape: its word in WallShape, its keys, its file in core/walls/shapes and its line in shapes.cpp.
TEST(Cost, OfAWallShapeIsAFileAndALine) {
  for (const char* shape : {"plane", "cylinder", "cone", "box", "mesh"}) {
    const std::string name(shape);
    EXPECT_EQ(files_with("WallShape::" + name + ","), (std::set<std::string>{"core/walls/shapes/" + name + ".cpp"}))
        << joined(lines_with("WallShape::" + name));
    EXPECT_EQ(files_with("k_" + name + "_shape"),
              (std::set<std::string>{"core/walls/shapes/" + name + ".cpp", "core/walls/shapes/shape.hpp",
                                     "core/walls/shapes/shapes.cpp"}));
  }
  for (const std::string& folder : folders_of(files_with("WallShape::")))
    EXPECT_TRUE(folder == "core/walls/shapes" || folder == "core/scene/sections" || folder == "core/scene") << folder;
}

// A contact law is a header in kernels/models and its line in the list of kernel_table.cpp, as long as it belongs to
// the families that are there: what asks whether a law is linear has to learn of a third one. The number may fall,
// never rise.
TEST(Cost, OfAContactLawDoesNotRise) {
  const auto files = files_with("ContactModel::linear");
  EXPECT_LE(files.size(), 9u) << joined(files);
}

// A list policy is not yet a line: these are the files that name one. The number may fall, never rise.
TEST(Cost, OfAListPolicyDoesNotRise) {
  const auto files = files_with("ListPolicy::outer_inner");
  EXPECT_LE(files.size(), 2u) << joined(files);
}

}  // namespace
}  // namespace talus::layout
