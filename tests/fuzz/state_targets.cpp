// What a run is resumed with: checkpoints and series.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/io/checkpoint.hpp"
#include "core/io/scene_file.hpp"
#include "core/io/series.hpp"
#include "scheduler/simulation.hpp"
#include "tests/fuzz/memory_file.hpp"

namespace talus::fuzz {

namespace {

/// A scene with everything that a checkpoint holds: history, rolling, a moving wall, a stream, periodic sides,
/// energies.
const Scene& small_scene() {
  static const Scene scene = parse_scene(R"(
seed = 3
gravity = [0, 0, -9.81]
domain = { lower = [0, 0, 0], upper = [0.05, 0.05, 0.05], boundary = ["periodic", "wall", "wall"] }
time = { step = 2e-5, steps = 1000 }
material = [{ name = "glass", density = 2500 }]
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
size = { diameter = 0.006 }
[[wall]]
name = "piston"
shape = "plane"
point = [0, 0, 0.002]
normal = [0, 0, 1]
motion = { amplitude = [0, 0, 1e-3], frequency = 50 }
[output]
energies = true
)",
                                         "fuzz.toml", "/nonexistent");
  return scene;
}

RunOptions one_thread() {
  RunOptions o;
  o.threads = 1;
  return o;
}

/// Sections of a checkpoint of small_scene() after 400 steps.
struct Sections {
  std::vector<std::string> names;
  std::vector<std::vector<std::uint8_t>> bytes;
};
const Sections& real_sections() {
  static const Sections sections = [] {
    Simulation s(small_scene(), one_thread());
    s.run(400);
    CheckpointWriter out;
    s.save(out);
    const std::string path = "/tmp/talus-fuzz-" + std::to_string(getpid());
    out.commit(path);
    const CheckpointReader in(path);
    unlink(path.c_str());
    Sections all;
    all.names = in.names();
    for (const std::string& name : all.names) {
      const auto b = in.section(name);
      all.bytes.emplace_back(b.begin(), b.end());
    }
    return all;
  }();
  return sections;
}

/// Damage behind the checksum: the state has to be refused, or to be a state that a step can be made from.
void resume_with(std::size_t section, Bytes damage) {
  const Sections& real = real_sections();
  CheckpointWriter out;
  for (std::size_t k = 0; k < real.names.size(); ++k) {
    std::vector<std::uint8_t> bytes = real.bytes[k];
    if (k == section) {
      // pairs of place and byte; what is left over changes the length
      for (std::size_t q = 0; q + 3 <= damage.size() && !bytes.empty(); q += 3)
        bytes[(damage[q] * 256U + damage[q + 1]) % bytes.size()] ^= damage[q + 2];
      bytes.resize(bytes.size() + damage.size() % 3);
    }
    out.add(real.names[k], std::move(bytes));
  }
  static const std::string path = "/tmp/talus-fuzz-" + std::to_string(getpid()) + ".checkpoint";
  try {
    out.commit(path);
    const CheckpointReader in(path);
    Simulation s(small_scene(), one_thread(), in);
    s.run(2);
  } catch (const Error&) {
  }
  unlink(path.c_str());
}

}  // namespace

void checkpoint(Bytes input) {
  if (input.empty()) return;
  const std::size_t count = real_sections().names.size(), which = input[0];
  if (which < count) return resume_with(which, input.subspan(1));
  const MemoryFile file(input.subspan(1));
  try {
    const CheckpointReader in(file.path());
    for (const std::string& name : in.names()) (void)in.section(name);
    Simulation s(small_scene(), one_thread(), in);
  } catch (const Error&) {
  }
}

void series(Bytes input) {
  if (input.empty()) return;
  SeriesLayout layout;
  layout.walls = {"floor"};
  layout.energies = true;
  const MemoryFile file(input.subspan(1));
  try {
    SeriesWriter w = SeriesWriter::resume(file.path(), layout, input[0]);
    SeriesRow row;
    row.step = std::max<std::int64_t>(w.last_step() + 1, 0);
    row.walls.resize(1);
    w.append(row);
    std::ifstream in(file.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (text.empty() || text.back() != '\n') __builtin_trap();  // rows appear whole
  } catch (const Error&) {
  }
}

}  // namespace talus::fuzz
