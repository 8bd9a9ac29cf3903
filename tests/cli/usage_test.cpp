// The command line itself: exit codes of wrong usage, help, commands that need no engine.
#include <cstdlib>

#include "core/io/scene_keys.hpp"
#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {

TEST_F(Cli, WrongUsageExitsWithTwo) {
  write("scene.toml", small_scene());
  const std::vector<std::vector<std::string>> wrong{
      {},
      {"fly"},
      {"run"},
      {"run", "scene.toml", "--no-such-option"},
      {"run", "scene.toml", "--threads", "-1"},
      {"run", "scene.toml", "--threads", "many"},
      {"run", "scene.toml", "--isa", "avx1024"},
      {"run", "scene.toml", "--verlet-k", "-3"},
      {"run", "scene.toml", "--steps", "1.5"},
      {"compare", "one"},
      {"help", "no_such_topic"},
      {"help", "scene", "contact.frictoin"},
  };
  for (const auto& arguments : wrong) {
    const Result r = talus(arguments);
    EXPECT_EQ(r.exit_code, 2) << (arguments.empty() ? "(nothing)" : arguments.back()) << "\n" << r.err;
    EXPECT_FALSE(r.err.empty() && r.out.empty());
  }
  EXPECT_FALSE(exists("results")) << "a refused command must not leave a folder behind";
}

TEST_F(Cli, WrongInstructionSetNamesTheAllowedOnes) {
  write("scene.toml", small_scene());
  const Result r = talus({"run", "scene.toml", "--isa", "avx1024"});
  for (const char* name : {"scalar", "sse2", "avx2", "avx512"}) EXPECT_NE(r.err.find(name), std::string::npos) << r.err;
}

TEST_F(Cli, HelpAndVersionExitWithZero) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--help"}, {"help"}, {"help", "run"}, {"run", "--help"}, {"help", "scene"}, {"help", "scene", "contact"}}) {
    const Result r = talus(arguments);
    EXPECT_EQ(r.exit_code, 0) << arguments.back() << r.err;
    EXPECT_FALSE(r.out.empty());
  }
  EXPECT_EQ(talus({"--version"}).out.rfind("talus ", 0), 0u);
}

TEST_F(Cli, HelpSceneNamesEveryKeyOfTheParser) {
  const Result all = talus({"help", "scene"});
  ASSERT_GT(scene_keys().size(), 50u);
  for (const SceneKey& key : scene_keys()) {
    const std::string name = full_name(key);
    EXPECT_NE(all.out.find(name), std::string::npos) << name;
  }
  const Result one = talus({"help", "scene", "contact.friction"});
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_NE(one.out.find("Coulomb"), std::string::npos) << one.out;
}

TEST_F(Cli, HelpSceneNamesTheNearestKey) {
  const Result r = talus({"help", "scene", "contact.frictoin"});
  EXPECT_NE(r.err.find("contact.friction"), std::string::npos) << r.err;
}

TEST_F(Cli, MissingAndForeignFilesExitWithFive) {
  write("text.txt", "not a checkpoint");
  EXPECT_EQ(talus({"info", "nowhere"}).exit_code, 5);
  EXPECT_EQ(talus({"info", "text.txt"}).exit_code, 5);
  EXPECT_EQ(talus({"compare", "nowhere", "text.txt"}).exit_code, 5);
  EXPECT_EQ(talus({"report", "nowhere"}).exit_code, 5);
  const Result r = talus({"report", "."});
  EXPECT_EQ(r.exit_code, 5);
  EXPECT_NE(r.err.find("summary.json"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace talus::test
