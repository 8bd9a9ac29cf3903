// Bad scenes: one message that says where and what is allowed, exit code 3, nothing left on disk. Each case is one
// mutation of a scene that runs.
#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {

struct BadScene {
  const char* name;
  const char* from;  ///< replaced in the good scene
  const char* to;
  std::vector<const char*> expected;  ///< parts of the message
};

// gtest would print addresses, which change from run to run and end up in ctest's names.
void PrintTo(const BadScene& bad, std::ostream* out) { *out << bad.name; }

const std::vector<BadScene> k_bad_scenes{
    {"UnknownKey", "friction = 0.5", "frictoin = 0.5", {"bad.toml:", "frictoin", "friction"}},
    {"UnknownSection", "[contact]", "[contcat]", {"bad.toml:", "contcat", "contact"}},
    {"WrongType", "steps = 400", "steps = \"many\"", {"bad.toml:11:", "steps"}},
    {"NotANumber", "step = 2e-5", "step = nan", {"bad.toml:10:", "step"}},
    {"Infinite", "density = 2500", "density = inf", {"bad.toml:", "density"}},
    {"NegativeDensity", "density = 2500", "density = -2500", {"bad.toml:", "density", "> 0"}},
    {"NegativeStiffness", "normal_stiffness = 2e4", "normal_stiffness = -1", {"bad.toml:", "normal_stiffness"}},
    {"RestitutionAboveOne", "restitution = 0.8", "restitution = 1.5", {"bad.toml:", "restitution", "1]"}},
    {"UnknownChoice", "model = \"linear\"", "model = \"linaer\"", {"bad.toml:", "linaer", "linear"}},
    {"UnknownMaterial", "material = \"glass\"", "material = \"gless\"", {"bad.toml:", "gless", "glass"}},
    {"MissingRequired", "step = 2e-5", "", {"step"}},
    {"EmptyBox", "upper = [0.1, 0.1, 0.2]", "upper = [0.1, 0.1, 0.0]", {"bad.toml:", "upper"}},
    {"NotToml", "[domain]", "[domain", {"bad.toml:"}},
    {"MissingMesh", "[output]", "[[wall]]\nshape = \"mesh\"\nfile = \"none.stl\"\n[output]", {"none.stl"}},
    {"PackDoesNotFit", "number = 200", "number = 200000", {"fit"}},
    {"SizeUpsideDown", "min = 0.006", "min = 0.06", {"bad.toml:", "m"}},
    {"UnstableStep", "step = 2e-5", "step = 2e-3", {"step"}},
    {"CornerBehindADerivedOne",
     "[output]",
     "[gas]\ncells = [2, 2, 4]\nlower = [0, 0.2, 0]\n[output]",
     {"gas.upper", "that of the domain", "larger than 'lower'"}},
    {"InletUnderAnother",
     "[output]",
     "[gas]\ncells = [2, 2, 4]\n[[gas.inlet]]\nside = \"bottom\"\nvelocity = 1\n"
     "[[gas.inlet]]\nside = \"bottom\"\nvelocity = 2\n[output]",
     {"gas.inlet 1", "no effect"}},
};

class BadScenes : public Cli, public ::testing::WithParamInterface<BadScene> {};

TEST_P(BadScenes, ExitWithThreeAndLeaveNothing) {
  const BadScene& bad = GetParam();
  write("bad.toml", replaced(small_scene(), bad.from, bad.to));
  for (const char* command : {"run", "check"}) {
    std::vector<std::string> arguments{command, "bad.toml"};
    if (std::string(command) == "run") arguments.insert(arguments.end(), {"--out", "out"});
    const Result r = talus(arguments);
    EXPECT_EQ(r.exit_code, 3) << command << ": " << r.err;
    EXPECT_EQ(r.err.rfind("talus: error: ", 0), 0u) << "one message and nothing before it: " << r.err;
    for (const char* part : bad.expected)
      EXPECT_NE(r.err.find(part), std::string::npos) << "'" << part << "' in: " << r.err;
  }
  EXPECT_FALSE(exists("out"));
  EXPECT_FALSE(exists("results"));
}

INSTANTIATE_TEST_SUITE_P(Cli, BadScenes, ::testing::ValuesIn(k_bad_scenes),
                         [](const auto& info) { return std::string(info.param.name); });

/// The small scene with particles from a CSV file.
std::string csv_scene() {
  std::string text = small_scene();
  const std::size_t from = text.find("kind = \"random\""), to = text.find("[output]");
  return text.replace(from, to - from, "kind = \"file\"\nfile = \"state.csv\"\n");
}

struct BadRow {
  const char* name;
  const char* rows;
  std::vector<const char*> expected;
};

void PrintTo(const BadRow& bad, std::ostream* out) { *out << bad.name; }

const std::vector<BadRow> k_bad_rows{
    {"OutsideTheDomain", "0.05,0.05,0.05,0.004,0,0,0\n0.05,0.05,0.5,0.004,0,0,0\n", {"state.csv:3"}},
    {"Overlapping", "0.05,0.05,0.05,0.004,0,0,0\n0.05,0.05,0.051,0.004,0,0,0\n", {"overlap"}},
    {"NegativeRadius", "0.05,0.05,0.05,0.004,0,0,0\n0.02,0.05,0.05,-0.004,0,0,0\n", {"state.csv:3"}},
    {"NotFinite", "0.05,0.05,0.05,0.004,0,0,0\n0.02,nan,0.05,0.004,0,0,0\n", {"state.csv:3"}},
    {"TooFewColumns", "0.05,0.05,0.05,0.004,0,0,0\n0.02,0.05\n", {"state.csv:3"}},
};

class BadRows : public Cli, public ::testing::WithParamInterface<BadRow> {};

TEST_P(BadRows, ExitWithThreeAndNameFileAndRow) {
  write("bad.toml", csv_scene());
  write("state.csv", std::string("x,y,z,radius,vx,vy,vz\n") + GetParam().rows);
  const Result r = talus({"run", "bad.toml", "--out", "out"});
  EXPECT_EQ(r.exit_code, 3) << r.err;
  for (const char* part : GetParam().expected)
    EXPECT_NE(r.err.find(part), std::string::npos) << part << " in: " << r.err;
  EXPECT_FALSE(exists("out"));
}

INSTANTIATE_TEST_SUITE_P(Cli, BadRows, ::testing::ValuesIn(k_bad_rows),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_F(Cli, TheGoodCsvSceneRuns) {
  // Without this the cases above could all fail for a reason that is not theirs.
  write("good.toml", csv_scene());
  write("state.csv", "x,y,z,radius,vx,vy,vz\n0.05,0.05,0.05,0.004,0,0,0\n0.05,0.05,0.06,0.004,0,0,0\n");
  const Result r = talus({"run", "good.toml", "--out", "out"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(json_value(read("out/summary.json"), "particles"), "2");
}

TEST_F(Cli, MissingSceneExitsWithThree) {
  const Result r = talus({"run", "nowhere.toml"});
  EXPECT_EQ(r.exit_code, 3) << r.err;
  EXPECT_NE(r.err.find("nowhere.toml"), std::string::npos) << r.err;
}

TEST_F(Cli, BadReplacementNamesTheOption) {
  write("scene.toml", small_scene());
  for (const char* set : {"contact.frictoin=0.5", "contact.friction=much", "contact.friction", "time.step=-1"}) {
    const Result r = talus({"run", "scene.toml", "--set", set, "--out", "out"});
    EXPECT_TRUE(r.exit_code == 2 || r.exit_code == 3) << set << r.err;
    EXPECT_NE(r.err.find(std::string(set).substr(0, std::string(set).find('='))), std::string::npos)
        << set << ": " << r.err;
  }
  EXPECT_FALSE(exists("out"));
}

TEST_F(Cli, UnstableStepRunsWhereTheSceneAllowsIt) {
  write("scene.toml", small_scene(1));
  EXPECT_EQ(talus({"check", "scene.toml", "--set", "time.step=2e-3"}).exit_code, 3);
  const Result r =
      talus({"check", "scene.toml", "--set", "time.step=2e-3", "--set", "checks.allow_unstable_step=true"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("warning"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace talus::test
