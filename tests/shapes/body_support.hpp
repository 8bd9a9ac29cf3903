// What tests of bodies in scenes share: words of a source, and sums over the bodies of a simulation.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "scheduler/simulation.hpp"
#include "scheduler/step/access.hpp"

namespace talus {

inline std::string source(const std::string& name, int number, const std::string& lower, const std::string& upper,
                          const std::string& more, const std::string& size = {}) {
  std::string s = "[[source]]\nname = \"" + name + "\"\nkind = \"random\"\nnumber = " + std::to_string(number) + "\n" +
                  more + "\n[source.region]\nlower = " + lower + "\nupper = " + upper + "\n";
  return size.empty() ? s : s + "[source.size]\ndiameter = " + size + "\n";
}

/// A particle file that is gone at the end of the test.
class Table {
 public:
  explicit Table(const std::string& text) {
    static int number = 0;
    path_ = std::filesystem::temp_directory_path() / fmt::format("talus_bodies_{}_{}.csv", getpid(), number++);
    std::ofstream(path_) << text;
  }
  ~Table() { std::filesystem::remove(path_); }
  std::string source(const std::string& more = {}) const {
    return "[[source]]\nkind = \"file\"\nfile = \"" + path_.string() + "\"\n" + more + "\n";
  }

 private:
  std::filesystem::path path_;
};

inline const Bodies& bodies_of(Simulation& sim) { return EngineAccess::world(sim).rows.bodies; }
inline const Rules& rules_of(Simulation& sim) { return EngineAccess::world(sim).rules; }

struct Sums {
  Vec3 momentum, angular;
  double energy = 0, mass = 0;
};
/// Of bodies that no side has wrapped, about the domain's corner.
inline Sums sums_of(Simulation& sim) {
  Sums s;
  const Bodies& b = bodies_of(sim);
  for (std::int32_t k = 0; k < b.n; ++k) {
    const Vec3 v{b.v[4L * k], b.v[4L * k + 1], b.v[4L * k + 2]};
    s.momentum = s.momentum + b.mass(k) * v;
    s.angular = s.angular + b.mass(k) * cross(b.centre(k), v) + momentum_in_space(rules_of(sim), b, k);
    s.energy += 0.5 * b.mass(k) * norm2(v) + rotation_energy(rules_of(sim), b, k);
    s.mass += b.mass(k);
  }
  return s;
}

}  // namespace talus
