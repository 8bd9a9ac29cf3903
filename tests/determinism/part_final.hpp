// All that a run with parts ends in, to be compared bit for bit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/determinism/scenes.hpp"
#include "tests/part_values.hpp"

namespace talus::determinism {

struct Final {
  std::uint64_t hash;
  std::vector<double> values;
  std::string bytes;
  bool operator==(const Final&) const = default;
};

inline Final final_of(const Simulation& sim) {
  Final f{sim.state_hash(), {}, checkpoint_bytes(sim)};
  for (const PartValue& v : sim.part_values()) f.values.push_back(v.value);
  return f;
}

}  // namespace talus::determinism
