// Checkpoints whose checksums are good and whose content no run has written are refused, by section and entry.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>

#include "core/base/error.hpp"
#include "core/io/checkpoint.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/simulation.hpp"

namespace talus {
namespace {

constexpr const char* k_scene = R"(
seed = 3
gravity = [0, 0, -9.81]
domain = { lower = [0, 0, 0], upper = [0.05, 0.05, 0.05] }
time = { step = 2e-5, steps = 1000 }
material = [{ name = "glass", density = 2500 }]
contact = { normal_stiffness = 1e4, restitution = 0.7, friction = 0.5 }
[[source]]
kind = "random"
number = 150
region = { lower = [0.004, 0.004, 0.004], upper = [0.046, 0.046, 0.046] }
size = { diameter = 0.006 }
velocity = [0, 0, -1]
)";

using Bytes = std::vector<std::uint8_t>;

template <class T>
void put(Bytes& bytes, std::size_t at, T value) {
  ASSERT_LE(at + sizeof value, bytes.size());
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// The message of a resume from a checkpoint of which one section was changed; "" where it went on.
std::string refusal(const std::string& section, const std::function<void(Bytes&)>& change) {
  const Scene scene = parse_scene(k_scene, "scene.toml", ".");
  RunOptions options;
  options.threads = 1;
  Simulation s(scene, options);
  s.run(1000);
  EXPECT_GT(s.counters().contacts, 0);
  EXPECT_GT(s.counters().wall_contacts, 0);
  CheckpointWriter whole, changed;
  s.save(whole);
  const std::string path = std::filesystem::path(testing::TempDir()) / "restored_state.tcp";
  whole.commit(path);
  const CheckpointReader in(path);
  for (const std::string& name : in.names()) {
    const auto b = in.section(name);
    Bytes bytes(b.begin(), b.end());
    if (name == section) change(bytes);
    changed.add(name, std::move(bytes));
  }
  changed.commit(path);
  try {
    const Simulation resumed(scene, options, CheckpointReader(path));
    EXPECT_EQ(resumed.state_hash(), s.state_hash());
    return "";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::io);
    return e.what();
  }
}

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

TEST(RestoredState, AnUnchangedCheckpointGoesOn) {
  EXPECT_EQ(refusal("position", [](Bytes&) {}), "");
}

TEST(RestoredState, WhatNoRunHasWrittenIsRefusedBySectionAndEntry) {
  struct Case {
    const char *section, *says;
    std::function<void(Bytes&)> change;
  };
  const Case cases[] = {
      {"meta", "no run can have had such counts", [](Bytes& b) { put(b, 0, std::int64_t{-1}); }},  // step
      {"meta", "no run can have had such counts", [](Bytes& b) { put(b, 0, std::int64_t{1} << 60); }},
      {"meta", "no run can have had such counts", [](Bytes& b) { put(b, 8, std::int64_t{7}); }},         // event
      {"meta", "no run can have had such counts", [](Bytes& b) { put(b, 24, std::int64_t{1} << 40); }},  // rows
      {"meta", "no run can have had such counts", [](Bytes& b) { put(b, 24, std::int64_t{-5}); }},
      {"meta", "no run can have had such counts", [](Bytes& b) { put(b, 72, k_nan); }},  // mass
      {"position", "entry 1: a number is not finite", [](Bytes& b) { put(b, 32, k_nan); }},
      {"position", "entry 0: the particle is outside the domain", [](Bytes& b) { put(b, 8, -0.001); }},
      {"position", "entry 2: no source of the scene has such a radius", [](Bytes& b) { put(b, 88, 0.02); }},
      {"position", "entry 0: the particle is neither there nor removed", [](Bytes& b) { put(b, 0, 1e200); }},
      {"velocity", "entry 0: a number is not finite", [](Bytes& b) { put(b, 8, -k_never); }},
      {"velocity", "entry 0: the mass does not belong", [](Bytes& b) { put(b, 56, 1.0); }},
      {"id", "entry 3: the number was never given", [](Bytes& b) { put(b, 24, std::int64_t{150}); }},
      {"contacts", "entry 0: it names a particle that does not exist", [](Bytes& b) { put(b, 4, std::int32_t{150}); }},
      {"contacts", "entry 1: the pairs do not ascend", [](Bytes& b) { std::memcpy(b.data() + 8, b.data(), 8); }},
      {"contact_history", "entry 0: a number is not finite", [](Bytes& b) { put(b, 0, k_nan); }},
      {"wall_contacts", "entry 0: it names a particle or a wall", [](Bytes& b) { put(b, 8, std::int32_t{-1}); }},
      {"wall_contacts", "entry 0: a number is not finite", [](Bytes& b) { put(b, 16, k_nan); }},
      {"insertion", "no run can have left such numbers", [](Bytes& b) { put(b, 16, std::int64_t{-1}); }},  // draws
      {"insertion", "no run can have left such numbers", [](Bytes& b) { put(b, 32, k_nan); }},             // mass
  };
  for (const Case& c : cases) {
    const std::string text = refusal(c.section, c.change);
    EXPECT_NE(text.find(c.says), std::string::npos) << c.section << ", expected \"" << c.says << "\": " << text;
    if (c.section != std::string("insertion")) {
      EXPECT_NE(text.find(std::string("section '") + c.section), std::string::npos) << text;
    }
  }
}

}  // namespace
}  // namespace talus
