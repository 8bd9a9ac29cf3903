// series.csv: columns from the scene, exact numbers, and the bytes of a resumed run.
#include "core/io/series.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "core/base/error.hpp"
#include "core/io/atomic_file.hpp"
#include "core/scene/scene.hpp"
#include "tests/io/output_frames.hpp"

namespace talus {
namespace {

using test::slurp;
using test::spill;
using test::TemporaryFolder;

SeriesLayout full_layout() {
  SeriesLayout l;
  l.inserted = l.wall_contacts = l.energies = l.rotation = true;
  l.friction = l.superquadrics = l.sizes = true;
  Scene scene;
  scene.output.stress = scene.output.coordination = true;
  l.averages = averages_of(scene);
  l.walls = {"gate", "domain_z_lower"};
  l.planes = {"outlet"};
  l.regions = {"bed"};
  return l;
}

/// Awkward numbers: no short decimal form.
SeriesRow row(std::int64_t step) {
  SeriesRow r;
  const double s = static_cast<double>(step);
  r.step = step;
  r.time = s * 1e-5;
  r.particles = 1000 - step;
  r.contacts = 3 * step + 1;
  r.wall_contacts = step / 2;
  r.inserted = step;
  r.removed = 2 * step;
  r.kinetic_energy = 1 / (s + 3);
  r.removed_mass = s / 7;
  r.energies.potential = std::sqrt(s + 2);
  r.energies.residual = -1e-17 * s;
  r.walls = {{{s / 3, -s, 1e300}, {0, -0.0, 5e-324}}, {}};
  r.planes = {{3 * step + 1, step, s / 11}};
  RegionAverage a;
  a.solid_fraction = 0.6 / (s + 1);
  a.stress[4] = s / 13;
  r.regions = {a};
  return r;
}

std::vector<std::vector<std::string>> cells(const std::string& text) {
  std::vector<std::vector<std::string>> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    out.emplace_back();
    std::istringstream parts(line);
    for (std::string p; std::getline(parts, p, ',');) out.back().push_back(p);
  }
  return out;
}

double value(const std::vector<std::vector<std::string>>& t, std::size_t r, const std::string& name) {
  const auto at = std::find(t[0].begin(), t[0].end(), name);
  if (at == t[0].end()) throw std::runtime_error("no column " + name);
  return std::strtod(t.at(r).at(static_cast<std::size_t>(at - t[0].begin())).c_str(), nullptr);
}

TEST(Series, ColumnsAreThoseTheSceneHas) {
  Scene scene;
  scene.contact.friction = false;
  const auto least = SeriesLayout::of(scene, {}).columns();
  EXPECT_EQ(least, (std::vector<std::string>{"step", "time", "particles", "kinetic_energy", "contacts",
                                             "coordination_number", "removed", "removed_mass", "mass_flow"}));
  Scene shaped = scene;
  shaped.shapes.resize(1);
  shaped.shapes[0].kind = ShapeSpec::Kind::superquadric;
  shaped.sources.resize(1);
  shaped.sources[0].shape = 0;
  shaped.output.energies = true;
  const auto solved = SeriesLayout::of(shaped, {}).columns();
  EXPECT_EQ(std::count(solved.begin(), solved.end(), "safe_pairs"), 1);
  EXPECT_EQ(std::count(solved.begin(), solved.end(), "kinetic_rotation"), 1);  // without friction, too
  scene.output.energies = true;
  auto some = SeriesLayout::of(scene, {"gate"}).columns();
  const auto has = [&](const char* name) { return std::count(some.begin(), some.end(), name) == 1; };
  EXPECT_TRUE(has("balance_residual") && has("wall.gate.force_x") && has("wall.gate.torque_z"));
  EXPECT_FALSE(has("kinetic_rotation") || has("dissipated_friction"));
  scene.sources.emplace_back();
  scene.shapes.resize(1);
  scene.sources.back().shape = 0;
  some = SeriesLayout::of(scene, {}).columns();
  EXPECT_TRUE(has("kinetic_rotation")) << "normal forces turn bodies";
  EXPECT_FALSE(has("dissipated_friction"));
  scene.sources.clear();
  scene.contact.friction = true;
  scene.output.flux_planes.push_back({"outlet", {}, {0, 0, -1}});
  scene.output.regions.push_back({"bed", {}});
  some = SeriesLayout::of(scene, {}).columns();
  EXPECT_TRUE(has("kinetic_rotation") && has("plane.outlet.mass_flow") && has("region.bed.solid_fraction"));
}

TEST(Series, EveryNumberReadsBackExactly) {
  TemporaryFolder folder;
  {
    SeriesWriter w(folder / "s.csv", full_layout());
    w.append(row(10));
    w.append(row(30));
  }
  const auto t = cells(slurp(folder / "s.csv"));
  ASSERT_EQ(t.size(), 3u);
  ASSERT_EQ(t[1].size(), t[0].size());
  EXPECT_EQ(value(t, 1, "kinetic_energy"), 1 / 13.0);
  EXPECT_EQ(value(t, 2, "potential"), std::sqrt(32.0));
  EXPECT_EQ(value(t, 2, "balance_residual"), -1e-17 * 30);
  EXPECT_EQ(value(t, 2, "wall.gate.force_z"), 1e300);
  EXPECT_EQ(value(t, 2, "wall.gate.torque_z"), 5e-324);
  EXPECT_TRUE(std::signbit(value(t, 2, "wall.gate.torque_y")));
  EXPECT_EQ(value(t, 2, "region.bed.stress_xz"), 30.0 / 13);
  EXPECT_EQ(value(t, 2, "coordination_number"), 2.0 * 91 / 970);
  EXPECT_EQ(value(t, 1, "mass_flow"), 0);  // no interval before the first row
  EXPECT_EQ(value(t, 2, "mass_flow"), (30.0 / 7 - 10.0 / 7) / (30 * 1e-5 - 10 * 1e-5));
  EXPECT_EQ(value(t, 2, "plane.outlet.particle_flow"), (61.0 - 21.0) / (30 * 1e-5 - 10 * 1e-5));
}

TEST(Series, ResumedFileEqualsTheUninterruptedOneByteForByte) {
  TemporaryFolder folder;
  const std::string path = folder / "s.csv";
  std::vector<std::string> after{""};  // file after k rows
  {
    SeriesWriter w(path, full_layout());
    after[0] = slurp(path);
    for (int k = 0; k < 6; ++k) {
      w.append(row(10 * k));
      after.push_back(slurp(path));
    }
  }
  const std::string whole = after.back();
  for (int resumed = -5; resumed <= 60; resumed += 5)
    for (const char* torn : {"", "60,0.00", "60"}) {
      spill(path, whole + torn);
      auto w = SeriesWriter::resume(path, full_layout(), resumed);
      const int kept = resumed < 0 ? 0 : std::min(resumed / 10 + 1, 6);
      EXPECT_EQ(w.last_step(), kept == 0 ? -1 : 10 * (kept - 1));
      EXPECT_EQ(slurp(path), after[static_cast<std::size_t>(kept)]) << resumed;
      for (int k = kept; k < 6; ++k) w.append(row(10 * k));
      EXPECT_EQ(slurp(path), whole) << resumed;
    }
}

TEST(Series, ResumeRefusesOtherColumnsAndDamage) {
  TemporaryFolder folder;
  const std::string path = folder / "s.csv";
  {
    SeriesWriter w(path, full_layout());
    w.append(row(1));
    w.append(row(2));
  }
  SeriesLayout other = full_layout();
  other.walls[0] = "door";
  EXPECT_THROW(SeriesWriter::resume(path, other, 2), Error);
  const std::string good = slurp(path);
  std::string bad = good;
  bad[good.find("\n1,") + 1] = 'x';
  spill(path, bad);
  EXPECT_THROW(SeriesWriter::resume(path, full_layout(), 2), Error);
  bad = good;
  bad.erase(good.rfind(','), 1);
  spill(path, bad);
  EXPECT_THROW(SeriesWriter::resume(path, full_layout(), 2), Error);
  spill(path, good);
  EXPECT_NO_THROW(SeriesWriter::resume(path, full_layout(), 2));
  EXPECT_EQ(SeriesWriter::resume(folder / "new.csv", full_layout(), 2).last_step(), -1);
}

TEST(Series, NamesWithCommasAreQuoted) {
  TemporaryFolder folder;
  SeriesLayout l;
  l.planes = {"a,\"b\""};
  { SeriesWriter w(folder / "s.csv", l); }
  EXPECT_NE(slurp(folder / "s.csv").find("\"plane.a,\"\"b\"\".mass\""), std::string::npos);
}

TEST(Series, RowsThatDoNotFitAreRefused) {
  TemporaryFolder folder;
  SeriesWriter w(folder / "s.csv", full_layout());
  SeriesRow r = row(1);
  r.walls.pop_back();
  EXPECT_THROW(w.append(r), Error);
  w.append(row(1));
  EXPECT_THROW(w.append(row(1)), Error);
}

/// Accepts a few bytes, then the disk is full.
class FullDisk : public FileCalls {
 public:
  ssize_t write(int fd, const void* d, std::size_t n) override {
    if (left == 0) {
      errno = ENOSPC;
      return -1;
    }
    n = std::min(n, left);
    left -= n;
    return FileCalls::write(fd, d, n);
  }
  std::size_t left = 20;
};

TEST(Series, FullDiskLeavesWholeRows) {
  TemporaryFolder folder;
  SeriesWriter w(folder / "s.csv", full_layout());
  w.append(row(1));
  const std::string before = slurp(folder / "s.csv");
  {
    FullDisk disk;
    ScopedFileCalls scope(disk);
    EXPECT_THROW(w.append(row(2)), Error);
  }
  EXPECT_EQ(slurp(folder / "s.csv"), before);
  w.append(row(2));  // space was made: the run may go on
  EXPECT_EQ(w.last_step(), 2);
  EXPECT_EQ(cells(slurp(folder / "s.csv")).size(), 3u);
}

/// Somebody cuts the file between the look at it and the write.
class CutBeforeWrite : public FileCalls {
 public:
  explicit CutBeforeWrite(std::string path) : path_(std::move(path)) {}
  ssize_t write(int fd, const void* d, std::size_t n) override {
    std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
    return FileCalls::write(fd, d, n);
  }

 private:
  std::string path_;
};

TEST(Series, ACutDuringAWriteIsSeenAtTheNextLook) {
  TemporaryFolder folder;
  const std::string path = folder / "s.csv";
  SeriesWriter w(path, full_layout());
  w.append(row(1));
  {
    CutBeforeWrite other(path);
    ScopedFileCalls scope(other);
    w.append(row(2));
  }
  EXPECT_THROW(w.check(), Error);
  EXPECT_THROW(w.append(row(3)), Error);
}

}  // namespace
}  // namespace talus
