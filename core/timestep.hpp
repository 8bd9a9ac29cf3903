// Time step limits of a scene: Rayleigh time, contact time, stability of an isolated pair and of a packing. Who calls
// it: scheduler/ (construction) and cases/ (check, explain, run). Invariant: the minimum is over all pairs of materials
// and sizes that can meet, walls included; formulae are stated next to the code.
#pragma once

#include <string>
#include <vector>

#include "core/scene.hpp"

namespace talus {

/// One limit [s] (infinite where the scene cannot have it) and the pair that rules it, e.g. "glass (r = 0.001) on wall
/// steel".
struct TimeStepLimit {
  double seconds = k_never;
  std::string pair;
};

struct TimeStepReport {
  double dt = 0;                   ///< [s]
  double velocity = 0;             ///< speed at which Hertz contacts are judged [m/s]; 0 for linear
  TimeStepLimit rayleigh;          ///< pi r sqrt(rho / G) / (0.1631 nu + 0.8766); needs Young's modulus
  TimeStepLimit contact;           ///< duration of an impact
  TimeStepLimit isolated_pair;     ///< 2 / sqrt(k / m_eff), undamped
  TimeStepLimit packing;           ///< 0.4 of it; less with strong damping or k_t > 2/7 k_n
  double share = 0;                ///< dt / min(rayleigh, contact)
  std::string warning;             ///< empty, or why the step is uncomfortable (share > 0.2, or unstable but allowed)
  std::vector<std::string> lines;  ///< for `talus check`: one text line per limit
};

/// Limits for particles of radius [r_min, r_max] [m]. Error{scene} if dt exceeds the packing limit and the scene does
/// not allow it. `speed` [m/s]: fastest particle of the initial files, where the caller knows it.
TimeStepReport time_step_limits(const Scene& scene, double r_min, double r_max, double speed = 0);

}  // namespace talus
