// An installed copy: complete, and at work from wherever it was moved to.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {
namespace fs = std::filesystem;

class Install : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    const fs::path build = fs::path(TALUS_BINARY).parent_path();
    ASSERT_EQ(shell("cmake --install '" + build.string() + "' --prefix first"), 0) << read("log");
    fs::rename(folder / "first", folder / "moved");
  }
  int shell(const std::string& command) {
    const int status =
        std::system(("cd '" + folder.string() + "' && unset TALUS_SHARE && (" + command + ") > log 2>&1").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
};

TEST_F(Install, HoldsProgramLibrariesScriptsCasesAndTexts) {
  for (const char* name : {"bin/talus", "include/talus/core/scene/scene.hpp", "include/talus/scheduler/simulation.hpp",
                           "share/talus/perf/report.py", "share/talus/cases/frames.py", "share/talus/cases/draw.py",
                           "share/talus/cases/tutorial/1-box/scene.toml", "share/talus/cases/tutorial/4-mesh/blade.obj",
                           "share/talus/cases/hopper/meshes/cone-silo.stl", "share/man/man1/talus.1",
                           "share/bash-completion/completions/talus", "share/zsh/vendor-completions/_talus"})
    EXPECT_TRUE(exists(std::string("moved/") + name)) << name;
  std::size_t found = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "moved"))
    found += entry.path().filename() == "TalusConfig.cmake" || entry.path().filename() == "libtalus_core.a";
  EXPECT_EQ(found, 2u);
}

TEST_F(Install, AMovedProgramFindsItsParts) {
  write("scene.toml", small_scene(30));
  ASSERT_EQ(shell("moved/bin/talus run scene.toml --out out --quiet --steps 100 && moved/bin/talus report out"), 0)
      << read("log");
  EXPECT_TRUE(exists("out/report.html"));
  ASSERT_EQ(shell("moved/bin/talus check moved/share/talus/cases/tutorial/4-mesh/scene.toml --calibrate 0"), 0)
      << read("log");
  // without its share it falls back to the sources that it was built from; a folder that is named counts alone
  ASSERT_EQ(shell("TALUS_SHARE=nowhere moved/bin/talus report out"), 5);
  EXPECT_NE(read("log").find("perf/report.py"), std::string::npos) << read("log");
}

TEST_F(Install, CompletionsKnowCommandsOptionsKeysAndTopics) {
  const auto completed = [&](const std::string& words) {
    std::string line = "COMP_WORDS=(" + words + ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n";
    write("complete.sh",
          "source moved/share/bash-completion/completions/talus\n" + line + "_talus\necho \"${COMPREPLY[*]}\"\n");
    EXPECT_EQ(shell("bash complete.sh"), 0) << read("log");
    std::string text = read("log");
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
  };
  EXPECT_EQ(completed("talus ru"), "run");
  EXPECT_EQ(completed("talus run --thr"), "--threads");
  EXPECT_EQ(completed("talus check --resu"), "") << "an option of run alone";
  EXPECT_EQ(completed("talus run x.toml --set contact.frict"), "contact.friction= contact.friction_limit=");
  EXPECT_EQ(completed("talus run x.toml --set source.0.size.dia"), "source.0.size.diameter=");
  EXPECT_EQ(completed("talus run --isa avx5"), "avx512");
  EXPECT_EQ(completed("talus help outp"), "output");
  write("my-scene.toml", "");
  EXPECT_EQ(completed("talus run my-sc"), "my-scene.toml");
}

TEST_F(Install, ZshCompletesCommandsOptionsKeysAndTopics) {
  ASSERT_EQ(shell("command -v zsh"), 0) << "zsh is among the packages of cases/install.sh";
  ASSERT_EQ(shell("/usr/bin/python3 " TALUS_SOURCE_DIR "/tests/cli/zsh_complete.py moved/share/zsh/vendor-completions "
                  "'talus ru' 'talus run --thr' 'talus check --resu' 'talus run x.toml --set source.0.size.dia' "
                  "'talus run x.toml --set contact.fric' 'talus run --isa avx5' 'talus help outp'"),
            0)
      << read("log");
  EXPECT_EQ(read("log"),
            "talus run \ntalus run --threads \ntalus check --resu\ntalus run x.toml --set source.0.size.diameter=\n"
            "talus run x.toml --set contact.friction\ntalus run --isa avx512 \ntalus help output \n");
}

TEST_F(Cli, TheReferenceHasEveryKeyColumnFileAndCommand) {
  const std::string text = talus({"help", "reference"}).out, man = talus({"help", "man"}).out;
  ASSERT_EQ(talus({"help", "output"}).exit_code, 0);
  for (const char* word : {"`friction`", "wall.<wall>.force_{x,y,z}", "checkpoint-<N>.tcp", "`talus convert`",
                           "--overwrite", "kinetic_energy", "| 4 |", "`omega`", "`particle_b`"})
    EXPECT_NE(text.find(word), std::string::npos) << word;
  for (const char* word : {".SH EXIT STATUS", "talus convert", "TALUS_SHARE"})
    EXPECT_NE(man.find(word), std::string::npos) << word;
  // every row of a table has as many cells as its header
  std::size_t cells = 0;
  std::string line;
  for (std::istringstream lines(text); std::getline(lines, line);) {
    if (line.empty() || line[0] != '|') {
      cells = 0;
      continue;
    }
    std::size_t bars = 0;
    for (std::size_t i = 0; i < line.size(); ++i) bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\');
    if (cells == 0) cells = bars;
    EXPECT_EQ(bars, cells) << line;
  }
}

}  // namespace
}  // namespace talus::test
