// Helpers of the wall tests: mesh files on disk, scenes with walls, one-call contacts. Who calls it: tests/core/wall*.
#pragma once

#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/base/rng.hpp"
#include "core/walls/walls.hpp"

namespace talus::wall_test {

using Triangle = std::array<Vec3, 3>;

/// A folder of this test process, removed at its end.
inline std::filesystem::path folder() {
  struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("talus_wall_test_" + std::to_string(::getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static Folder f;
  return f.path;
}

inline std::string write_file(const std::string& name, const std::string& bytes) {
  const auto path = folder() / name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path.string();
}

/// OBJ with joined vertices as given; indices from 0.
inline std::string write_obj(const std::string& name, const std::vector<Vec3>& points,
                             const std::vector<std::array<int, 3>>& facets) {
  std::string s;
  char line[160];
  for (const Vec3 p : points) {
    std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x, p.y, p.z);
    s += line;
  }
  for (const auto& f : facets) {
    std::snprintf(line, sizeof line, "f %d %d %d\n", f[0] + 1, f[1] + 1, f[2] + 1);
    s += line;
  }
  return write_file(name, s);
}

/// ASCII STL.
inline std::string write_stl(const std::string& name, const std::vector<Triangle>& triangles) {
  std::string s = "solid test\n";
  char line[200];
  for (const Triangle& t : triangles) {
    s += "facet normal 0 0 0\nouter loop\n";
    for (const Vec3 v : t) {
      std::snprintf(line, sizeof line, "vertex %.9g %.9g %.9g\n", v.x, v.y, v.z);
      s += line;
    }
    s += "endloop\nendfacet\n";
  }
  return write_file(name, s + "endsolid test\n");
}

/// Scene with open sides, a domain of [-2, 2]^3 and the given walls.
inline Scene scene_with(const std::vector<WallSpec>& walls) {
  Scene s;
  s.dt = 1e-5;
  s.domain.lower = {-2, -2, -2};
  s.domain.upper = {2, 2, 2};
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.walls = walls;
  return s;
}

inline WallSpec mesh_wall(const std::string& file) {
  WallSpec w;
  w.name = "mesh";
  w.shape = WallShape::mesh;
  w.file = file;
  return w;
}

inline WallSpec plane_wall(Vec3 point, Vec3 normal) {
  WallSpec w;
  w.name = "plane";
  w.point = point;
  w.normal = normal;
  return w;
}

inline WallSpec box_wall(Vec3 lower, Vec3 upper) {
  WallSpec w;
  w.name = "box";
  w.shape = WallShape::box;
  w.lower = lower;
  w.upper = upper;
  return w;
}

inline WallSpec cone_wall(Vec3 point, Vec3 axis, double length, double radius, double radius_end) {
  WallSpec w;
  w.name = "cone";
  w.shape = radius == radius_end ? WallShape::cylinder : WallShape::cone;
  w.point = point;
  w.axis = axis;
  w.length = length;
  w.radius = radius;
  w.radius_end = radius_end;
  return w;
}

/// Candidates within the radius, then contacts.
inline std::vector<WallContact> touch(const WallSet& walls, Vec3 c, double radius) {
  std::vector<std::int32_t> elements;
  walls.candidates(c, radius, elements);
  std::vector<WallContact> out(WallSet::k_max_contacts);
  out.resize(static_cast<std::size_t>(walls.contacts(c, radius, elements, out.data())));
  return out;
}

inline double length(Vec3 a) { return std::sqrt(norm2(a)); }

/// Random triangulation of the square [0, n*pitch]^2 at height z: jittered grid points (the rim stays straight), random
/// diagonals.
inline void random_plane(int n, double pitch, double z, std::uint64_t seed, std::vector<Vec3>& points,
                         std::vector<std::array<int, 3>>& facets) {
  const CounterRng rng(seed, 1);
  std::uint64_t draw = 0;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double a = rng.uniform(draw++, -0.4, 0.4), b = rng.uniform(draw++, -0.4, 0.4);
      const double dx = i == 0 || i == n ? 0 : a, dy = j == 0 || j == n ? 0 : b;
      points.push_back({(i + dx) * pitch, (j + dy) * pitch, z});
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      if (rng.uniform(draw++) < 0.5) {
        facets.push_back({a, b, d});
        facets.push_back({a, d, c});
      } else {
        facets.push_back({a, b, c});
        facets.push_back({c, b, d});  // winding of the second differs on purpose: contact is two-sided
      }
    }
}

}  // namespace talus::wall_test
