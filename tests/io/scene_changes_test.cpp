// What a resumed run may change: a rule for every key, a record that is a scene, comparisons by value.
#include "core/scene/scene_changes.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "core/scene/scene_keys.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

const char* const k_scene = R"(gravity = [0, 0, -9.81]
[domain]
lower = [0, 0, 0]
upper = [1, 1, 1]
[time]
step = 1e-5
duration = 1e-3
[[material]]
name = "a \"quoted\" name"
density = 2500
[contact]
normal_stiffness = 1e5
[[source]]
kind = "stream"
number_rate = 1000
interval = 0.01
region = { lower = [0.1, 0.1, 0.1], upper = [0.9, 0.9, 0.9] }
size = { diameter = 0.05 }
[[wall]]
name = "one"
shape = "plane"
[[wall]]
name = "two"
shape = "plane"
point = [0, 0, 0.5]
[wall.motion]
velocity = [1, 0, 0]
[list]
verlet_k = 100
)";

SceneText scene(const std::vector<std::string>& sets = {}) { return read_scene_text(k_scene, "test", ".", sets); }

std::vector<SceneChange> changes(const std::vector<std::string>& sets) {
  return scene_changes({{}, scene()}, scene(sets), 10);
}

TEST(SceneChanges, EveryKeyHasARule) {
  for (const SceneKey& k : scene_keys()) {
    const ResumeRule rule = resume_rule(k.section, k.name);
    EXPECT_EQ(rule.rule == AtResume::fixed, !rule.why.empty()) << full_name(k) << ": a refusal has a reason";
  }
}

TEST(SceneChanges, TheRecordOfASceneIsASceneWithTheSameState) {
  const SceneText whole = scene();
  const std::string text = scene_record(whole);
  const SceneText record = read_scene_text(text, "record", ".", {});
  EXPECT_EQ(scene_record(record), text);
  EXPECT_EQ(record.scene.materials[0].name, "a \"quoted\" name");
  ASSERT_EQ(record.scene.walls.size(), 2u);
  EXPECT_EQ(record.scene.walls[0].motion.velocity.x, 0);
  EXPECT_EQ(record.scene.walls[1].motion.velocity.x, 1);
  EXPECT_TRUE(scene_changes({record, {}}, whole, 10).empty());
  // What does not concern the state is no part of it: the same trajectory, the same bytes of a checkpoint.
  EXPECT_EQ(scene_record(scene({"list.verlet_k=20", "time.steps=7", "output.csv_every=1e-4"})), text);
  EXPECT_NE(scene_record(scene({"contact.normal_stiffness=2e5"})), text);
}

TEST(SceneChanges, EveryExampleOfAKeySurvivesTheRecord) {
  for (const SceneKey& k : scene_keys()) {
    const SceneText whole = read_scene_text(scene_key_example(k), full_name(k), ".", {});
    const SceneText record = read_scene_text(scene_record(whole), full_name(k), ".", {});
    for (const SceneChange& c : scene_changes({record, {}}, whole, 0))
      EXPECT_EQ(c.rule, AtResume::free) << full_name(k) << ": " << change_text(c);
  }
}

TEST(SceneChanges, ValuesAreComparedNotTheirSpelling) {
  EXPECT_TRUE(changes({}).empty());
  EXPECT_TRUE(changes({"contact.normal_stiffness=100000"}).empty());
  EXPECT_TRUE(changes({"gravity=[0, 0, -9.810]"}).empty());
  EXPECT_TRUE(changes({"seed=1"}).empty()) << "the default";
  EXPECT_TRUE(changes({"time.steps=100"}).empty()) << "the same duration";
}

TEST(SceneChanges, AreListedWithOldAndNewValueTheRefusedFirst) {
  const auto all = changes({"contact.normal_stiffness=2e5", "domain.upper=[1,1,2]", "time.steps=200"});
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(change_text(all[0]), "domain.upper: [1, 1, 1] -> [1, 1, 2]");
  EXPECT_EQ(all[0].rule, AtResume::fixed);
  EXPECT_EQ(change_text(all[1]), "contact.normal_stiffness: 100000 -> 200000");
  EXPECT_EQ(all[1].rule, AtResume::physics);
  EXPECT_EQ(change_text(all[2]), "time.steps: 100 -> 200");
  EXPECT_EQ(all[2].rule, AtResume::free);
}

TEST(SceneChanges, OnlyAStreamMayDeliverDifferently) {
  ASSERT_EQ(changes({"source.0.number_rate=2000"}).size(), 1u);
  EXPECT_EQ(changes({"source.0.number_rate=2000"})[0].rule, AtResume::physics);
  EXPECT_EQ(changes({"source.0.size.diameter=0.04"})[0].rule, AtResume::fixed);
  const std::vector<std::string> pack{"source.0.kind=random", "source.0.number=5"};
  std::string text = k_scene;
  for (const std::string line : {"number_rate = 1000\n", "interval = 0.01\n"}) text.erase(text.find(line), line.size());
  const SceneText before = read_scene_text(text, "test", ".", pack);
  const SceneText after = read_scene_text(text, "test", ".", {pack[0], "source.0.number=6"});
  const auto all = scene_changes({{}, before}, after, 10);
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].rule, AtResume::fixed);
}

/// In the middle of a heat step its sums belong to the length that it began with.
TEST(SceneChanges, HeatStepsGetAnotherLengthOnlyBetweenTwo) {
  const auto changed = [](int from, int to, std::int64_t step) {
    const auto heated = [](int every) {
      return scene({"heat.temperature=290", "heat.capacity=800", "heat.conductivity=0.2",
                    "heat.every=" + std::to_string(every)});
    };
    const std::vector<SceneChange> all = scene_changes({{}, heated(from)}, heated(to), step);
    EXPECT_EQ(all.size(), 1U);
    return all.at(0).rule;
  };
  EXPECT_EQ(changed(10, 5, 12), AtResume::fixed);
  EXPECT_EQ(changed(10, 20, 30), AtResume::fixed);
  EXPECT_EQ(changed(10, 5, 30), AtResume::physics);
  EXPECT_EQ(changed(10, 20, 40), AtResume::physics);
}

TEST(SceneChanges, GasStepsTooAndARefusalNamesTheStepThatAllowsIt) {
  const auto resumed = [](int from, int to, std::int64_t step) {
    const auto blown = [](int every) {
      const std::string n = std::to_string(every);
      return scene({"heat.temperature=290", "heat.capacity=800", "heat.conductivity=0.2", "heat.every=" + n,
                    "gas.cells=[1,1,1]", "gas.every=" + n});
    };
    return scene_changes({{}, blown(from)}, blown(to), step);
  };
  const std::vector<SceneChange> refused = resumed(320, 240, 1171616), allowed = resumed(320, 240, 1172160);
  EXPECT_EQ(refused.size(), 2U);
  EXPECT_EQ(allowed.size(), 2U);
  for (const SceneChange& c : refused) {
    EXPECT_EQ(c.rule, AtResume::fixed);
    EXPECT_NE(c.why.find("--steps 1172160"), std::string::npos) << c.why;
  }
  for (const SceneChange& c : allowed) EXPECT_EQ(c.rule, AtResume::physics);
}

TEST(SceneChanges, WallsAreKnownByNameAndShape) {
  const Scene before = scene().scene;
  EXPECT_TRUE(wall_numbers(before, scene({"wall.1.motion.velocity=[2,0,0]"}).scene).empty());
  Scene after = before;
  std::swap(after.walls[0], after.walls[1]);
  // two walls of the scene, then six sides of the domain
  EXPECT_EQ(wall_numbers(before, after), (std::vector<int>{1, 0, 2, 3, 4, 5, 6, 7}));
  after = before;
  after.walls.insert(after.walls.begin(), before.walls[0]);
  after.walls[0].name = "new";
  EXPECT_EQ(wall_numbers(before, after), (std::vector<int>{1, 2, 3, 4, 5, 6, 7, 8}));
  after = before;
  after.walls[0].point.z = 0.1;
  EXPECT_EQ(wall_numbers(before, after), (std::vector<int>{-1, 1, 2, 3, 4, 5, 6, 7}));
  after.walls.erase(after.walls.begin());
  EXPECT_EQ(wall_numbers(before, after), (std::vector<int>{-1, 0, 1, 2, 3, 4, 5, 6}));
}

TEST(SceneChanges, FilesThatHoldSomethingElseThanBeforeAreSaidOrRefused) {
  test::TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder / name) << text; };
  const std::string rod = "x,y,z,radius\n0,0,-0.01,0.01\n0,0,0.01,0.01\n";
  write("rod.csv", rod);
  write("wall.stl", "solid w");
  const std::string text = std::string(k_scene) +
                           "[[wall]]\nname = \"mesh\"\nshape = \"mesh\"\nfile = \"wall.stl\"\n"
                           "[[shape]]\nname = \"rod\"\nfile = \"rod.csv\"\n";
  const auto now = [&] { return read_scene_text(text, "test", folder.path(), {}); };
  const std::string record = scene_record(now());
  const SceneBefore before{read_scene_text(record, "record", ".", {}), {}, contents_in(record)};
  EXPECT_EQ(before.contents.size(), 2u);
  EXPECT_TRUE(scene_changes(before, now(), 10).empty());
  EXPECT_TRUE(wall_numbers(before.record->scene, now().scene, {}).empty());

  write("rod.csv", rod + "0,0,0,0.01\n");
  write("wall.stl", "solid v");
  const auto changes = scene_changes(before, now(), 10);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].path, "shape.0.file");
  EXPECT_EQ(changes[0].rule, AtResume::fixed);
  EXPECT_EQ(changes[1].path, "wall.2.file");
  EXPECT_EQ(changes[1].rule, AtResume::physics);
  EXPECT_NE(change_text(changes[1]).find("another content"), std::string::npos);
  EXPECT_EQ(wall_numbers(before.record->scene, now().scene, changes), (std::vector<int>{0, 1, -1, 3, 4, 5, 6, 7, 8}))
      << "contacts with another mesh begin anew";

  write("rod.csv", rod);
  write("wall.stl", "solid w");
  EXPECT_TRUE(scene_changes(before, now(), 10).empty());
}

}  // namespace
}  // namespace talus
