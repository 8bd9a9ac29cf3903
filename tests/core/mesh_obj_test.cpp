// Claims about OBJ files: only vertices and faces matter, in every notation; indices out of range, crossing polygons
// and geometry that would be left out are refused with their line.
#include <cmath>

#include "core/base/rng.hpp"
#include "core/meshes/mesh_polygon.hpp"
#include "mesh_support.hpp"

namespace talus {
namespace {

using namespace mesh_test;

const std::string k_quads = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

TEST(ObjFile, DialectsReadAlike) {
  const std::string v = obj_vertices(), plain = box_obj();
  std::string slashes, textured, missing, negative;
  for (const auto& f : k_box) {
    slashes += "f", textured += "f", missing += "f", negative += "f";
    for (const int c : f) {
      const std::string n = std::to_string(c + 1);
      slashes += " " + n + "//1";
      textured += " " + n + "/" + n;
      missing += " " + n + "/99/-1";
      negative += " " + std::to_string(c - 8);
    }
    slashes += "\n", textured += "\n", missing += "\n", negative += "\n";
  }
  const std::pair<const char*, std::string> dialects[] = {
      {"plain", plain},
      {"quads", v + k_quads},
      {"vn", v + "vn 0 0 1\n" + slashes},
      {"vt", v + "vt 0 0\n" + textured},
      {"vt missing", v + missing},
      {"negative", v + negative},
      {"faces first", box_obj().substr(v.size()) + v},
      {"materials", "mtllib ../nowhere/no.mtl\no a\ng b c\nusemtl none\ns off\n" + plain},
      {"weights", replaced(v, "\n", " 1.0\n") + k_quads},
      {"colours", replaced(v, "\n", " 0.1 0.2 0.3\n") + k_quads},
      {"continued", v + replaced(k_quads, " 3 ", " \\\n 3 ")},
      {"CR LF", replaced(plain, "\n", "\r\n")},
      {"continued, CR LF", replaced(v + replaced(k_quads, " 3 ", " \\\n3 "), "\n", "\r\n")},
      {"comments", "# a\n" + replaced(plain, "\nf", " # end\nf")},
      {"byte order mark", "\xef\xbb\xbf" + plain},
      {"upper case", replaced(replaced(plain, "v ", "V "), "f ", "F ")},
      {"Fortran", replaced(plain, " 0.25", " 2.5D-01")},
      {"lines and points", plain + "l 1 2\np 3\n"},
      {"blanks", replaced(replaced(plain, " ", " \t "), "\n", " \n\n")},
  };
  for (const auto& [what, text] : dialects) expect_box(parse("a.obj", text), what);
}

TEST(ObjFile, NegativeIndicesCountFromTheVerticesBeforeThem) {
  const Mesh m = parse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf -3 -2 -1\n");
  ASSERT_EQ(m.size(), 2);
  EXPECT_EQ(m.points[m.facets[0][0]].z, 0);
  EXPECT_EQ(m.points[m.facets[1][0]].z, 5);
  EXPECT_EQ(m.report.parts, 2);
}

TEST(ObjFile, BadIndicesAndStatementsAreRefusedWithTheirLine) {
  const std::string v = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const std::pair<std::string, const char*> cases[] = {
      {"f 1 2 4", "vertex 4"},          {"f 1 2 3 99999999", "vertex 99999999"},
      {"f 1 2 -4", "vertex -4"},        {"f 0 1 2", "vertex 0"},
      {"f 1 2", "2 corners"},           {"f 1 2 x", "\"x\""},
      {"f 1 2 3.5", "\"3.5\""},         {"f 1 2 99999999999999999999", "99999999999999999999"},
      {"v 1 2", "2 numbers"},           {"v 1 2 nan", "not finite"},
      {"v 1 2 3 4 5", "5 numbers"},     {"v 1 2 3 2", "weight 2"},
      {"surf 0 1 0 1 1 2", "\"surf\""}, {"call other.obj", "another file"},
      {"hello", "\"hello\""},           {std::string("f 1 2 3\0", 8), "\"3\\x00\""},
  };
  for (const auto& [line, part] : cases) {
    const std::string m = refusal("a.obj", v + line + "\nf 1 2 3\n");
    expect_in(m, "a.obj:4");
    expect_in(m, part);
  }
  expect_in(refusal("a.obj", v), "no facets");
  expect_in(refusal("a.obj", "f 1 2 3\n"), "no vertices");
}

double area(const Mesh& m) {
  double sum = 0;
  for (const auto& f : m.facets)
    sum += 0.5 * norm(cross(m.points[f[1]] - m.points[f[0]], m.points[f[2]] - m.points[f[0]]));
  return sum;
}

TEST(ObjFile, ConcavePolygonsAreCoveredOnce) {
  // an L, a comb, a keyhole (square ring with a bridge), in a slanted plane; areas by hand
  const auto slanted = [](const std::vector<std::array<double, 2>>& p) {
    std::string s;
    char line[120];
    for (const auto& q : p) {  // unit vectors (0.6, 0, 0.8) and (0, 1, 0)
      std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", 0.6 * q[0], q[1], 0.8 * q[0]);
      s += line;
    }
    s += "f";
    for (std::size_t k = 0; k < p.size(); ++k) s += " " + std::to_string(k + 1);
    return s + "\n";
  };
  const Mesh l = parse("l.obj", slanted({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}));
  EXPECT_EQ(l.size(), 4);
  EXPECT_NEAR(area(l), 3, 1e-14);
  const Mesh comb =
      parse("c.obj",
            slanted({{0, 0}, {5, 0}, {5, 3}, {4, 3}, {4, 1}, {3, 1}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}));
  EXPECT_NEAR(area(comb), 5 + 3 * 2, 1e-13);
  EXPECT_EQ(comb.report.open_edges, 12);
  const std::string ring = slanted({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {1, 1}, {2, 1}, {2, 2}, {1, 2}});
  const Mesh keyhole = parse("k.obj", ring.substr(0, ring.find("f")) + "f 1 2 3 4 1 5 8 7 6 5\n");
  EXPECT_NEAR(area(keyhole), 8, 1e-13);
  EXPECT_EQ(keyhole.report.open_edges, 8);
  // corners on straight sides stay corners of triangles: the neighbours of a side share them
  const Mesh straight = parse("s.obj", slanted({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 3}, {1.5, 3}, {0, 3}}));
  EXPECT_EQ(straight.size(), 5);
  EXPECT_NEAR(area(straight), 9, 1e-13);
}

TEST(ObjFile, PolygonsThatCrossThemselvesAreRefused) {
  expect_in(refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 3 2 4\n"), "crosses itself");
  expect_in(refusal("a.obj", "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 0 1 0\nf 1 3 2 4\n"), "a.obj:5");
  expect_in(refusal("a.obj", "v 0 0 0\nv 3 0 0\nv 1 1 0\nv 0 5 0\nv 3 3 0\nf 1 2 3 4 5\n"), "a.obj:6");
}

TEST(ObjFile, RandomStarPolygonsAreCoveredOnce) {
  const CounterRng rng(3, 9);
  std::uint64_t draw = 0;
  for (int round = 0; round < 200; ++round) {
    const int n = 4 + round % 40;
    std::vector<Vec3> p;
    double twice = 0;
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * M_PI * k / n, r = rng.uniform(draw++, 0.1, 1);
      p.push_back({1e5 + r * std::cos(angle), -2e5 + r * std::sin(angle), 7});
    }
    for (int k = 0; k < n; ++k) twice += cross(p[k] - p[0], p[(k + 1) % n] - p[0]).z;
    std::vector<std::array<std::int32_t, 3>> cut;
    std::int64_t budget = 1000000;
    ASSERT_TRUE(mesh_io::triangulate(p, cut, budget));
    ASSERT_EQ(cut.size(), static_cast<std::size_t>(n - 2));
    double covered = 0;
    for (const auto& t : cut) {
      const double a = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]).z;
      ASSERT_GE(a, -1e-9);
      covered += a;
    }
    ASSERT_NEAR(covered, twice, 1e-9);
  }
}

TEST(ObjFile, CuttingPolygonsTakesBoundedWork) {
  // a spiral needs many tries per ear; the budget ends it
  std::vector<Vec3> p;
  for (int k = 0; k < 500; ++k)
    p.push_back({(1 + k * 1e-3) * std::cos(0.05 * k), (1 + k * 1e-3) * std::sin(0.05 * k), 0});
  for (int k = 499; k >= 0; --k)
    p.push_back({(0.98 + k * 1e-3) * std::cos(0.05 * k), (0.98 + k * 1e-3) * std::sin(0.05 * k), 0});
  std::vector<std::array<std::int32_t, 3>> cut;
  std::int64_t small = 20000, large = 100'000'000;
  EXPECT_FALSE(mesh_io::triangulate(p, cut, small));
  EXPECT_LT(small, 0);
  EXPECT_TRUE(cut.empty());
  EXPECT_TRUE(mesh_io::triangulate(p, cut, large));
}

}  // namespace
}  // namespace talus
