// The command line itself: exit codes of wrong usage, help, commands that need no engine.
#include <algorithm>
#include <cstdlib>

#include "core/scene/scene_keys.hpp"
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
      {"run", "scene.toml", "--verlet-k", "nan"},
      {"check", "scene.toml", "--calibrate", "nan"},
      {"shape", "mesh.stl", "--spheres", "3", "--scale", "nan"},
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
  EXPECT_EQ(talus({"help", "contact.friction"}).out, one.out) << "'scene' may be left out";
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_NE(one.out.find("Coulomb"), std::string::npos) << one.out;
}

TEST_F(Cli, HelpSceneNamesTheNearestKey) {
  const Result r = talus({"help", "scene", "contact.frictoin"});
  EXPECT_NE(r.err.find("contact.friction"), std::string::npos) << r.err;
}

TEST_F(Cli, WrongNamesAreAnsweredWithWhatWasMeantInOneLine) {
  write("scene.toml", small_scene());
  const std::vector<std::pair<std::vector<std::string>, std::string>> meant{
      {{"runn", "scene.toml"}, "'run'"},
      {{"chekc", "scene.toml"}, "'check'"},
      {{"scene.toml"}, "talus run scene.toml"},
      {{}, "run, check, explain"},
      {{"run", "scene.toml", "--thread", "2"}, "'--threads'"},
      {{"run", "scene.toml", "--thraeds=2"}, "'--threads'"},
      {{"run", "scene.toml", "--output", "x"}, "'--out'"},
      {{"run", "scene.toml", "--every", "4"}, "'--checkpoint-every'"},
      {{"check", "scene.toml", "--resume", "x"}, "an option of run"},
      {{"run", "scene.toml", "--friction", "0.5"}, "--set contact.friction=VALUE"},
      {{"run", "scene.toml", "--gravity=0"}, "--set gravity=VALUE"},
      {{"--threads", "2", "run", "scene.toml"}, "before the command"},
      {{"help", "runn"}, "'run'"},
      {{"help", "scene", "size.radius"}, "'source.size.diameter'"},
      {{"run", "scene.toml", "--set", "friction=0.5"}, "'contact.friction'"},
      {{"run", "scene.toml", "--set", "contct.friction=0.5"}, "'contact.friction'"},
      {{"run", "scene.toml", "--set", "size.radius=0.5"}, "'source.0.size.diameter'"},
      {{"run", "scene.toml", "--set", "time.dt=1e-5"}, "'time.step'"},
  };
  for (const auto& [arguments, expected] : meant) {
    const Result r = talus(arguments);
    const std::string all = arguments.empty() ? "(nothing)" : arguments.back();
    EXPECT_TRUE(r.exit_code == 2 || r.exit_code == 3) << all << r.err;
    EXPECT_NE(r.err.find(expected), std::string::npos) << all << ": " << r.err;
    EXPECT_EQ(r.err.rfind("talus: error: ", 0), 0u) << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    EXPECT_EQ(r.out, "");
  }
  const Result all = talus({"help", "scene", "friction"});
  EXPECT_EQ(all.exit_code, 0);
  for (const char* name : {"contact.friction", "pair.friction"}) EXPECT_NE(all.out.find(name), std::string::npos);
}

TEST_F(Cli, HelpOnAWordThatIsNoKeyNamesTheKeysThatAreAboutIt) {
  const std::vector<std::pair<std::string, std::string>> about{
      {"clump", "shape.spheres"},          {"clumps", "shape.spheres"}, {"region", "source.region.radius"},
      {"superquadric", "shape.semi_axes"}, {"Hertz", "contact.model"},  {"shape", "help scene shape"}};
  for (const auto& [word, key] : about) {
    const Result r = talus({"help", word});
    EXPECT_EQ(r.exit_code, 0) << word << r.err;
    EXPECT_NE(r.out.find(key), std::string::npos) << word << ": " << r.out;
  }
  // part of a word, a misspelt key, several words: no search
  for (const char* word : {"clum", "frictoin", "wheel of fortune"})
    EXPECT_EQ(talus({"help", word}).exit_code, 2) << word;
}

TEST_F(Cli, ForgottenThingsAreSaidOnceByRunAndCheckAndZeroIsMeant) {
  const std::string whole = replaced(small_scene(20), "gravity = [0, 0, -9.81]\n", "");
  write("scene.toml", replaced(replaced(whole, "friction = 0.5\n", ""), "restitution = 0.8\n", ""));
  const Result run = talus({"run", "scene.toml", "--out", "out"}), check = talus({"check", "scene.toml"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const std::string& err : {run.err, check.err})
    for (const char* what : {"no gravity", "no friction", "no restitution"}) {
      const std::size_t at = err.find(what);
      EXPECT_NE(at, std::string::npos) << what << err;
      EXPECT_EQ(err.find(what, at + 1), std::string::npos) << what << " once: " << err;
    }
  EXPECT_EQ(talus({"run", "scene.toml", "--out", "quiet", "--quiet"}).err, "");
  const Result meant = talus({"check", "scene.toml", "--set", "gravity=[0,0,0]", "--set", "contact.friction=none",
                              "--set", "contact.restitution=1"});
  EXPECT_EQ(meant.err.find("note:"), std::string::npos) << meant.err;
  const Result resumed = talus({"run", "scene.toml", "--resume", "out", "--steps", "410"});
  EXPECT_EQ(resumed.err.find("note:"), std::string::npos) << "it was said: " << resumed.err;
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
