// Meshes in memory for the tests of their readers. Who calls it: tests/core/mesh_*_test.cpp.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/meshes/mesh_file.hpp"

namespace talus::mesh_test {

using Triangle = std::array<Vec3, 3>;

inline Mesh parse(const std::string& name, const std::string& bytes, const MeshFrame& frame = {}) {
  return parse_mesh(bytes, name, frame, 0);
}

/// The message of a refusal, which is one printable line that names the file.
inline std::string refusal(const std::string& name, const std::string& bytes) {
  try {
    parse(name, bytes);
  } catch (const Error& e) {
    const std::string m = e.what();
    EXPECT_EQ(e.code(), ErrorCode::scene) << m;
    EXPECT_NE(m.find(name), std::string::npos) << m;
    for (const char c : m) EXPECT_TRUE(c >= ' ' && c <= '~') << m;
    return m;
  }
  return "no error";
}

inline void expect_in(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in: " << text;
}

/// Closed box [0, a] x [0, b] x [0, c], wound outwards: 8 vertices, 12 facets.
inline std::vector<Vec3> box_points(double a = 1, double b = 1, double c = 0.25) {
  std::vector<Vec3> p;
  for (int k = 0; k < 8; ++k) p.push_back({k & 1 ? a : 0, k & 2 ? b : 0, k & 4 ? c : 0});
  return p;
}
inline const std::vector<std::array<int, 3>> k_box{{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};

inline std::string text_stl(const std::vector<Vec3>& p = box_points(), std::size_t facets = k_box.size()) {
  std::string s = "solid part\n";
  char line[160];
  for (std::size_t f = 0; f < facets; ++f) {
    s += "  facet normal 0 0 0\n    outer loop\n";
    for (const int v : k_box[f]) {
      std::snprintf(line, sizeof line, "      vertex %.17g %.17g %.17g\n", p[v].x, p[v].y, p[v].z);
      s += line;
    }
    s += "    endloop\n  endfacet\n";
  }
  return s + "endsolid part\n";
}

template <class T>
void put(std::string& s, T value, bool big = false) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  for (std::size_t k = 0; k < sizeof(T); ++k) s += bytes[big ? sizeof(T) - 1 - k : k];
}

inline std::string binary_stl(std::uint32_t stated = 12, const std::string& header = "part") {
  std::string s = header;
  s.resize(80, ' ');
  put(s, stated);
  for (const auto& f : k_box) {
    for (int k = 0; k < 3; ++k) put(s, 0.0F);
    for (const int v : f)
      for (int k = 0; k < 3; ++k) put(s, static_cast<float>(box_points()[v][k]));
    s.append(2, '\0');
  }
  return s;
}

inline std::string obj_vertices() {
  std::string s;
  char line[160];
  for (const Vec3& p : box_points()) {
    std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x, p.y, p.z);
    s += line;
  }
  return s;
}
inline std::string box_obj() {
  std::string s = obj_vertices();
  for (const auto& f : k_box) {
    s += "f";
    for (const int v : f) s += " " + std::to_string(v + 1);
    s += "\n";
  }
  return s;
}

inline std::string box_ply_text() {
  std::string s =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
  char line[160];
  for (const Vec3& p : box_points()) {
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g\n", p.x, p.y, p.z);
    s += line;
  }
  for (const auto& f : k_box) {
    std::snprintf(line, sizeof line, "3 %d %d %d\n", f[0], f[1], f[2]);
    s += line;
  }
  return s;
}

/// Every reader is held to this mesh.
inline void expect_box(const Mesh& m, const std::string& what = {}) {
  EXPECT_EQ(m.size(), 12) << what;
  EXPECT_EQ(m.points.size(), 8U) << what;
  EXPECT_TRUE(m.report.watertight) << what;
  EXPECT_EQ(m.report.flipped, 0) << what;
  EXPECT_DOUBLE_EQ(m.report.volume, 0.25) << what;
  EXPECT_EQ(m.report.upper.z, 0.25) << what;
  EXPECT_EQ(m.report.lower.x, 0) << what;
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

}  // namespace talus::mesh_test
