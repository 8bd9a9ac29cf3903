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

/// Bodies become rows of their own, from a run, one of its frames and a checkpoint alike; formats without a place for
/// them say so.
TEST_F(Convert, BodiesOfARunAreRowsThatStartAnotherRun) {
  const std::string shapes =
      "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.004, 0.004, 0, 0, 0.004, 0.004]\n"
      "[[shape]]\nname = \"egg\"\nkind = \"superquadric\"\nsemi_axes = [0.004, 0.004, 0.008]\n";
  std::string scene = small_scene(20);
  const std::size_t at = scene.find("[[source]]");
  std::string more = shapes;
  for (const char* shape : {"rod", "egg"})
    more += "[[source]]\nkind = \"random\"\nnumber = 8\nshape = \"" + std::string(shape) +
            "\"\n[source.region]\nlower = [0.01, 0.01, 0.05]\nupper = [0.09, 0.09, 0.09]\n";
  write("bodies.toml", scene + more);
  Result r = talus({"run", "bodies.toml", "--out", "with", "--quiet"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  ASSERT_EQ(talus({"convert", "with", "state.csv"}).exit_code, 0);
  EXPECT_EQ(lines(read("state.csv")).size(), 37U) << "a header, and a row for each grain";
  EXPECT_NE(read("state.csv").find(",rod,1,"), std::string::npos);
  ASSERT_EQ(talus({"convert", "with/particles.pvd", "again.csv"}).exit_code, 0);
  EXPECT_EQ(read("again.csv"), read("state.csv"));
  r = talus({"convert", "with", "state.xyz"});
  EXPECT_NE(r.err.find("no place for bodies"), std::string::npos) << r.err;
  write("next.toml", scene.substr(0, at) + shapes + "[[source]]\nkind = \"file\"\nfile = \"state.csv\"\n" +
                         "[checks]\nallow_initial_overlap = true\n");
  r = talus({"run", "next.toml", "--out", "next", "--quiet", "--steps", "10"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(json_value(read("next/summary.json"), "particles"), "36");
  fs::create_directory(folder / "alone");
  for (const auto& file : fs::directory_iterator(folder / "with/vtp"))
    if (file.path().filename().string().starts_with("particles-"))
      fs::copy_file(file.path(), folder / "alone" / file.path().filename());
  const std::string frame = fs::directory_iterator(folder / "alone")->path().filename().string();
  r = talus({"convert", "alone/" + frame, "lost.csv"});
  EXPECT_EQ(r.exit_code, 5);
  EXPECT_NE(r.err.find("bodies that are no spheres"), std::string::npos) << r.err;
  EXPECT_FALSE(fs::exists(folder / "lost.csv"));
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

TEST_F(Convert, EveryTextFormatIsReadBackWithItsBits) {
  ASSERT_EQ(talus({"convert", "out", "p.dump"}).exit_code, 0);
  ASSERT_EQ(talus({"convert", "p.dump", "from_dump.vtkhdf"}).exit_code, 0);
  ASSERT_EQ(talus({"convert", "out", "p.xyz"}).exit_code, 0);
  ASSERT_EQ(talus({"convert", "p.xyz", "from_xyz.pvd"}).exit_code, 0);
  const ParticleFrames before((folder / "out/particles.pvd").string());
  for (const char* file : {"from_dump.vtkhdf", "from_xyz.pvd"}) {
    const ParticleFrames after((folder / file).string());
    ASSERT_EQ(after.steps().size(), 9u);
    for (std::size_t k = 0; k < 9; ++k) {
      const Frame a = before.frame(k), b = after.frame(k);
      EXPECT_EQ(a.step, b.step);
      EXPECT_TRUE(a.id == b.id && a.r == b.r) << file;
      for (std::size_t i = 0; i < a.x.size(); ++i)
        EXPECT_EQ(norm2(a.x[i] - b.x[i]) + norm2(a.v[i] - b.v[i]) + norm2(a.w[i] - b.w[i]), 0) << file;
    }
  }
  EXPECT_EQ(ParticleFrames((folder / "from_xyz.pvd").string()).steps()[5].time, before.steps()[5].time);
  // through all of them and back: box, names and ids stay
  ASSERT_EQ(talus({"convert", "p.xyz", "q.dump"}).exit_code, 0);
  EXPECT_EQ(read("q.dump"), read("p.dump"));
  ASSERT_EQ(talus({"convert", "out", "p.csv"}).exit_code, 0);
  ASSERT_EQ(talus({"convert", "q.dump", "q.csv"}).exit_code, 0);
  EXPECT_EQ(read("q.csv").substr(read("q.csv").find('\n')).substr(0, 200),
            read("p.csv").substr(read("p.csv").find('\n')).substr(0, 200));
}

TEST_F(Convert, DumpsOfOtherProgramsAreRead) {
  write("other.dump",
        "ITEM: UNITS\nsi\nITEM: TIME\n0.25\nITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n2\n"
        "ITEM: BOX BOUNDS xy xz yz pp pp ff\n-1 3 0\n0 2 0\n0 10 0\n"
        "ITEM: ATOMS type id diameter xs ys zs mass\n2 7 0.5 0.25 0.5 0.1 9\n1 3 0.25 0.5 0.5 0.2 9\n");
  const Result r = talus({"convert", "other.dump", "other.xyz"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("ignored: mass"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("no velocities"), std::string::npos) << r.err;
  const auto xyz = lines(read("other.xyz"));
  EXPECT_NE(xyz[1].find("Origin=\"-1 0 0\" pbc=\"T T F\" Time=0.25 Step=100"), std::string::npos) << xyz[1];
  EXPECT_EQ(xyz[2], "M0 3 1 1 2 0.125 0 0 0");
  EXPECT_EQ(xyz[3], "M1 7 0 1 1 0.25 0 0 0");
  ASSERT_EQ(talus({"convert", "other.dump", "other.csv"}).exit_code, 0);
  EXPECT_EQ(lines(read("other.csv"))[2].substr(0, 12), "7,0,1,1,0.25");
}

TEST_F(Convert, ATableKeepsItsIdsWhateverTheirOrder) {
  write("t.csv", "id,x,y,z,radius\n9,1,2,3,0.5\n4,4,5,6,0.25\n");
  ASSERT_EQ(talus({"convert", "t.csv", "t.dump"}).exit_code, 0);
  const auto dump = lines(read("t.dump"));
  EXPECT_EQ(dump[9].substr(0, 9), "4 1 4 5 6");
  EXPECT_EQ(dump[10].substr(0, 9), "9 1 1 2 3");
}

TEST_F(Convert, TextThatIsNoSetOfSpheresIsRefusedWithItsLine) {
  const std::string head = "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n";
  const std::string columns = "ITEM: ATOMS id type x y z radius\n";
  const std::string row = "1 1 .5 .5 .5 .1\n", next = "2 1 .7 .5 .5 .1\n";
  struct Case {
    const char* file;
    std::string text, said;
  };
  const std::vector<Case> cases{
      {"a.dump", head + "ITEM: ATOMS id type x y z\n1 1 0 0 0\n2 1 0 0 1\n", "no spheres"},
      {"a.dump", head + columns + row, "ends after 1 of 2"},
      {"a.dump", head, "cut off"},
      {"a.dump", head + columns + row + "1 1 .7 .5 .5 .1\n", "id 1 is there twice"},
      {"a.dump", head + columns + row + "2 1 .7 .5 .5\n", "a.dump:11: 5 values"},
      {"a.dump", head + columns + row + "2 1 .7 nan .5 .1\n", "not finite"},
      {"a.dump", head + columns + row + "2 1 .7 .5 .5 0\n", "radius of 0"},
      {"a.dump", head + "ITEM: ATOMS id x y z radius diameter\n1 .5 .5 .5 .1 .200001\n2 .7 .5 .5 .1 .3\n",
       "a.dump:11: a radius of 0.1 and a diameter of 0.3 contradict each other"},
      {"a.dump", head + columns + row + "2 0 .7 .5 .5 .1\n", "type 0"},
      {"a.dump", head + columns + row + next + head + columns + row + next, "step 5 comes after step 5"},
      {"a.dump",
       "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS xy xz yz pp pp pp\n0 1 .2\n0 1 0\n0 1 0\n",
       "skewed"},
      {"a.dump", "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ENTRIES\n0\n", "is not known"},
      {"a.xyz", "2\nwater\nO 0 0 0\nH 0 0 1\n", "points, no spheres"},
      {"a.xyz", "1\nProperties=species:S:1:pos:R:3\nO 0 0 0\n", "no spheres"},
      {"a.xyz", "1\nProperties=pos:R:3:radius:R:1 Lattice=\"1 .1 0 0 1 0 0 0 1\"\n0 0 0 1\n", "skewed"},
      {"a.xyz", "two\n", "not a number"},
      {"a.xyz", "", "empty"},
  };
  for (const Case& c : cases) {
    write(c.file, c.text);
    const Result r = talus({"convert", c.file, "x.pvd"});
    EXPECT_EQ(r.exit_code, 5) << c.text << r.err;
    EXPECT_NE(r.err.find(c.said), std::string::npos) << c.said << "\n" << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n') - (r.err.find("note:") != std::string::npos), 1) << r.err;
    EXPECT_FALSE(exists("x.pvd"));
  }
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
