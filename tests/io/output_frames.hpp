// Synthetic frames whose every value follows from (id, step) by exact binary fractions, so that check_vtkhdf.py and
// check_vtp.py recompute them. Used by the output tests only.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "core/frame/frame.hpp"
#include "paths.hpp"

namespace talus::test {

inline Frame make_frame(std::int64_t step, int n, int triangles = 0) {
  Frame f;
  f.step = step;
  f.time = 0.125 * static_cast<double>(step);
  const auto s = static_cast<double>(step);
  for (int k = 0; k < n; ++k) {
    const std::int64_t id = 3 * k + 1;
    const auto d = static_cast<double>(id);
    f.id.push_back(id);
    f.x.push_back({0.5 * d, 0.25 * s, 0.125 * d + s});
    f.v.push_back({d, -s, 0.5 * d});
    f.w.push_back({2 * d, s, 1});
    f.r.push_back(0.25 + d / 64);
    f.material.push_back(static_cast<std::uint8_t>(id % 3));
    f.fixed.push_back(static_cast<std::uint8_t>(id % 2));
    f.coordination.push_back(static_cast<std::int32_t>(id % 7));
    f.stress.push_back({d, d + 10, d + 20, d + 30, d + 40 + s, d + 50});
    f.contacts.push_back({id, -1 - (id % 2), {d, s, 0}, {0, 0, d}, {s, 0, 0}, d / 1024});
  }
  WallSurface wall;
  wall.name = "floor";
  for (int t = 0; t < triangles; ++t) {
    const auto b = static_cast<double>(t);
    wall.points.insert(wall.points.end(), {{b, s, 0}, {b + 1, s, 0}, {b, s, 1}});
    wall.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  f.walls.push_back(wall);
  return f;
}

/// A fresh folder that goes with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "talus-io-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) std::abort();
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline std::string slurp(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream s;
  s << in.rdbuf();
  return s.str();
}
inline void spill(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << text;
}

/// Runs tests/io/SCRIPT with the system's python3 (the one that has numpy, h5py and vtk); true if it exits with 0.
inline bool python(const std::string& script, const std::string& arguments) {
  const std::string command = "/usr/bin/python3 " TALUS_SOURCE_DIR "/tests/io/" + script + " " + arguments;
  return std::system(command.c_str()) == 0;
}

}  // namespace talus::test
