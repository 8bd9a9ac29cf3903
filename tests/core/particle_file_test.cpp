// Claims about initial states from CSV and LAMMPS files.
#include "core/tables/particle_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/base/error.hpp"

namespace talus {
namespace {

const std::vector<Material> k_materials = {{"glass", 2500, 0, 0}, {"steel", 7800, 0, 0}};

std::string refusal(const std::string& text) {
  try {
    parse_particles(text, "p.csv", k_materials);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

/// A file that is gone at the end of the test.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / fmt::format("talus_{}_{}", getpid(), name)) {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  std::string path() const { return path_; }

 private:
  std::filesystem::path path_;
};

TEST(ParticleFile, RowsOfBodiesByNameIndexAndQuaternionWithFewDigits) {
  std::vector<ShapeSpec> shapes(2);
  shapes[0].name = "rod", shapes[1].name = "7";
  const ParticleFile p = parse_particles(
      "x,y,z,shape,scale,orientation:0,orientation:1,orientation:2,orientation:3,diameter\n1,2,3,rod,2,0.7071,0,0,0."
      "7071,0\n"
      "1,2,3,0,1.5,1,0,0,0,\"0\"\n1,2,3,7,0,1,0,0,0,4\n1,2,3,,,,,,,6\n",
      "b.csv", k_materials, shapes);
  EXPECT_EQ(p.shape, (std::vector<std::int32_t>{0, 0, 1, -1}));
  EXPECT_EQ(p.scale, (std::vector<double>{2, 1.5, 0, 1}));
  EXPECT_EQ(p.r, (std::vector<double>{0, 0, 2, 3}));
  double sum = 0;
  for (const double q : p.turn[0]) sum += q * q;
  EXPECT_NEAR(sum, 1, 1e-15) << "four digits are enough to be a turn";
  EXPECT_NEAR(p.turn[0][3], std::sqrt(0.5), 1e-15);
  const ParticleFile one = parse_particles("x y z radius\n1 2 3 4\n", "b.csv", k_materials, shapes, 1);
  EXPECT_EQ(one.shape, (std::vector<std::int32_t>{1}));
  EXPECT_TRUE(parse_particles("x y z radius\n1 2 3 4\n", "b.csv", k_materials, shapes).shape.empty());
}

TEST(ParticleFile, CsvColumnsComeInAnyOrder) {
  const ParticleFile p = parse_particles(
      "# a bed\nfixed, material, r, z,y,x, vx,vy,vz, wx,wy,wz\n"
      "1, steel, 0.5, 3, 2, 1, 4, 5, 6, 7, 8, 9\n\n"
      "0, 0, 2.5e-1, -3, +2, 1e0, 0, 0, 0, 0, 0, -1\r\n",
      "p.csv", k_materials);
  ASSERT_EQ(p.size(), 2u);
  EXPECT_EQ(p.x[0].x, 1);
  EXPECT_EQ(p.x[0].z, 3);
  EXPECT_EQ(p.v[0].y, 5);
  EXPECT_EQ(p.w[0].z, 9);
  EXPECT_EQ(p.w[1].z, -1);
  EXPECT_EQ(p.r[1], 0.25);
  EXPECT_EQ(p.material[0], 1);
  EXPECT_EQ(p.material[1], 0);
  EXPECT_EQ(p.fixed[0], 1);
  EXPECT_EQ(p.fixed[1], 0);
  EXPECT_EQ(p.row[0], 3);
  EXPECT_EQ(p.row[1], 5);
}

TEST(ParticleFile, ColumnsThatTheFileLacksAreEmpty) {
  const ParticleFile p = parse_particles("x,y,z,radius,vx,vy,vz\n1,2,3,4,5,6,7", "p.csv", k_materials);
  ASSERT_EQ(p.size(), 1u);
  EXPECT_TRUE(p.material.empty());
  EXPECT_TRUE(p.fixed.empty());
  EXPECT_EQ(p.w[0].x, 0);
  EXPECT_EQ(p.v[0].z, 7);
}

TEST(ParticleFile, CsvErrorsNameFileAndRow) {
  const std::string head = "x,y,z,radius,vx,vy,vz\n";
  EXPECT_CONTAINS(refusal("x,y,z,raduis,vx,vy,vz\n"), "p.csv:1: column 'radius' is missing (is it 'raduis'?)");
  EXPECT_CONTAINS(refusal("x,y,z,vx,vy,vz\n"), "p.csv:1: column 'radius' is missing");
  EXPECT_CONTAINS(refusal("x,y,z,r,radius,vx,vy,vz\n"), "named twice");
  EXPECT_CONTAINS(refusal("x,y,z,r,vx,vy,vz,wx\n"), "wx, wy and wz come together");
  EXPECT_CONTAINS(refusal(head + "1,2,3,1,0,0,0\n1,2,3\n"), "p.csv:3: 3 values, but the header names 7 columns");
  EXPECT_CONTAINS(refusal(head + "1,2,a3,1,0,0,0\n"), "p.csv:2: z: 'a3' is not a number");
  EXPECT_CONTAINS(refusal(head + "1,2,,1,0,0,0\n"), "p.csv:2: z: '' is not a number");
  EXPECT_CONTAINS(refusal(head + "1,nan,3,1,0,0,0\n"), "p.csv:2: y: 'nan' is not finite");
  EXPECT_CONTAINS(refusal(head + "1,2,3,1,0,0,1e999\n"), "p.csv:2: vz: '1e999'");
  EXPECT_CONTAINS(refusal(head + "1,2,3,-1,0,0,0\n"), "p.csv:2: radius: -1 is not allowed (must be > 0)");
  EXPECT_CONTAINS(refusal(head + "1,2,3,0,0,0,0\n"), "radius: 0 is not allowed");
  EXPECT_CONTAINS(refusal(head), "no particles");
  EXPECT_CONTAINS(refusal(""), "no particles");
  EXPECT_CONTAINS(refusal("x,y,z,r,vx,vy,vz,fixed\n1,2,3,1,0,0,0,2\n"), "fixed: 2 is not allowed");
  EXPECT_CONTAINS(
      refusal("x,y,z,r,vx,vy,vz,material\n1,2,3,1,0,0,0,stel\n"),
      "p.csv:2: material 'stel' does not exist (did you mean 'steel'?) (allowed: glass, steel, or an index");
  EXPECT_CONTAINS(refusal("x,y,z,r,vx,vy,vz,material\n1,2,3,1,0,0,0,2\n"), "material '2' does not exist");
}

constexpr const char* k_lammps = R"(a title that mentions 5 atoms

3 atoms
2 atom types
0.0 10.0 xlo xhi
-1 1 ylo yhi
0 45 zlo zhi

Atoms # sphere

7 2 0.4 7800 1 0 3 0 0 0
2 1 1.0 2500.01 2 0.5 6 # second
5 1 1.0 2500 3 0 9

Velocities

5 1 2 3 4 5 6
2 -1 0 0 0 0 0.5
)";

TEST(ParticleFile, LammpsDataFileIsReadInIdOrder) {
  const ParticleFile p = parse_particles(k_lammps, "data.txt", k_materials);
  ASSERT_EQ(p.size(), 3u);
  EXPECT_EQ(p.x[0].x, 2);
  EXPECT_EQ(p.x[1].x, 3);
  EXPECT_EQ(p.x[2].x, 1);
  EXPECT_EQ(p.r[0], 0.5);
  EXPECT_EQ(p.r[2], 0.2);
  EXPECT_EQ(p.material[0], 0);
  EXPECT_EQ(p.material[2], 1);
  EXPECT_EQ(p.v[0].x, -1);
  EXPECT_EQ(p.w[0].z, 0.5);
  EXPECT_EQ(p.v[1].z, 3);
  EXPECT_EQ(p.w[1].x, 4);
  EXPECT_EQ(p.v[2].x, 0);
  EXPECT_EQ(p.row[2], 11);
  ASSERT_TRUE(p.box.has_value());
  EXPECT_EQ((*p.box)[0].y, -1);
  EXPECT_EQ((*p.box)[1].z, 45);
}

TEST(ParticleFile, LammpsErrorsNameFileAndRow) {
  const auto broken = [](const std::string& from, const std::string& to) {
    std::string text = k_lammps;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return refusal(text.replace(at, from.size(), to));
  };
  EXPECT_CONTAINS(broken("3 atoms", "4 atoms"), "3 particles, but the header says 4");
  EXPECT_CONTAINS(broken("7 2 0.4", "7 3 0.4"), "p.csv:11: type 3 has no material");
  EXPECT_CONTAINS(broken("0.4 7800", "0.4 7700"), "p.csv:11: density 7700 of type 2 differs from 7800");
  EXPECT_CONTAINS(broken("7 2 0.4", "7 2 -0.4"), "p.csv:11: diameter");
  EXPECT_CONTAINS(broken("5 1 1.0", "2 1 1.0"), "p.csv:13: id 2 is given twice");
  EXPECT_CONTAINS(broken("5 1 2 3", "9 1 2 3"), "p.csv:17: id 9 is not among the atoms");
  EXPECT_CONTAINS(broken("Velocities", "Velocites"),
                  "section 'Velocites' is not supported (did you mean 'Velocities'?)");
  EXPECT_CONTAINS(broken("2 atom types", "2 atomtypes"), "p.csv:4: header line '2 atomtypes' is not supported");
  EXPECT_CONTAINS(broken("2 -1 0 0", "5 -1 0 0"), "p.csv:18: id 5 is given twice");
  EXPECT_CONTAINS(broken("-1 1 ylo", "1 -1 ylo"), "p.csv:6: box bounds '1 -1 ylo yhi' do not ascend");
  EXPECT_CONTAINS(broken(" 0 0 0\n", " 0 0\n"), "p.csv:11: 9 values in a row of Atoms");
}

TEST(ParticleFile, GzipFilesAreReadAndTruncatedOnesRefused) {
  const TemporaryFile whole("whole.csv.gz"), cut("cut.csv.gz");
  std::string text = "x,y,z,r,vx,vy,vz\n";
  for (int i = 0; i < 5000; ++i) text += fmt::format("{},{},{},0.5,0,0,0\n", i * 1.01, i * 0.37, i % 17);
  gzFile out = gzopen(whole.path().c_str(), "wb");
  ASSERT_EQ(gzwrite(out, text.data(), static_cast<unsigned>(text.size())), static_cast<int>(text.size()));
  gzclose(out);
  EXPECT_EQ(read_particle_file(whole.path(), k_materials).size(), 5000u);
  std::ifstream in(whole.path(), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  std::ofstream(cut.path(), std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  EXPECT_THROW(read_particle_file(cut.path(), k_materials), Error);
  try {
    read_particle_file("/nonexistent.csv", k_materials);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.exit_code(), 3);
    EXPECT_CONTAINS(e.what(), "/nonexistent.csv: cannot open");
  }
}

TEST(ParticleFile, AHundredThousandRowsAreReadInTheirOrder) {
  std::string text = "x,y,z,r,vx,vy,vz,wx,wy,wz,fixed\n";
  constexpr int rows = 128000;
  for (int i = 0; i < rows; ++i)
    text += fmt::format("{:.9g},{:.9g},{:.9g},0.5,{:.9g},-1.2345e-05,0.1,0.2,0.3,0.4,0\n", i * 0.123, i * 1.7, i / 3.0,
                        i * 1e-9);
  const ParticleFile p = parse_particles(text, "big.csv", k_materials);
  ASSERT_EQ(p.size(), static_cast<std::size_t>(rows));
  for (const int i : {0, 1, 65536, rows - 1}) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR(p.x[k].x, i * 0.123, 1e-8 * (1 + i * 0.123));
    EXPECT_NEAR(p.x[k].z, i / 3.0, 1e-8 * (1 + i / 3.0));
    EXPECT_NEAR(p.v[k].x, i * 1e-9, 1e-14);
  }
}

}  // namespace
}  // namespace talus
