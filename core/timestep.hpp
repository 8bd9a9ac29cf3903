// Time step limits of a scene: Rayleigh time, contact time, stability of an isolated pair and of a packing. Who calls
// it: scheduler/ (construction) and cases/ (check, explain, run). Invariant: the minimum is over all pairs of materials
// and sizes that can meet, walls included; formulae are stated next to the code.
#pragma once

#include <span>
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
/// not allow it. `speed` [m/s]: fastest particle of the initial files, where the caller knows it. `materials`
/// [materials]: not 0 where particles are of it (Insertion::materials()); empty: a file may hold any.
TimeStepReport time_step_limits(const Scene& scene, double r_min, double r_max, double speed = 0,
                                std::span<const char> materials = {});

/// What the stiffness of the contacts does to the geometry, and how soft they could be for a largest overlap of 1 % of
/// the radius. Estimates from the scene alone, for its largest particle on a wall:
///   impact  linear  delta = v sqrt(m/k)                    hertz  delta = (15 m v^2 / (16 E* sqrt(r)))^(2/5)
///   weight  F = 0.6 rho g H (2r)^2 (a bed that fills the domain up to H), linear delta = F/k,
///           hertz delta = (3 F / (4 E* sqrt(r/2)))^(2/3)
struct Softening {
  double speed = 0;       ///< [m/s] of the impact
  double load = 0;        ///< [N]
  double overlap = 0;     ///< the larger of both overlaps now / radius
  bool by_impact = true;  ///< which of them that is
  double factor = 0;      ///< stiffness (k_n or Young's moduli) may be multiplied by this; 0: nothing moves or weighs
  double step_factor = 0; ///< by which the contact time grows then
};
Softening softening(const Scene& scene, double r_max, double speed = 0);

/// Time steps [s] that are advised: `accurate` keeps 20 steps per contact and 0.2 of the Rayleigh time, within the
/// packing limit; `row_sum` is sqrt(2 m / (Z k)), below which Z contacts per particle are surely stable (Z = 12).
struct StepAdvice {
  double accurate = 0, row_sum = 0;
};
StepAdvice step_advice(const TimeStepReport& report);

}  // namespace talus
