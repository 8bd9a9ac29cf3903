// How long a run will take, from what its first steps cost. Called by cli_check.cpp. Measures nothing itself.
#pragma once

#include <cstdint>
#include <string>

#include "cases/program/cli_check_cost.hpp"
#include "core/scene/scene.hpp"

namespace talus::cli {

/// What sources deliver after step 0.
struct Arrivals {
  double most = 0;  ///< upper bound [particles]
  double mean =
      0;  ///< of those that come after `from`, present on average from then on; what leaves again is not known
};
/// `from`: time up to which the run is known [s].
Arrivals arrivals_of(const Scene& scene, double from = 0);

struct RunTime {
  double seconds = 0;  ///< the whole run, outputs included [s]
  double outputs = 0;  ///< of it for frames and rows [s]
  double loose = 0;    ///< share of the steps at the measured cost, before the grains lie in a bed; 1 without gravity
  double seconds_loose = 0;  ///< the run at the measured cost throughout, outputs included [s]
  double seconds_dense = 0;  ///< the same with the cost of a dense bed
};

/// `present`: particles at the end of the measurement, `arrivals` from then on. What was measured is not predicted but
/// taken.
RunTime predict(const Scene& scene, const Cost& cost, double present, const Arrivals& arrivals);

std::string time_text(const Scene& scene, const RunTime& time, const Cost& cost, int threads);

}  // namespace talus::cli
