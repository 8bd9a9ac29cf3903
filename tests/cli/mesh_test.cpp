// Claims about meshes as users meet them: check and run say what was found of every mesh, doubts are said once and kept
// in the summary, a damaged file ends both with one line.
#include "tests/cli/cli_runner.hpp"

namespace talus::test {
namespace {

/// The first sides of a tetrahedron, which is closed with all four.
std::string mesh_text(int facets) {
  std::string s = "solid part\n";
  const char* const corners[4][3] = {{"0 0 0", "0 .05 0", ".05 0 0"},
                                     {"0 0 0", ".05 0 0", "0 0 .05"},
                                     {"0 0 0", "0 0 .05", "0 .05 0"},
                                     {".05 0 0", "0 .05 0", "0 0 .05"}};
  for (int f = 0; f < facets; ++f) {
    s += "facet normal 0 0 0\nouter loop\n";
    for (const char* c : corners[f]) s += std::string("vertex ") + c + "\n";
    s += "endloop\nendfacet\n";
  }
  return s + "endsolid part\n";
}

std::int64_t count(const std::string& text, const std::string& part) {
  std::int64_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

const char* const k_wall =
    "[[wall]]\nname = \"part\"\nshape = \"mesh\"\nfile = \"part.stl\"\nshift = [0.001, 0.001, 0.001]\n";

TEST_F(Cli, CheckAndRunSayWhatWasFoundOfAMesh) {
  write("part.stl", mesh_text(4));
  write("scene.toml", small_scene(5, k_wall));
  const Result check = talus({"check", "scene.toml"});
  ASSERT_EQ(check.exit_code, 0) << check.err;
  EXPECT_NE(check.out.find("part.stl: 4 facets, watertight, 2.083e-05 m3, 0.05 x 0.05 x 0.05 m"), std::string::npos)
      << check.out;
  const Result run = talus({"run", "scene.toml", "--out", "out"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(count(run.err, "part.stl: 4 facets, watertight"), 1) << run.err;
  EXPECT_EQ(run.err.find("warning"), std::string::npos) << run.err;
  const std::string summary = read("out/summary.json");
  EXPECT_NE(summary.find("\"watertight\": true"), std::string::npos) << summary;
  EXPECT_EQ(json_value(summary, "facets_read"), "4");
  const Result json = talus({"check", "scene.toml", "--json"});
  EXPECT_EQ(json_value(json.out, "open_edges"), "0") << json.out;
}

TEST_F(Cli, DoubtsAboutAMeshAreSaidOnceAndKept) {
  write("part.stl", mesh_text(4) + mesh_text(1));
  write("scene.toml", small_scene(5, k_wall));
  const Result run = talus({"run", "scene.toml", "--out", "out"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(count(run.err, "talus: warning: wall \"part\", mesh"), 1) << run.err;
  EXPECT_NE(run.err.find("1 facets occur twice and were dropped"), std::string::npos) << run.err;
  EXPECT_NE(read("out/summary.json").find("\"kind\": \"mesh\""), std::string::npos);
}

TEST_F(Cli, ADamagedMeshEndsCheckAndRunWithItsLine) {
  write("part.stl", mesh_text(4).substr(0, 200));
  write("scene.toml", small_scene(5, k_wall));
  for (const char* command : {"check", "run"}) {
    const Result r = talus({command, "scene.toml"});
    EXPECT_EQ(r.exit_code, 3);
    EXPECT_EQ(count(r.err, "\n"), 1) << r.err;
    EXPECT_NE(r.err.find("part.stl:"), std::string::npos) << r.err;
  }
}

TEST_F(Cli, AnObjectFileNeedsNoMaterials) {
  write("floor.obj", "mtllib silo.mtl\nv 0 0 0\nv .05 0 0\nv .05 .05 0\nv 0 .05 0\nusemtl steel\nf 1 2 3 4\n");
  std::filesystem::create_directory(folder / "scenes");
  write("scenes/scene.toml", small_scene(5, replaced(k_wall, "part.stl", "../floor.obj")));
  const Result r = talus({"check", "scenes/scene.toml"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("2 facets, not watertight"), std::string::npos) << r.out;
}

}  // namespace
}  // namespace talus::test
