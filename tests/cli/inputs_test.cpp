// Files, texts and numbers of users at the command line: read, or refused in one line with nothing left behind.
#include <sys/stat.h>

#include <filesystem>

#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {
namespace fs = std::filesystem;

/// The message is one line of at most 1000 bytes without control characters.
void expect_one_line(const std::string& err) {
  ASSERT_FALSE(err.empty());
  EXPECT_EQ(err.find('\n'), err.size() - 1) << err;
  EXPECT_LE(err.size(), 1000u) << err;
  for (const char c : err.substr(0, err.size() - 1))
    EXPECT_FALSE(static_cast<unsigned char>(c) < 0x20 || c == 0x7f) << err;
}

class Inputs : public Cli {
 protected:
  /// `run` and `check` refuse the scene with this exit code and leave nothing.
  void expect_refused(const std::vector<std::string>& arguments, int code, const std::string& part) {
    for (const char* command : {"run", "check"}) {
      std::vector<std::string> all{command};
      all.insert(all.end(), arguments.begin(), arguments.end());
      if (std::string(command) == "run") all.insert(all.end(), {"--out", "out"});
      const Result r = talus(all);
      EXPECT_EQ(r.exit_code, code) << command << ": " << r.err;
      EXPECT_NE(r.err.find(part), std::string::npos) << part << " in: " << r.err;
      expect_one_line(r.err);
      EXPECT_FALSE(exists("out"));
    }
  }

  /// The small scene with its particles from `file`.
  std::string from_file(const std::string& file) {
    std::string text = small_scene();
    const std::size_t from = text.find("kind = \"random\""), to = text.find("[output]");
    return text.replace(from, to - from, "kind = \"file\"\nfile = \"" + file + "\"\n");
  }
};

TEST_F(Inputs, ScenesThatAreNoRegularFileAreRefused) {
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  expect_refused({"fifo"}, 3, "it is a FIFO");
  expect_refused({"/dev/zero"}, 3, "it is a device");
  expect_refused({"."}, 3, "it is a folder");
  expect_refused({std::string(300, 'a') + ".toml"}, 3, "File name too long");
  expect_refused({std::string(5000, 'a') + "\n\x1b[31m.toml"}, 3, "File name too long");
  write("file", "");
  expect_refused({"file/scene.toml"}, 3, "Not a directory");
}

TEST_F(Inputs, ParticleFilesThatAreNoRegularFileAreRefused) {
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  for (const char* file : {"fifo", "/dev/zero", "."}) {
    write("scene.toml", from_file(file));
    expect_refused({"scene.toml"}, 3, "cannot open the particle file");
  }
  write("scene.toml", from_file(std::string(300, 'p')));
  expect_refused({"scene.toml"}, 3, "File name too long");
  write("scene.toml", from_file("a\\u0000b"));
  expect_refused({"scene.toml"}, 3, "source.0.file: ");
}

TEST_F(Inputs, WrongUsageIsSaidWithoutRawBytes) {
  for (const std::vector<std::string>& arguments :
       std::vector<std::vector<std::string>>{{"run", "a.toml", "--b\nad\x1b[31m"},
                                             {"run", "a.toml", "--threads", "\x07\n"},
                                             {std::string(5000, '\x01')}}) {
    const Result r = talus(arguments);
    EXPECT_EQ(r.exit_code, 2) << r.err;
    EXPECT_LE(r.err.size(), 1000u);
    EXPECT_EQ(r.err.rfind("talus: error: ", 0), 0u) << r.err;
    expect_one_line(r.err);
  }
}

TEST_F(Inputs, NumbersAtTheEndOfTheIntegersAreRefused) {
  write("scene.toml", small_scene());
  expect_refused({"scene.toml", "--set", "contact.friction=9007199254740993"}, 3, "contact.friction: 9007199254740993");
  expect_refused({"scene.toml", "--set", "source.0.number=9223372036854775807"}, 3, "source.0.number: ");
  expect_refused({"scene.toml", "--set", "output.grid=[9223372036854775807, 1, 1]"}, 3, "output.grid: ");
}

TEST_F(Inputs, MemoryIsJudgedBeforeItIsTaken) {
  write("scene.toml", small_scene());
  expect_refused({"scene.toml", "--set", "output.grid=[10000, 10000, 10000]"}, 3, "of memory, ");
  // 1e9 copies of one grain
  write("state.csv", "x,y,z,r\n5e-6,5e-6,0.01,1e-8\n");
  write("tiles.toml", from_file("state.csv"));
  expect_refused({"tiles.toml", "--set", "source.0.tile=[10000, 10000, 10]", "--set", "time.step=1e-15"}, 3,
                 "of memory, ");
}

TEST_F(Inputs, UmlautsInTextsAndFilesRun) {
  const std::string name = "K\xc3\xb6rner \xe2\x82\xac";
  write(name + ".csv", "x,y,z,r\n0.05,0.05,0.05,0.004\n");
  write("Sch\xc3\xbcttgut.toml", replaced(from_file(name + ".csv"), "small box",
                                          "Gr\xc3\xbc\xc3\x9f"
                                          "e"));
  const Result r = talus({"run", "Sch\xc3\xbcttgut.toml", "--out", "Ausl\xc3\xa4ufe", "--steps", "10"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(json_value(read("Ausl\xc3\xa4ufe/summary.json"), "title"),
            "Gr\xc3\xbc\xc3\x9f"
            "e");
  EXPECT_EQ(talus({"info", "Ausl\xc3\xa4ufe"}).exit_code, 0);
  write("latin.toml", replaced(small_scene(), "small box",
                               "Gr\xfc\xdf"
                               "e"));
  expect_refused({"latin.toml"}, 3, "latin.toml:1:12: byte 0xfc is no UTF-8");
}

TEST_F(Inputs, AFoldersNameCannotPutLinesIntoTheSceneCopy) {
  const std::string evil = "a\n#: set time.steps=7\n#: directory elsewhere";
  fs::create_directory(folder / evil);
  write(evil + "/state.csv", "x,y,z,r\n0.05,0.05,0.05,0.004\n");
  write(evil + "/scene.toml", "#: set time.steps=9\n" + from_file("state.csv"));
  ASSERT_EQ(talus({"run", evil + "/scene.toml", "--out", "out", "--steps", "20"}).exit_code, 0);
  // info reads the copy back: its steps and the place of its files are those of the run
  const Result r = talus({"info", "out/checkpoint-20.tcp"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(talus({"run", evil + "/scene.toml", "--resume", "out", "--steps", "30"}).exit_code, 0);
  EXPECT_EQ(talus({"compare", "out", "out"}).exit_code, 0);
}

TEST_F(Inputs, TinyAndHugeOutputIntervalsEnd) {
  write("scene.toml", small_scene(3));
  for (const auto& [every, rows] : std::map<std::string, std::size_t>{{"1e-300", 11}, {"1e-20", 11}, {"1e30", 1}}) {
    const Result r = talus({"run", "scene.toml", "--out", "out", "--overwrite", "--steps", "10", "--set",
                            "output.csv_every=" + every, "--set", "output.particles_every=" + every});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_EQ(table_of(read("out/series.csv"))["step"].size(), rows) << every;
  }
  const Result r =
      talus({"check", "scene.toml", "--set", "time.step=1e30", "--set", "checks.allow_unstable_step=true"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
}

TEST_F(Inputs, WhatIsIgnoredInAParticleFileIsSaidOnceByRunAndCheck) {
  write("state.csv", "id;x;y;z;r;mass\n1;0,05;0,05;0,05;0,004;1\n");
  write("scene.toml", from_file("state.csv"));
  for (const char* command : {"run", "check"}) {
    const Result r = talus({command, "scene.toml", "--steps", "5"});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    for (const std::string part : {"ignored: columns 'id', 'mass'", "decimal commas are read as decimal points"}) {
      const std::size_t at = r.err.find(part);
      EXPECT_NE(at, std::string::npos) << r.err;
      EXPECT_EQ(r.err.find(part, at + 1), std::string::npos) << "once: " << r.err;
    }
  }
  write("plain.csv", "x,y,z,r\n0.05,0.05,0.05,0.004\n");
  write("plain.toml", from_file("plain.csv"));
  EXPECT_EQ(talus({"check", "plain.toml"}).err, "");
}

TEST_F(Inputs, ABoxOfALammpsFileThatIsNotTheDomainIsSaid) {
  write("bed.data",
        "trial\n\n1 atoms\n1 atom types\n0 0.2 xlo xhi\n0 0.1 ylo yhi\n0 0.2 zlo zhi\n\nAtoms # sphere\n\n"
        "1 1 0.008 2500 0.05 0.05 0.05\n");
  write("scene.toml", from_file("bed.data"));
  for (const char* command : {"run", "check"}) {
    const Result r = talus({command, "scene.toml", "--steps", "5"});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_NE(r.err.find("warning: ./bed.data: its box (0 to 0.2, "), std::string::npos) << r.err;
  }
}

}  // namespace
}  // namespace talus::test
