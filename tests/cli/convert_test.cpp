// `talus convert`: frames in other formats, with the bits of the run; what cannot be converted is refused and leaves
// nothing.
#include <cmath>
#include <sstream>

#include "core/io/particle_frames.hpp"
#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {
namespace fs = std::filesystem;

class Convert : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    write("scene.toml", small_scene(60));
    ASSERT_EQ(talus({"run", "scene.toml", "--out", "out", "--quiet"}).exit_code, 0);
  }
  Frame last() const {
    const ParticleFrames frames((folder / "out/particles.pvd").string());
    return frames.frame(frames.steps().size() - 1);
  }
  static std::vector<std::string> lines(const std::string& text) {
    std::vector<std::string> all;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
};

TEST_F(Convert, ACsvHasTheBitsOfTheLastFrameAndStartsAnotherRun) {
  ASSERT_EQ(talus({"convert", "out", "state.csv"}).exit_code, 0);
  const Frame f = last();
  const Table t = table_of(read("state.csv"));
  ASSERT_EQ(t.at("id").size(), f.id.size());
  for (std::size_t i = 0; i < f.id.size(); ++i) {
    EXPECT_EQ(t.at("id")[i], static_cast<double>(f.id[i]));
    EXPECT_EQ(t.at("x")[i], f.x[i].x);
    EXPECT_EQ(t.at("vz")[i], f.v[i].z);
    EXPECT_EQ(t.at("wy")[i], f.w[i].y);
    EXPECT_EQ(t.at("radius")[i], f.r[i]);
  }
  std::string scene = small_scene(1);
  scene = scene.substr(0, scene.find("[[source]]")) + "[[source]]\nkind = \"file\"\nfile = \"state.csv\"\n";
  write("next.toml", scene + "[checks]\nallow_initial_overlap = true\n");
  const Result r = talus({"run", "next.toml", "--out", "next", "--quiet", "--steps", "10"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(json_value(read("next/summary.json"), "particles"), "60");
}

TEST_F(Convert, FramesGoThroughEveryFormatOfVtkUnchanged) {
  for (const char* to : {"a.vtkhdf", "b/c.pvd"}) {
    if (std::string(to).find('/') != std::string::npos) fs::create_directory(folder / "b");
    const Result r = talus({"convert", std::string(to) == "a.vtkhdf" ? "out/particles.pvd" : "a.vtkhdf", to});
    ASSERT_EQ(r.exit_code, 0) << r.err;
  }
  const ParticleFrames before((folder / "out/particles.pvd").string()), after((folder / "b/c.pvd").string());
  ASSERT_EQ(before.steps().size(), 9u);
  ASSERT_EQ(after.steps().size(), 9u);
  for (std::size_t k = 0; k < 9; ++k) {
    const Frame a = before.frame(k), b = after.frame(k);
    EXPECT_EQ(a.step, b.step);
    EXPECT_TRUE(a.id == b.id && a.r == b.r);
    for (std::size_t i = 0; i < a.x.size(); ++i)
      EXPECT_EQ(norm2(a.x[i] - b.x[i]) + norm2(a.v[i] - b.v[i]) + norm2(a.w[i] - b.w[i]), 0);
  }
  ASSERT_EQ(talus({"convert", "out/particles.pvd", "one.vtp", "--frame", "3"}).exit_code, 0);
  EXPECT_EQ(read_vtp((folder / "one.vtp").string()).time, before.steps()[3].time);
}

TEST_F(Convert, DumpsAndXyzHoldEveryFrameWithBoxAndNames) {
  ASSERT_EQ(talus({"convert", "out", "p.dump"}).exit_code, 0);
  ASSERT_EQ(talus({"convert", "out", "p.xyz", "--frame", "last"}).exit_code, 0);
  const auto dump = lines(read("p.dump"));
  ASSERT_EQ(dump.size(), 9u * (9 + 60));
  EXPECT_EQ(dump[0], "ITEM: TIMESTEP");
  EXPECT_EQ(dump[69 * 8 + 1], "400");
  EXPECT_EQ(dump[3], "60");
  EXPECT_EQ(dump[4], "ITEM: BOX BOUNDS pp pp ff");
  EXPECT_EQ(dump[7], "0 0.2");
  EXPECT_EQ(dump[8], "ITEM: ATOMS id type x y z vx vy vz radius omegax omegay omegaz");
  const Frame f = last();
  std::istringstream row(dump[69 * 8 + 9]);
  double id = 0, type = 0, x = 0;
  row >> id >> type >> x;
  EXPECT_EQ(id, static_cast<double>(f.id[0]));
  EXPECT_EQ(type, 1);
  EXPECT_EQ(x, f.x[0].x);
  const auto xyz = lines(read("p.xyz"));
  ASSERT_EQ(xyz.size(), 62u);
  EXPECT_EQ(xyz[0], "60");
  EXPECT_NE(xyz[1].find("Lattice=\"0.1 0 0 0 0.1 0 0 0 0.2\""), std::string::npos) << xyz[1];
  EXPECT_NE(xyz[1].find("pbc=\"T T F\""), std::string::npos) << xyz[1];
  EXPECT_EQ(xyz[2].rfind("glass 0 ", 0), 0u) << xyz[2];
}

TEST_F(Convert, ACheckpointAndATableAreReadToo) {
  ASSERT_EQ(talus({"convert", "out/checkpoint-400.tcp", "c.csv"}).exit_code, 0);
  ASSERT_EQ(talus({"convert", "out", "f.csv"}).exit_code, 0);
  EXPECT_EQ(read("c.csv"), read("f.csv")) << "a frame was due at the last step";
  ASSERT_EQ(talus({"convert", "c.csv", "c.vtp"}).exit_code, 0);
  EXPECT_EQ(read_vtp((folder / "c.vtp").string()).x.size(), 60u);
}

TEST_F(Convert, WhatCannotBeConvertedIsRefusedAndLeavesNothing) {
  write("there.csv", "mine");
  write("broken.vtp", "no frame");
  const std::vector<std::pair<std::vector<std::string>, int>> wrong{
      {{"out", "x.doc"}, 2},
      {{"out", "x"}, 2},
      {{"nowhere", "x.csv"}, 5},
      {{"out", "there.csv"}, 2},
      {{"out", "x.csv", "--frame", "9"}, 2},
      {{"out", "x.csv", "--frame", "all"}, 2},
      {{"out", "x.csv", "--frame", "-1"}, 2},
      {{"broken.vtp", "x.csv"}, 5},
      {{"scene.toml", "x.csv"}, 2},
      {{"out/particles.pvd", "out/particles.pvd"}, 2},
      {{"out", "no/such/folder.csv"}, 5},
  };
  for (const auto& [more, code] : wrong) {
    std::vector<std::string> arguments{"convert"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result r = talus(arguments);
    EXPECT_EQ(r.exit_code, code) << more[0] << " " << more[1] << ": " << r.err;
    EXPECT_FALSE(exists("x.csv") || exists("x.doc") || exists("no")) << more[0];
  }
  EXPECT_EQ(read("there.csv"), "mine");
  EXPECT_EQ(talus({"convert", "out", "there.csv", "--overwrite"}).exit_code, 0);
  EXPECT_NE(read("there.csv"), "mine");
}

}  // namespace
}  // namespace talus::test
