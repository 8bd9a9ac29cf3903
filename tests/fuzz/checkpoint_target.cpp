// What a run is resumed with.
#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "core/io/atomic_file.hpp"
#include "core/io/checkpoint.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/simulation.hpp"
#include "tests/fuzz/memory_file.hpp"

namespace talus::fuzz {

namespace {

/// A scene with everything that a checkpoint holds: history, rolling, materials, a moving wall, a stream, a group that
/// is held for a while, periodic sides, a plane, energies.
const Scene& small_scene() {
  static const Scene scene = parse_scene(R"(
seed = 3
gravity = [0, 0, -9.81]
domain = { lower = [0, 0, 0], upper = [0.05, 0.05, 0.05], boundary = ["periodic", "wall", "wall"] }
time = { step = 2e-5, steps = 1000 }
material = [{ name = "glass", density = 2500 }, { name = "steel", density = 7800 }]
[contact]
model = "linear"
normal_stiffness = 1e4
tangential_stiffness = 3e3
restitution = 0.7
friction = 0.5
rolling = "epsd"
rolling_friction = 0.1
[[source]]
kind = "random"
number = 30
region = { lower = [0, 0.005, 0.005], upper = [0.05, 0.045, 0.045] }
size = { diameter = 0.006 }
[[source]]
kind = "stream"
number_rate = 2000
interval = 1e-3
region = { lower = [0, 0.005, 0.02], upper = [0.05, 0.045, 0.045] }
size = { diameter = 0.0055 }
material = "steel"
group = "rain"
[[group]]
name = "rain"
[[event]]
time = 0.005
action = "freeze"
group = "rain"
[[event]]
time = 0.0081
action = "release"
group = "rain"
[[wall]]
name = "piston"
shape = "plane"
point = [0, 0, 0.002]
normal = [0, 0, 1]
motion = { amplitude = [0, 0, 1e-3], frequency = 50 }
[output]
energies = true
[[output.plane]]
name = "middle"
point = [0, 0, 0.02]
)",
                                         "fuzz.toml", "/nonexistent");
  return scene;
}

RunOptions one_thread() {
  RunOptions o;
  o.threads = 1;
  return o;
}

/// Takes what is written instead of a file system: most of the time of an input went there.
struct Taken : FileCalls {
  std::vector<std::uint8_t> bytes;
  int open(const char*, int, unsigned) override { return 1 << 20; }
  ssize_t write(int, const void* data, std::size_t n) override {
    const auto* from = static_cast<const std::uint8_t*>(data);
    bytes.insert(bytes.end(), from, from + n);
    return static_cast<ssize_t>(n);
  }
  int fsync(int) override { return 0; }
  int close(int) override { return 0; }
  int rename(const char*, const char*) override { return 0; }
  int unlink(const char*) override { return 0; }
};

/// Written and read back.
CheckpointReader stored(const CheckpointWriter& out) {
  Taken calls;
  const ScopedFileCalls scoped(calls);
  out.commit("fuzz.tcp");
  return {"fuzz.tcp", std::move(calls.bytes)};
}

/// Sections of a checkpoint of small_scene() after 400 steps.
struct Section {
  std::string name;
  std::vector<std::uint8_t> bytes;
};
const std::vector<Section>& real_sections() {
  static const std::vector<Section> sections = [] {
    Simulation s(small_scene(), one_thread());
    s.run(400);
    CheckpointWriter out;
    s.save(out);
    const CheckpointReader in = stored(out);
    std::vector<Section> all;
    for (const std::string& name : in.names()) {
      const auto b = in.section(name);
      all.push_back({name, {b.begin(), b.end()}});
    }
    return all;
  }();
  return sections;
}

/// Four bytes each: place (two), what to do, with which value.
void damage(std::vector<std::uint8_t>& bytes, Bytes orders) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  constexpr double k_numbers[] = {0, -1, nan, infinity, -infinity, 1e300, -1e300, 1e-300};
  constexpr std::int64_t k_integers[] = {0,
                                         1,
                                         -1,
                                         1 << 30,
                                         std::int64_t{1} << 31,
                                         std::int64_t{1} << 32,
                                         std::numeric_limits<std::int64_t>::min(),
                                         std::numeric_limits<std::int64_t>::max()};
  for (; orders.size() >= 4; orders = orders.subspan(4)) {
    const std::size_t place = orders[0] * 256U + orders[1];
    const unsigned what = orders[2] % 6, value = orders[3];
    if (what == 4) bytes.resize(bytes.size() - std::min<std::size_t>(bytes.size(), value));
    if (what == 5) bytes.resize(bytes.size() + value);
    if (what >= 4 || bytes.size() < 8) continue;
    std::uint8_t* word = bytes.data() + place % (bytes.size() / 8) * 8;
    if (what == 0) bytes[place % bytes.size()] ^= orders[3];
    if (what == 1) std::memcpy(word, &k_numbers[value % 8], 8);
    if (what == 2) std::memcpy(word, &k_integers[value % 8], 8);
    if (what == 3) std::memmove(word, bytes.data() + value % (bytes.size() / 8) * 8, 8);
  }
}

/// Damage behind the checksum: the state is refused, or it is one that steps can be made from.
void resume_with(std::size_t section, Bytes orders) {
  const std::vector<Section>& real = real_sections();
  CheckpointWriter out;
  for (std::size_t k = 0; k < real.size(); ++k) {
    std::vector<std::uint8_t> bytes = real[k].bytes;
    if (k == section) {
      if (orders.empty()) continue;  // the section is missing
      damage(bytes, orders);
    }
    out.add(real[k].name, std::move(bytes));
  }
  const CheckpointReader in = stored(out);
  try {
    Simulation s(small_scene(), one_thread(), in);
    s.state_hash();
    s.frame({});
    s.run(2);
  } catch (const Error& e) {
    check_message(e);
  }
}

}  // namespace

void checkpoint(Bytes input) {
  if (input.empty()) return;
  if (input[0] < real_sections().size()) return resume_with(input[0], input.subspan(1));
  const MemoryFile file(input.subspan(1));
  try {
    const CheckpointReader in(file.path());
    for (const std::string& name : in.names()) in.section(name);
    const Simulation s(small_scene(), one_thread(), in);
  } catch (const Error& e) {
    check_message(e);
  }
}

}  // namespace talus::fuzz
