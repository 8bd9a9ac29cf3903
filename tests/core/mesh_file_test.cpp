// Claims about meshes whatever their format: coordinates keep every bit on the way into the frame, tolerances are those
// of the vertices concerned, defects are counted, and files that are none are refused by name.
#include "core/meshes/mesh_file.hpp"

#include <sys/stat.h>

#include <cmath>

#include "core/base/rng.hpp"
#include "core/walls/wall_mesh.hpp"
#include "mesh_support.hpp"
#include "wall_support.hpp"

namespace talus {
namespace {

using namespace mesh_test;
using wall_test::folder;
using wall_test::write_file;

std::vector<Triangle> tetrahedron() {
  const Vec3 o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  return {{o, y, x}, {o, x, z}, {o, z, y}, {x, y, z}};
}

Mesh read(const std::string& file, const MeshFrame& frame = {}) { return read_mesh(file, frame, 0); }

std::string message_of(const std::string& file, double largest = 0) {
  try {
    read_mesh(file, {}, largest);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "no error";
}

TEST(MeshFile, FormatsReadAlike) {
  for (const auto& [name, bytes] : {std::pair("t.stl", text_stl()), std::pair("b.STL", binary_stl()),
                                    std::pair("o.obj", box_obj()), std::pair("p.ply", box_ply_text())})
    expect_box(read(write_file(name, bytes)), name);
}

TEST(MeshFile, DegenerateAndDuplicateFacetsAreDroppedAndCounted) {
  auto t = tetrahedron();
  t.push_back({Vec3{0, 0, 0}, Vec3{0.5, 0, 0}, Vec3{1, 0, 0}});  // collinear
  t.push_back({Vec3{0, 1, 0}, Vec3{0, 1, 0}, Vec3{1, 0, 0}});    // two equal vertices
  t.push_back({t[2][2], t[2][0], t[2][1]});                      // a facet again, started elsewhere
  const Mesh m = read(wall_test::write_stl("defects.stl", t));
  EXPECT_EQ(m.facets.size(), 4u);
  EXPECT_EQ(m.report.facets_read, 7);
  EXPECT_EQ(m.report.degenerate, 2);
  EXPECT_EQ(m.report.duplicate, 1);
  EXPECT_TRUE(m.report.watertight);
  expect_in(doubts(m.report, 0), "2 of 7 facets have no area");
}

TEST(MeshFile, ANeedleThatClosesTheMeshKeepsItWatertight) {
  // the edge from x to y of one face is split by a vertex that lies on it; a facet without area joins the two sides
  const Vec3 o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, h{0.5, 0.5, 0};
  const Mesh m =
      read(wall_test::write_stl("split.stl", {{o, y, x}, {o, x, z}, {o, z, y}, {x, h, z}, {h, y, z}, {x, y, h}}));
  EXPECT_EQ(m.report.degenerate, 1);
  EXPECT_EQ(m.size(), 5);
  EXPECT_TRUE(m.report.watertight);
  EXPECT_NEAR(m.report.volume, 1.0 / 6, 1e-15);
}

TEST(MeshFile, NeedlesUpToAMillionAreNotDegenerate) {
  const Mesh m = read(wall_test::write_stl("needle.stl", {{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1e-6, 0}}}));
  EXPECT_EQ(m.facets.size(), 1u);
}

TEST(MeshFile, SliversThatTheRoundingOfTheFileMakesAreDroppedAndSmallFacetsStay) {
  // coordinates near 1000 with three decimals: what is lower than half a unit of the last place, 0.5e-3, may be
  // rounding
  const auto dropped = [](const char* a, const char* b, const char* c, double scale) {
    const std::string good = "v 1000.000 5.000 0\nv 1003.123 5.000 0\nv 1000.000 9.000 0\nf 1 2 3\n";
    const Mesh m = parse("a.obj", good + "v " + a + " 0\nv " + b + " 0\nv " + c + " 0\nf 4 5 6\n", {scale, {}, {}});
    EXPECT_NEAR(m.report.rounding, 1e-3 * scale, 1e-6 * scale);
    return m.report.degenerate;
  };
  for (const double scale : {1.0, 0.001, 1000.0}) {
    // the line from the first to the second rises by a unit: the third is 0.25, then 0.75 units off it
    EXPECT_EQ(dropped("1000.000 0.000", "1001.000 0.001", "1000.250 0.000", scale), 1) << scale;
    EXPECT_EQ(dropped("1000.000 0.000", "1001.000 0.001", "1000.250 0.001", scale), 0) << scale;
    // a third of a unit high, but three units long: this is no sliver, it is small
    EXPECT_EQ(dropped("1000.000 0.000", "1000.003 0.001", "1000.001 0.000", scale), 0) << scale;
  }
  // the same sliver near the origin, where three decimals say more than they round
  const std::string near = "v 0.000 0.000 0\nv 1.000 0.001 0\nv 0.250 0.000 0\nf 1 2 3\n";
  EXPECT_EQ(parse("a.obj", near).report.degenerate, 0);
}

TEST(MeshFile, AMeshInMillimetresActsAsTheOneInMetres) {
  // a plate at z = 0.125 after the shift, and grains of 0.05 m on it, beside it and away from it
  const auto wall = [](double unit) {
    std::vector<Vec3> p{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    for (Vec3& x : p) x = unit * x;
    WallSpec w = wall_test::mesh_wall(wall_test::write_obj("plate.obj", p, {{0, 1, 2}, {1, 3, 2}}));
    w.scale = 1 / unit;
    w.shift = {0.25, -0.5, 0.125};
    return WallSet(wall_test::scene_with({w}), 0.1);
  };
  for (const double unit : {1.0, 1000.0}) {
    const WallSet walls = wall(unit);
    const auto on = wall_test::touch(walls, {0.5, 0, 0.165}, 0.05),
               rim = wall_test::touch(walls, {1.28, 0, 0.125}, 0.05);
    ASSERT_EQ(on.size(), 1U) << unit;
    EXPECT_NEAR(on[0].distance, 0.04, 1e-15);
    EXPECT_NEAR(on[0].normal.z, 1, 1e-15);
    ASSERT_EQ(rim.size(), 1U) << unit;
    EXPECT_NEAR(rim[0].distance, 0.03, 1e-15) << "the plate ends at x = 1.25";
    EXPECT_EQ(wall_test::touch(walls, {0.5, 0, 0.18}, 0.05).size(), 0U);
    EXPECT_EQ(wall_test::touch(walls, {1.31, 0, 0.125}, 0.05).size(), 0U);
  }
}

TEST(MeshFile, FlippedFacetsAndForkedEdgesAreCounted) {
  auto t = tetrahedron();
  std::swap(t[1][0], t[1][1]);
  const Mesh flipped = read(wall_test::write_stl("flipped.stl", t));
  EXPECT_EQ(flipped.report.flipped, 1);
  EXPECT_NEAR(flipped.report.volume, 1.0 / 6, 1e-15);  // as if it were turned
  t = tetrahedron();
  t.push_back({Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, -1, -1}});
  const Mesh m = read(wall_test::write_stl("forked.stl", t));
  EXPECT_EQ(m.report.forked_edges, 1);
  EXPECT_EQ(m.report.open_edges, 2);
  EXPECT_EQ(m.report.volume, 0);
  EXPECT_FALSE(m.report.watertight);
}

TEST(MeshFile, HollowsAreTakenOffTheVolume) {
  std::string s = box_obj();
  for (const Vec3& p : box_points(0.5, 0.5, 0.125)) {
    char line[120];
    std::snprintf(line, sizeof line, "v %g %g %g\n", p.x + 0.25, p.y + 0.25, p.z + 0.0625);
    s += line;
  }
  std::string inside = s;
  for (const auto& f : k_box) {
    s += "f " + std::to_string(f[0] + 9) + " " + std::to_string(f[1] + 9) + " " + std::to_string(f[2] + 9) + "\n";
    inside += "f " + std::to_string(f[0] + 9) + " " + std::to_string(f[2] + 9) + " " + std::to_string(f[1] + 9) + "\n";
  }
  EXPECT_DOUBLE_EQ(parse("a.obj", s).report.volume, 0.25 + 0.03125);
  EXPECT_DOUBLE_EQ(parse("a.obj", inside).report.volume, 0.25 - 0.03125);
  EXPECT_EQ(parse("a.obj", s).report.parts, 2);
}

TEST(MeshFile, CoordinatesKeepEveryBitOnTheWayIntoTheFrame) {
  // file - 500123.25 and the corner leave small numbers that are known to all digits
  const MeshFrame utm{1, {-500123.25, -5200456.75, -812.5}, {-0.3, 0.1, 1.0 / 3}};
  const CounterRng rng(5, 5);
  for (std::uint64_t k = 0; k < 2000; ++k) {
    Vec3 file, frame;
    std::string s;
    char line[120];
    for (int v = 0; v < 3; ++v) {
      file = {500123.25 + rng.uniform(100 * k + v, 0, 50), 5200456.75 + rng.uniform(100 * k + v + 3, 0, 50),
              812.5 + rng.uniform(100 * k + v + 6, 0, 50)};
      std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", file.x, file.y, file.z);
      s += line;
    }
    const Mesh m = parse("a.obj", s + "f 1 2 3\n", utm);
    for (int a = 0; a < 3; ++a)  // of the last vertex: the difference of neighbouring doubles is exact
      frame[a] = static_cast<double>(static_cast<long double>(file[a] + utm.shift[a]) - utm.corner[a]);
    const Vec3 got = m.points[m.facets[0][2]];
    for (int a = 0; a < 3; ++a) ASSERT_EQ(got[a], frame[a]);
  }
  // millimetres: the product is not rounded before the shift
  const Mesh mm = parse("a.obj", "v 500123250.3 0 0\nv 500123251.3 0 0\nv 500123250.3 1 0\nf 1 2 3\n",
                        {0.001, {-500123.25, 0, 0}, {}});
  const auto exact = static_cast<double>(500123250.3L * 0x1p0L * static_cast<long double>(0.001) - 500123.25L);
  EXPECT_NEAR(mm.points[0].x,
              static_cast<double>(static_cast<long double>(500123250.3) * static_cast<long double>(0.001) - 500123.25L),
              1e-13);
  EXPECT_NEAR(exact, 0.0003, 1e-7);
}

TEST(MeshFile, SmallCellsFarFromTheOriginAreNoNeedles) {
  for (const double east : {0.0, 500123.25}) {
    std::string s;
    char line[120];
    for (int j = 0; j <= 20; ++j)
      for (int i = 0; i <= 20; ++i) {
        std::snprintf(line, sizeof line, "v %.10g %.10g %.10g\n", east + 0.05 * i, 10 * east + 0.05 * j,
                      0.01 * std::sin(i + j));
        s += line;
      }
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) {
        const int a = j * 21 + i + 1;
        s += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + 22) + "\nf " +
             std::to_string(a) + " " + std::to_string(a + 22) + " " + std::to_string(a + 21) + "\n";
      }
    const Mesh m = parse("a.obj", s, {1, {-east, -10 * east, 0}, {}});
    EXPECT_EQ(m.size(), 800);
    EXPECT_EQ(m.report.dropped(), 0);
    EXPECT_EQ(m.report.open_edges, 80);
    EXPECT_LT(flatness(make_facets(m)), 1e-3 * 0.05);
  }
}

TEST(MeshFile, AValleyFarFromTheOriginIsTheSameToTheBit) {
  // two slopes of 45 degrees that meet at x = 0; a grain between them touches both
  const auto valley = [](double east, bool binary) {
    const Vec3 p[] = {{east - 1, 0, 1}, {east - 1, 2, 1}, {east, 0, 0},
                      {east, 2, 0},     {east + 1, 0, 1}, {east + 1, 2, 1}};
    const std::vector<std::array<int, 3>> facets{{0, 2, 1}, {1, 2, 3}, {2, 4, 3}, {3, 4, 5}};
    std::string s(80, ' ');
    put(s, std::uint32_t{4});
    for (const auto& f : facets) {
      s.append(12, '\0');
      for (const int v : f)
        for (int k = 0; k < 3; ++k) put(s, static_cast<float>(p[v][k]));
      s.append(2, '\0');
    }
    WallSpec w = wall_test::mesh_wall(binary ? write_file("valley.stl", s)
                                             : wall_test::write_obj("valley.obj", {p, p + 6}, facets));
    w.shift = {-east, 0, 0};
    w.corner = {-0.1, 0.3, 0.7};
    return WallSet(wall_test::scene_with({w}), 0.2);
  };
  for (const bool binary : {false, true}) {
    const WallSet near = valley(0, binary), far = valley(524288, binary);
    for (const double x : {-0.01, 0.0, 0.013}) {
      const Vec3 c{x + 0.1, 1 - 0.3, 0.0957 - 0.7};
      const auto a = wall_test::touch(near, c, 0.08), b = wall_test::touch(far, c, 0.08);
      ASSERT_EQ(a.size(), 2U);
      ASSERT_EQ(b.size(), 2U);
      for (int k = 0; k < 2; ++k) {
        EXPECT_EQ(a[k].distance, b[k].distance);
        EXPECT_EQ(a[k].normal.x, b[k].normal.x);
      }
    }
  }
}

TEST(MeshFile, TheBallAroundAFacetIsConservativeAnywhere) {
  // the ball is single precision: what it lets out must be out, however far from the corner of the frame
  const CounterRng rng(8, 1);
  std::uint64_t n = 0, out = 0;
  const auto draw = [&](double size) {
    return Vec3{rng.uniform(n++, -size, size), rng.uniform(n++, -size, size), rng.uniform(n++, -size, size)};
  };
  for (int k = 0; k < 30000; ++k) {
    const Vec3 at = draw(k % 3 == 0 ? 1.0 : (k % 3 == 1 ? 1e4 : 1e7));
    const double size = k % 2 == 0 ? 1e-3 : 1;
    const TriangleElement t = make_triangle(at + draw(size), at + draw(size), at + draw(size));
    const Vec3 c = at + draw(3 * size);
    const double distance = closest(t, c).distance;
    ElementHit hit;
    // just above the distance: must not be let out
    ASSERT_TRUE(closest_within(t, c, distance * (1 + 1e-9) + 1e-15 * norm(at), hit)) << k;
    out += closest_within(t, c, 0.5 * distance, hit) ? 0 : 1;
  }
  EXPECT_GT(out, 20000U);
}

TEST(MeshFile, CoarseCoordinatesAreDoubtedWhereGrainsNeedMore) {
  const auto terrain = [](const char* format, double east) {
    std::string s;
    char line[120];
    for (const Vec3& p : {Vec3{0, 0, 0}, Vec3{5.25, 0, 0.123456}, Vec3{0, 5.25, 0.654321}}) {
      std::snprintf(line, sizeof line, format, p.x + east, p.y + 10 * east, p.z + 812.5);
      s += line;
    }
    return parse("a.obj", s + "f 1 2 3\n").report;
  };
  const char *all = "v %.17g %.17g %.17g\n", *six = "v %g %g %g\n", *cents = "v %.2f %.2f %.2f\n";
  EXPECT_EQ(doubts(terrain(all, 500123.25), 0.01), "");
  EXPECT_NEAR(terrain(six, 500123.25).rounding, 10, 1e-9);  // 5.00123e+06
  expect_in(doubts(terrain(six, 500123.25), 0.01), "given to 10 m only");
  EXPECT_NEAR(terrain(cents, 500123.25).rounding, 0.01, 1e-12);
  EXPECT_NE(doubts(terrain(cents, 500123.25), 0.1), "");
  EXPECT_EQ(doubts(terrain(cents, 500123.25), 20), "");
  EXPECT_EQ(doubts(parse("a.obj", box_obj()).report, 1e-3), "");  // few digits are exact, and so are whole numbers
  EXPECT_EQ(doubts(parse("a.obj", "v 524287 0 1\nv 524288 0 0\nv 524288 2 0\nf 1 2 3\n").report, 1e-3), "");
  // single precision, in a binary file and printed with too many digits
  const MeshReport binary = parse("a.stl", binary_stl()).report;
  EXPECT_EQ(binary.rounding, 0x1p-23);
  std::string s = "v 5200456.5 0 0\nv 5200457.00000000 1 0\nv 5200456.5 0 1\nf 1 2 3\n";
  EXPECT_NEAR(parse("a.obj", s).report.rounding, 0x1p-23 * 5200457, 1e-9);
}

TEST(MeshFile, BordersThatDifferByRoundingAreJoinedAndOthersAreNot) {
  const auto two = [](double gap) {
    char s[300];
    std::snprintf(s, sizeof s,
                  "v 100.1 0 0\nv 101.1 0 0\nv 100.1 1 0\nv %.17g 0 0\nv %.17g 1 0\nv 101.1 1.1 0\nf 1 2 3\nf 4 6 5\n",
                  101.1 + gap, 100.1 + gap);
    return parse("a.obj", s).report;
  };
  EXPECT_EQ(two(0).open_edges, 4);
  EXPECT_EQ(two(1.5e-14).open_edges, 4);  // one unit in the last place
  EXPECT_EQ(two(1.5e-14).welded, 2);
  EXPECT_EQ(two(1.2345678901234e-9).open_edges, 6);
  EXPECT_EQ(two(1.2345678901234e-9).welded, 0);
}

TEST(MeshFile, BrokenFilesAreRefusedByName) {
  const std::string missing = message_of((folder() / "none.stl").string());
  expect_in(missing, "none.stl");
  expect_in(missing, "No such file");
  expect_in(message_of(write_file("empty.stl", "")), "empty");
  expect_in(message_of(write_file("mesh.step", "x")), "stl, obj, ply");
  expect_in(message_of(write_file("mesh", "x")), "stl, obj, ply");
  EXPECT_NE(message_of(write_file("text.ply", "hello, this is no mesh at all\n")), "no error");
  const std::string fifo = (folder() / "fifo.stl").string();
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  expect_in(message_of(fifo), "FIFO");
  std::filesystem::create_directory(folder() / "folder.obj");
  expect_in(message_of((folder() / "folder.obj").string()), "a folder");
}

TEST(MeshFile, VerticesOutOfReachNameTheirFacet) {
  auto t = tetrahedron();
  t[2][1].y = 1e13;
  const std::string m = message_of(wall_test::write_stl("far.stl", t));
  expect_in(m, "facet 3");
  expect_in(m, "1e12 m");
  std::string s = binary_stl();
  const float nan = NAN;
  std::memcpy(s.data() + 84 + 2 * 50 + 12 + 4, &nan, 4);
  expect_in(refusal("nan.stl", s), "facet 3 (byte 200)");
}

TEST(MeshFile, MostlyDegenerateAndTooSmallMeshesAreRefused) {
  const Vec3 o{0, 0, 0}, x{1, 0, 0}, h{0.5, 0, 0};
  const std::string m = message_of(wall_test::write_stl("flat.stl", {{o, x, Vec3{0, 1, 0}}, {o, h, x}, {o, x, h}}));
  expect_in(m, "facet 2");
  const std::string small = message_of(wall_test::write_stl("small.stl", tetrahedron()), 2.0);
  expect_in(small, "scale");
  EXPECT_EQ(message_of(wall_test::write_stl("small.stl", tetrahedron()), 1.0), "no error");
}

}  // namespace
}  // namespace talus
