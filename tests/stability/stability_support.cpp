// See stability_support.hpp.
#include "tests/stability/stability_support.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace talus::stability {

void row(const std::string& asserted, const std::string& figure) {
  ::testing::Test::RecordProperty("asserted", asserted);
  ::testing::Test::RecordProperty("figure", figure);
}

void shortfall(const std::string& what) { ::testing::Test::RecordProperty("shortfall", what); }

std::string pending(const std::string& asserted, const std::string& why) {
  ::testing::Test::RecordProperty("asserted", asserted);
  ::testing::Test::RecordProperty("pending", why);
  return "pending: " + why;
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

bool full() {
  const char* e = std::getenv("TALUS_FULL");
  return e != nullptr && std::string(e) == "1";
}

std::string temporary(const std::string& name, const std::string& text) {
  struct Folder {
    std::filesystem::path path = std::filesystem::temp_directory_path() / fmt::format("talus-stability-{}", getpid());
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  const std::string path = (folder.path / name).string();
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::int64_t audited(const Scene& scene, std::int64_t steps) {
  RunOptions o = options();
  o.audit = true;
  Simulation sim(scene, o);
  sim.run(steps);
  return sim.counters().missed_contacts;
}

double total_energy(const Energies& e) { return e.kinetic_translation + e.kinetic_rotation + e.potential + e.elastic; }

std::string sci(double value) { return fmt::format("{:.2g}", value); }
std::string fmt_ratio(double value) { return fmt::format("{:.4g}", value); }

}  // namespace talus::stability
