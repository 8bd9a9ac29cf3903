// What the monitor samples of one chunk. Who fills it: observe_stiffness, observe_chunk; who reads it: judge_step.
#pragma once

#include <cstdint>

#include "core/base/types.hpp"

namespace talus {

enum class Watch : int { overlap, travel, stiffness, count };

/// Largest values of one chunk in a sampled step, and how many were above the warning level.
struct ChunkExtremes {
  struct Extreme {
    double value = 0;
    ParticleId id = -1, partner = -1;  ///< partner: another particle, or -2 - wall
    std::int64_t count = 0;
  };
  bool filled = false;
  Extreme of[static_cast<int>(Watch::count)];

  /// Counts a value above `level`; keeps the largest, of equal ones that of the lowest numbers.
  void offer(Watch watch, double value, double level, ParticleId id, ParticleId partner) {
    Extreme& e = of[static_cast<int>(watch)];
    if (value > level) ++e.count;
    if (!(value >= e.value)) return;
    if (value == e.value && e.id >= 0 && (e.id != id ? e.id < id : e.partner <= partner)) return;
    e = {value, id, partner, e.count};
  }
};

}  // namespace talus
