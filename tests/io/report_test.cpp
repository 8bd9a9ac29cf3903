// perf/report.py on folders written by the real writers: whole, partly missing, damaged.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>

#include "core/io/run_folder.hpp"
#include "core/io/series.hpp"
#include "core/io/summary.hpp"
#include "core/io/vtkhdf.hpp"
#include "core/io/vtp.hpp"
#include "paths.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

using test::python;
using test::TemporaryFolder;

bool report(const std::string& dir, const std::string& more = "") {
  return std::system(
             ("/usr/bin/python3 " TALUS_SOURCE_DIR "/perf/report.py " + dir + " > /dev/null " + more).c_str()) == 0;
}

constexpr const char* k_scene =
    "title = \"<b>grains</b> & more\"\ngravity = [0, 0, -9.81]\n[domain]\nlower = [0, 0, 0]\nupper = [10, 10, 60]\n";

RunFolder example(const std::string& dir, const std::string& scene = k_scene) {
  auto f = RunFolder::create(dir, scene);
  VtkHdfWriter p(f.particles(), {}), w(f.walls(), {}, VtkHdfWriter::Content::walls);
  SeriesLayout layout;
  layout.walls = {"floor"};
  layout.planes = {"outlet"};
  layout.regions = {"core"};
  Scene stressed;
  stressed.output.stress = true;
  layout.averages = averages_of(stressed);
  SeriesWriter csv(f.series(), layout);
  for (int k = 0; k < 5; ++k) {
    const Frame frame = test::make_frame(10 * k, k == 0 ? 0 : 40 - k, 4);
    p.append(frame);
    w.append(frame);
    SeriesRow row;
    row.step = frame.step;
    row.time = frame.time;
    row.particles = 40 - k;
    row.removed = k;
    row.removed_mass = 0.1 * k;
    row.walls = {{{0, 0, -1.0 * k}, {}}};
    row.planes = {{k, 0, 0.1 * k}};
    row.regions.resize(1);
    row.regions[0].stress = {300.0 * k, 600.0 * k, 900.0 * k, 0, 0, 0};
    csv.append(row);
  }
  Summary s;
  s.title = "Heap of <b>grains</b>";
  s.particles = 36;
  s.steps = 40;
  s.nodes = {{"contact_force", 40, 1.5}, {"integrate", 40, 0.5}};
  s.rebuild_steps = {0, 4, 9, 15, 30};
  write_summary(f.summary(), s);
  return f;
}

TEST(Report, IsOneSelfContainedPage) {
  TemporaryFolder t;
  const auto f = example(t / "out");
  ASSERT_TRUE(report(f.dir()));
  EXPECT_TRUE(python("check_report.py", f.report() + " 4 'Heap of <b>grains</b>' '<b>grains</b> & more' 'Mass flow' "
                                                     "'Time series' 'List rebuilds' 'Where the time went' "
                                                     "'Last frame: t = 5 s, step 40, 36 particles'"));
  EXPECT_FALSE(python("check_report.py", f.report() + " 2 2>/dev/null"));
  const std::string first = test::slurp(f.report());
  ASSERT_TRUE(report(f.dir()));
  EXPECT_TRUE(test::slurp(f.report()) == first);  // no dates, no random ids
}

TEST(Report, ShowsTheListOverTheRun) {
  TemporaryFolder t;
  const auto f = example(t / "out");
  const std::string page = " 4 'The list over the run: skin, K, rebuild interval, pairs per contact'";
  ASSERT_TRUE(report(f.dir()));
  EXPECT_FALSE(python("check_report.py", f.report() + page + " 2>/dev/null")) << "no series, no plots";
  Summary s;
  s.verlet_k_automatic = true;
  for (int k = 0; k < 20; ++k)
    s.list_series.push_back({40 * k, 40, 60.0 + k, 0.02, 0.03 + 0.001 * k, 9000 + 10 * k, 3000});
  write_summary(f.summary(), s);
  ASSERT_TRUE(report(f.dir()));
  EXPECT_TRUE(python("check_report.py", f.report() + page));
}

TEST(Report, ShowsFramesOfEitherFormatTheSame) {
  TemporaryFolder t;
  const auto hdf = example(t / "hdf"), vtp = example(t / "vtp");
  std::filesystem::remove(vtp.particles());
  std::filesystem::remove(vtp.walls());
  PvdCollection p(vtp.dir(), "particles"), w(vtp.dir(), "walls");
  for (int k = 0; k < 5; ++k) {
    const Frame frame = test::make_frame(10 * k, k == 0 ? 0 : 40 - k, 4);
    write_vtp(p.path(frame.step), particle_poly(frame, {}), frame.time);
    p.add(frame.step, frame.time);
    write_vtp(w.path(frame.step), wall_poly(frame), frame.time);
    w.add(frame.step, frame.time);
  }
  ASSERT_TRUE(report(hdf.dir()));
  ASSERT_TRUE(report(vtp.dir()));
  const auto pictures = [](const RunFolder& f) {
    const std::string page = test::slurp(f.report());
    return page.substr(page.find("<h2>Particles"), page.find("<h2>Mass flow") - page.find("<h2>Particles"));
  };
  EXPECT_GT(pictures(vtp).size(), 10000u);
  EXPECT_TRUE(pictures(vtp) == pictures(hdf));
}

TEST(Report, WarningsComeFirstAndMeshesAreListed) {
  TemporaryFolder t;
  const auto f = example(t / "out");
  Summary s;
  s.warnings = {{"travel", "a grain moved <fast>", 120, 7, 0.4, 0.1}};
  MeshReport mesh;
  mesh.file = "silo.stl";
  mesh.facets_read = 321;
  mesh.open_edges = 9;
  s.meshes = {{"silo", mesh}};
  write_summary(f.summary(), s);
  ASSERT_TRUE(report(f.dir()));
  EXPECT_TRUE(python("check_report.py", f.report() + " 4 'Warnings of the run' 'a grain moved <fast>' "
                                                     "'in 7 steps from step 120 on' silo.stl 321 '9 open edges'"));
  const std::string page = test::slurp(f.report());
  EXPECT_LT(page.find("Warnings of the run"), page.find("<h2>"));
}

TEST(Report, ShowsARunThatHasLeftNoSummary) {
  TemporaryFolder t;
  const auto f = example(t / "out");
  std::filesystem::remove(f.summary());
  const std::string series = test::slurp(f.series());
  test::spill(f.series(), series.substr(0, series.size() - 3));  // torn by a kill
  ASSERT_TRUE(report(f.dir()));
  EXPECT_TRUE(python("check_report.py", f.report() + " 4 'goes on, or was killed' 'until t =' 'Time series'"));
}

TEST(Report, WorksWhenFilesAreMissing) {
  TemporaryFolder t;
  struct Case {
    std::vector<std::string> removed;
    std::string expected;
  };
  int k = 0;
  for (const Case& c : {Case{{"summary.json", "scene.toml"}, " 4 'summary.json is missing; scene.toml is missing'"},
                        Case{{"series.csv", "walls.vtkhdf"}, " 4 'series.csv is missing'"},
                        Case{{"particles.vtkhdf"}, " 0 'there are no particles over time' 'Time series'"}}) {
    const auto f = example(t / std::to_string(k++));
    for (const auto& name : c.removed) std::filesystem::remove(f.path(name));
    EXPECT_TRUE(report(f.dir())) << c.expected;
    EXPECT_TRUE(python("check_report.py", f.report() + c.expected)) << c.expected;
  }
  std::filesystem::create_directory(t / "empty");
  EXPECT_TRUE(report(t / "empty"));
}

TEST(Report, DamagedFilesAreNamed) {
  TemporaryFolder t;
  const auto f = example(t / "out");
  for (const std::string& path : {f.summary(), f.series(), f.particles(), f.walls()}) test::spill(path, "damaged\n");
  EXPECT_TRUE(report(f.dir()));
  EXPECT_TRUE(python("check_report.py", f.report() +
                                            " 0 'summary.json cannot be read' 'series.csv cannot be read' "
                                            "'particles over time cannot be read' 'walls over time cannot be read'"));
}

/// What the plots hand to the script: the numbers of the curve with that label, as text.
std::string numbers_of(const std::string& page, const std::string& label) {
  const std::size_t at = page.find("&quot;label&quot;:&quot;" + label + "&quot;");
  if (at == std::string::npos) return "none";
  const std::size_t begin = page.find("[", at), end = page.find("]", begin);
  return page.substr(begin, end - begin + 1);
}

TEST(Report, ShowsStressOfRegionsAndProfilesOfTheLastFrame) {
  TemporaryFolder t;
  const auto f = example(t / "out");
  ASSERT_TRUE(report(f.dir()));
  const std::string page = test::slurp(f.report());
  EXPECT_EQ(numbers_of(page, "xx"), "[0.0,300.0,600.0,900.0,1200.0]");
  EXPECT_EQ(numbers_of(page, "core").substr(0, 1), "[");
  EXPECT_NE(page.find("Mean normal stress"), std::string::npos);
  EXPECT_NE(page.find("[0.0,600.0,1200.0,1800.0,2400.0]"), std::string::npos) << "(xx + yy + zz) / 3";
  EXPECT_NE(page.find("Size distribution"), std::string::npos);
  EXPECT_NE(page.find("Solid fraction of the domain"), std::string::npos);
}

TEST(Report, TheSolidFractionsOfAllLayersMakeTheVolumeOfTheGrains) {
  EXPECT_EQ(std::system("/usr/bin/python3 " TALUS_SOURCE_DIR "/tests/io/check_profiles.py"), 0);
}

TEST(Report, PicturesShowSuperquadricsByTheirSurface) {
  EXPECT_EQ(std::system("/usr/bin/python3 " TALUS_SOURCE_DIR "/tests/io/check_bodies.py"), 0);
}

TEST(Report, ABrowserZoomsReadsValuesAndDrawsSpheres) {
  TemporaryFolder t;
  const auto f = example(t / "out");
  ASSERT_TRUE(report(f.dir()));
  const int status = std::system(("/usr/bin/python3 " TALUS_SOURCE_DIR "/tests/io/check_browser.py " + f.report() +
                                  " 'spheres are drawn' 'view 36 grains' 'by diameter, error 0' 'xx: ' > /dev/null")
                                     .c_str());
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "no chromium here";
  EXPECT_EQ(status, 0);
}

TEST(Report, AnIndexComparesRuns) {
  TemporaryFolder t;
  std::string folders;
  for (const char* friction : {"0.2", "0.4", "0.8"}) {
    const auto f = example(t / friction, std::string(k_scene) + "[contact]\nfriction = " + friction + "\n");
    folders += f.dir() + " ";
    Summary s;
    s.steps = 100 + static_cast<std::int64_t>(folders.size());
    write_summary(f.summary(), s);
  }
  ASSERT_TRUE(report(t / "0.4"));
  const std::string index = t / "index.html";
  ASSERT_TRUE(report(folders, "--index " + index + " --figures removed_mass,steps"));
  EXPECT_TRUE(python("check_report.py", index + " 0 '3 runs' contact.friction 0.2 0.8 removed_mass steps"));
  const std::string page = test::slurp(index);
  EXPECT_NE(page.find("href=\"0.4/report.html\""), std::string::npos);
  EXPECT_EQ(page.find("href=\"0.2/report.html\""), std::string::npos) << "has no report";
  EXPECT_NE(page.find("&quot;at&quot;:[0.2,0.4,0.8]"), std::string::npos) << "figures over what differs";
  ASSERT_TRUE(report(folders, "--index " + index)) << "the figures chosen for it";
  EXPECT_FALSE(report(folders, "--index " + index + " --figures masss 2>/dev/null"));
  EXPECT_FALSE(report(folders, "2>/dev/null")) << "several folders, no index";
}

TEST(Report, ReplacesNoFileThatIsNoPage) {
  TemporaryFolder t;
  const auto f = example(t / "out");
  const std::string scene = test::slurp(f.path("scene.toml"));
  EXPECT_FALSE(report(f.dir(), "--out " + f.path("scene.toml") + " 2>/dev/null"));
  EXPECT_EQ(test::slurp(f.path("scene.toml")), scene);
  EXPECT_FALSE(report(f.dir(), "--out /dev/null 2>/dev/null"));
  EXPECT_TRUE(report(f.dir(), "--out " + t / "page.html") && report(f.dir(), "--out " + t / "page.html"));
}

TEST(Report, NoFolderIsAnError) { EXPECT_FALSE(report("/nonexistent/run", "2>&1")); }

}  // namespace
}  // namespace talus
