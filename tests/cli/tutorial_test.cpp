// The lessons of cases/tutorial, run small: every scene is valid without a warning, and what their pages say can be
// done.
#include <cmath>
#include <cstdlib>

#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {
namespace fs = std::filesystem;

const fs::path k_tutorial = fs::path(TALUS_SOURCE_DIR) / "cases" / "tutorial";

class Tutorial : public Cli {
 protected:
  Result run(const std::string& lesson, const std::string& steps, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"run", (k_tutorial / lesson / "scene.toml").string(), "--out", lesson, "--steps",
                                   steps};
    words.insert(words.end(), more.begin(), more.end());
    return talus(words);
  }
  int python(const std::string& script) {
    return std::system(("cd '" + folder.string() + "' && PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 " +
                        (k_tutorial / script).string() + " > log 2>&1")
                           .c_str());
  }
};

TEST_F(Tutorial, EveryLessonRunsWithoutAWarning) {
  for (const char* lesson : {"1-box", "2-material", "3-drum", "4-mesh", "6-plot", "7-repose"}) {
    const Result r = run(lesson, "600");
    EXPECT_EQ(r.exit_code, 0) << lesson << r.err;
    EXPECT_EQ(r.err.find("warning"), std::string::npos) << lesson << r.err;
    EXPECT_EQ(r.err.find("note"), std::string::npos) << lesson << r.err;
    EXPECT_TRUE(fs::exists(k_tutorial / lesson / "README.md")) << lesson;
    EXPECT_TRUE(fs::exists(k_tutorial / lesson / "picture.png")) << lesson;
    if (fs::exists(k_tutorial / lesson / "picture.png")) {
      EXPECT_LE(fs::file_size(k_tutorial / lesson / "picture.png"), 200000u) << lesson;
    }
  }
}

TEST_F(Tutorial, FurtherScenesRunWithoutAWarning) {
  for (const char* name : {"collapse", "oedometer", "vibrated-box"}) {
    const std::string scene = (k_tutorial / "further" / (std::string(name) + ".toml")).string();
    const Result r = talus({"run", scene, "--out", name, "--steps", "600"});
    EXPECT_EQ(r.exit_code, 0) << name << r.err;
    EXPECT_EQ(r.err.find("warning"), std::string::npos) << name << r.err;
    EXPECT_EQ(r.err.find("note"), std::string::npos) << name << r.err;
    ASSERT_TRUE(fs::exists(k_tutorial / "further" / (std::string(name) + ".png"))) << name;
    EXPECT_LE(fs::file_size(k_tutorial / "further" / (std::string(name) + ".png")), 200000u) << name;
  }
}

TEST_F(Tutorial, RestartGoesOnWithTheSameBitsAndStartsANewScene) {
  const std::string scene = (k_tutorial / "3-drum" / "scene.toml").string();
  ASSERT_EQ(run("3-drum", "900").exit_code, 0);
  ASSERT_EQ(talus({"run", scene, "--out", "parts", "--steps", "400"}).exit_code, 0);
  ASSERT_EQ(talus({"run", scene, "--resume", "parts", "--steps", "900"}).exit_code, 0);
  EXPECT_EQ(talus({"compare", "3-drum", "parts"}).exit_code, 0);
  const Result faster =
      talus({"run", scene, "--resume", "parts", "--steps", "950", "--set", "wall.0.motion.rotation_rate=6"});
  EXPECT_EQ(faster.exit_code, 0);
  EXPECT_NE(faster.err.find("wall.0.motion.rotation_rate: 3 -> 6"), std::string::npos) << faster.err;
  fs::copy_file(k_tutorial / "5-restart" / "scene.toml", folder / "next.toml");
  ASSERT_EQ(talus({"convert", "3-drum", "state.csv"}).exit_code, 0);
  const Result next = talus({"run", "next.toml", "--out", "next", "--steps", "100"});
  EXPECT_EQ(next.exit_code, 0) << next.err;
}

TEST_F(Tutorial, ThePlotIsMadeFromTheFilesOfTheRun) {
  ASSERT_EQ(run("6-plot", "4000").exit_code, 0);
  ASSERT_EQ(python("6-plot/plot.py 6-plot --out plot.png"), 0) << read("log");
  EXPECT_EQ(read("plot.png").substr(1, 3), "PNG");
}

TEST_F(Tutorial, TheAngleOfAConeOfGrainsIsFound) {
  // 30 degrees: grains on the surface and below of a cone of height 0.05
  std::string csv = "x,y,z,radius\n";
  const double slope = std::tan(30 * 3.14159265358979323846 / 180), step = 0.004;
  for (int i = -22; i <= 22; ++i)
    for (int j = -22; j <= 22; ++j) {
      const double x = i * step, y = j * step, top = 0.05 - slope * std::hypot(x, y);
      for (double z = top - 0.002; z > 0; z -= step)
        csv += std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(z) + ",0.002\n";
    }
  write("cone.csv", csv);
  ASSERT_EQ(talus({"convert", "cone.csv", "particles.pvd"}).exit_code, 0);
  ASSERT_EQ(python("7-repose/repose.py ."), 0) << read("log");
  const std::string log = read("log");
  const double angle = std::stod(log.substr(log.find("repose ") + 7));
  EXPECT_NEAR(angle, 30, 2) << log;
}

}  // namespace
}  // namespace talus::test
