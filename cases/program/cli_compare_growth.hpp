// How the difference between two runs grows with time: over the frames that both wrote. Called by cli_compare.cpp.
// Invariant: frames are matched by time, so that runs with different steps can be compared; particles by id.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/scene/scene.hpp"

namespace talus::cli {

bool same_bits(double a, double b) noexcept;
/// Columns of parts (temperature, tracer) that both frames hold.
using ColumnPairs = std::vector<std::pair<const ExtraColumn*, const ExtraColumn*>>;
ColumnPairs common_columns(const Frame& a, const Frame& b);

struct GrowthPoint {
  double time = 0;  ///< [s]
  std::int64_t step_a = 0, step_b = 0, common = 0, different = 0;
  std::int64_t only_a = 0, only_b = 0;
  double rms = 0, max = 0;                    ///< of |x_a - x_b| [m]
  double rms_velocity = 0, max_velocity = 0;  ///< [m/s]
  ParticleId first = -1, worst = -1;          ///< lowest id with other bits; id of max
};

struct Growth {
  std::vector<GrowthPoint> points;
  std::vector<std::string> others;  ///< columns of parts (temperature, tracer) in which grains differ
  double radius = 0;                ///< mean radius [m]
  double first_time = -1;           ///< of the first frame that differs in any bit; -1: none does
  double rate = 0;                  ///< of rms ~ exp(rate t) [1/s], fitted between the first difference and 0.1 radius
  int fitted = 0;                   ///< points in the fit; below 3 there is no rate
  double quality = 0;               ///< R^2 of the fit
  double horizon = -1;              ///< first time with rms > one radius; -1: not reached
  bool equal() const noexcept { return first_time < 0; }
};

/// Files of particle frames of both runs. `domain`: for the minimum image. Error{io}.
Growth compare_growth(const std::string& a, const std::string& b, const Domain& domain);
std::string growth_text(const Growth& growth);

}  // namespace talus::cli
