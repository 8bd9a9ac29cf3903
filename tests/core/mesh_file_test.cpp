// Claims about mesh files: three formats read alike, broken files are refused with file and facet, defects are counted.
#include "core/io/mesh_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/error.hpp"
#include "core/rng.hpp"
#include "wall_support.hpp"

namespace talus {
namespace {

using namespace wall_test;

std::vector<Triangle> tetrahedron() {
  const Vec3 o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  return {{o, y, x}, {o, x, z}, {o, z, y}, {x, y, z}};
}

std::string binary_stl(const std::vector<Triangle>& triangles, std::uint32_t claimed) {
  std::string s(80, ' ');
  auto put = [&](const void* p, std::size_t n) { s.append(static_cast<const char*>(p), n); };
  put(&claimed, 4);
  for (const Triangle& t : triangles) {
    const float zero[3] = {0, 0, 0};
    put(zero, 12);
    for (const Vec3 v : t) {
      const float f[3] = {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
      put(f, 12);
    }
    s.append(2, '\0');
  }
  return s;
}

std::string message_of(const std::string& file, double largest = 0) {
  try {
    read_mesh(file, 1, {}, largest);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "no error";
}

TEST(MeshFile, FormatsReadAlike) {
  const auto t = tetrahedron();
  const std::vector<std::string> files{
      write_stl("tetra_ascii.stl", t), write_file("tetra_binary.STL", binary_stl(t, 4)),
      write_obj("tetra.obj", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}),
      write_file("tetra.ply",
                 "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
                 "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")};
  for (const std::string& f : files) {
    const Mesh m = read_mesh(f, 0.5, {1, 2, 3}, 0);
    ASSERT_EQ(m.facets.size(), 4u) << f;
    EXPECT_EQ(m.points.size(), 4u) << f;
    EXPECT_TRUE(m.report.watertight) << f;
    EXPECT_EQ(m.report.open_edges, 0);
    EXPECT_EQ(m.report.flipped, 0) << f;
    EXPECT_EQ(m.report.upper.z, 3.5);
    EXPECT_EQ(m.report.lower.x, 1);
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3 a = m.points[m.facets[k][0]];
      EXPECT_EQ(a.x, 1 + 0.5 * t[k][0].x) << f;
    }
  }
}

TEST(MeshFile, PolygonsAreCutIntoTriangles) {
  const std::string f = write_file("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const Mesh m = read_mesh(f, 1, {}, 0);
  EXPECT_EQ(m.facets.size(), 2u);
  EXPECT_EQ(m.report.open_edges, 4);
  EXPECT_FALSE(m.report.watertight);
}

TEST(MeshFile, DegenerateAndDuplicateFacetsAreDroppedAndCounted) {
  auto t = tetrahedron();
  t.push_back({Vec3{0, 0, 0}, Vec3{0.5, 0, 0}, Vec3{1, 0, 0}});  // collinear
  t.push_back({Vec3{0, 1, 0}, Vec3{0, 1, 0}, Vec3{1, 0, 0}});    // two equal vertices
  t.push_back({t[2][2], t[2][0], t[2][1]});                      // a facet again, started elsewhere
  const Mesh m = read_mesh(write_stl("defects.stl", t), 1, {}, 0);
  EXPECT_EQ(m.facets.size(), 4u);
  EXPECT_EQ(m.report.facets_read, 7);
  EXPECT_EQ(m.report.degenerate, 2);
  EXPECT_EQ(m.report.duplicate, 1);
  EXPECT_TRUE(m.report.watertight);
}

TEST(MeshFile, NeedlesUpToAMillionAreNotDegenerate) {
  const Mesh m = read_mesh(write_stl("needle.stl", {{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1e-6, 0}}}), 1, {}, 0);
  EXPECT_EQ(m.facets.size(), 1u);
}

TEST(MeshFile, FlippedFacetsAndForkedEdgesAreCounted) {
  auto t = tetrahedron();
  std::swap(t[1][0], t[1][1]);
  EXPECT_EQ(read_mesh(write_stl("flipped.stl", t), 1, {}, 0).report.flipped, 1);
  t = tetrahedron();
  t.push_back({Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, -1, -1}});
  const Mesh m = read_mesh(write_stl("forked.stl", t), 1, {}, 0);
  EXPECT_EQ(m.report.forked_edges, 1);
  EXPECT_EQ(m.report.open_edges, 2);
  EXPECT_FALSE(m.report.watertight);
}

TEST(MeshFile, BrokenFilesAreRefusedByName) {
  const std::string missing = message_of((folder() / "none.stl").string());
  EXPECT_NE(missing.find("none.stl"), std::string::npos) << missing;
  EXPECT_NE(missing.find("no such file"), std::string::npos) << missing;
  EXPECT_NE(message_of(write_file("empty.stl", "")).find("empty"), std::string::npos);
  EXPECT_NE(message_of(write_file("mesh.step", "x")).find("stl, obj, ply"), std::string::npos);
  EXPECT_NE(message_of(write_file("short.stl", binary_stl(tetrahedron(), 4).substr(0, 250))).find("bytes"),
            std::string::npos);
  EXPECT_NE(message_of(write_file("claims.stl", binary_stl(tetrahedron(), 0xffffffffu))).find("4294967295"),
            std::string::npos);
  EXPECT_NE(message_of(write_file("none_binary.stl", binary_stl({}, 0))), "no error");
  EXPECT_NE(message_of(write_file("only.obj", "v 0 0 0\nv 1 0 0\n")), "no error");
  EXPECT_NE(message_of(write_file("text.ply", "hello, this is no mesh at all\n")), "no error");
  EXPECT_NE(message_of(write_file("text.stl", "solid\nfacet nonsense\n")), "no error");
  EXPECT_NE(message_of(folder().string()), "no error");
}

TEST(MeshFile, NonFiniteVertexNamesItsFacet) {
  auto t = tetrahedron();
  t[2][1].y = NAN;
  const std::string m = message_of(write_file("nan.stl", binary_stl(t, 4)));
  EXPECT_NE(m.find("nan.stl"), std::string::npos) << m;
  EXPECT_NE(m.find("facet 3"), std::string::npos) << m;
  t[2][1].y = INFINITY;
  EXPECT_NE(message_of(write_file("inf.stl", binary_stl(t, 4))).find("facet 3"), std::string::npos);
}

TEST(MeshFile, MostlyDegenerateAndTooSmallMeshesAreRefused) {
  const Vec3 o{0, 0, 0}, x{1, 0, 0}, h{0.5, 0, 0};
  const std::string m = message_of(write_stl("flat.stl", {{o, x, Vec3{0, 1, 0}}, {o, h, x}, {o, x, h}}));
  EXPECT_NE(m.find("facet 2"), std::string::npos) << m;
  const std::string small = message_of(write_stl("small.stl", tetrahedron()), 2.0);
  EXPECT_NE(small.find("scale"), std::string::npos) << small;
  EXPECT_EQ(message_of(write_stl("small.stl", tetrahedron()), 1.0), "no error");
}

TEST(MeshFile, RandomDamageNeverYieldsABrokenMesh) {
  const std::string good = binary_stl(tetrahedron(), 4);
  std::string text =
      "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
      "endfacet\nendsolid t\n";
  const CounterRng rng(1, 2);
  std::int64_t read = 0, refused = 0;
  for (std::uint64_t k = 0; k < 600; ++k) {
    std::string s = k % 2 == 0 ? good : text;
    for (std::uint64_t i = 0; i < 3; ++i)
      s[rng.bits(10 * k + 2 * i) % s.size()] = static_cast<char>(rng.bits(10 * k + 2 * i + 1));
    if (k % 5 == 0) s.resize(rng.bits(10 * k + 7) % s.size());
    const std::string f = write_file("damaged.stl", s);
    try {
      const Mesh m = read_mesh(f, 1, {}, 0);
      ++read;
      ASSERT_FALSE(m.facets.empty());
      for (const auto& t : m.facets)
        for (const std::int32_t v : t) {
          ASSERT_LT(static_cast<std::size_t>(v), m.points.size());
          ASSERT_TRUE(std::isfinite(norm2(m.points[v])));
        }
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(read, 50);
  EXPECT_GT(refused, 50);
}

}  // namespace
}  // namespace talus
