// Time step limits of a scene: Rayleigh time, contact time, stability of an isolated pair and of a packing, travel per
// step. Who calls it: scheduler/ (construction) and, through it, cases/ (check, explain, run): guard and advice are one
// judgement. Invariant: the minimum is over all pairs of materials and sizes that can meet, walls included; formulae
// are stated next to the code.
#pragma once

#include <string>
#include <vector>

#include "core/grains/population.hpp"
#include "core/rules/contact_limits.hpp"
#include "core/scene/scene.hpp"
#include "core/walls/walls.hpp"

namespace talus {

/// One limit [s] (infinite where the scene cannot have it) and the pair that rules it, e.g. "glass (r = 0.001) on wall
/// steel".
struct TimeStepLimit {
  double seconds = k_never;
  std::string pair;
};

/// What moves how fast in a scene [m/s].
struct Speeds {
  double grain = 0;  ///< fastest that files, sources and events state, spins included
  double wall = 0;   ///< fastest point of a wall over the run
  std::string wall_name;
  double fall = 0;     ///< after a free fall through the domain
  double closing = 0;  ///< of the hardest impact that these let expect
};

struct TimeStepReport {
  double dt = 0;  ///< [s]
  Speeds speeds;
  double velocity = 0;             ///< closing speed at which Hertz contacts are judged [m/s]; 0 for linear
  TimeStepLimit rayleigh;          ///< pi r sqrt(rho / G) / (0.1631 nu + 0.8766); needs Young's modulus
  TimeStepLimit contact;           ///< duration of an impact
  TimeStepLimit isolated_pair;     ///< 2 / sqrt(k / m_eff), undamped
  TimeStepLimit packing;           ///< of the densest packing, damping, tangential and rolling springs included; 1/8 of
                                   ///< the contact time where nothing takes energy out
  ContactDynamics ruler;           ///< of the contact that rules it; all 0 where nothing can touch
  double share = 0;                ///< dt / min(rayleigh, contact)
  std::string warning;             ///< empty, or why the step is uncomfortable (share > 0.2, or unstable but allowed)
  std::vector<std::string> lines;  ///< for `talus check`: one text line per limit
};

Speeds speeds_of(const Scene& scene, const Population& grains, const WallSet& walls);

/// Error{scene} if dt exceeds the packing limit and the scene does not allow it, or if a wall or grain is sure to move
/// farther in one step than checks.max_travel allows.
TimeStepReport time_step_limits(const Scene& scene, const Population& grains, const WallSet& walls);
/// The same for many particles of radius r_min to r_max [m] of all materials that the sources name, with at least the
/// closing speed `speed` [m/s]; loads the scene's meshes.
TimeStepReport time_step_limits(const Scene& scene, double r_min, double r_max, double speed = 0);

/// What the stiffness of the contacts does to the geometry, and how soft they could be for a largest overlap of 1 % of
/// the radius. Estimates from the scene alone, for its largest particles on a wall:
///   impact  linear  delta = v sqrt(m/k)                    hertz  delta = (15 m v^2 / (16 E* sqrt(r)))^(2/5)
///   weight  F = 0.6 rho g H (2r)^2 (a bed that fills the domain up to H), linear delta = F/k,
///           hertz delta = (3 F / (4 E* sqrt(r/2)))^(2/3)
struct Softening {
  double speed = 0;        ///< [m/s] of the impact
  double load = 0;         ///< [N]
  double overlap = 0;      ///< the larger of both overlaps now / radius
  bool by_impact = true;   ///< which of them that is
  double factor = 0;       ///< stiffness (k_n or Young's moduli) may be multiplied by this; 0: nothing moves or weighs
  double step_factor = 0;  ///< by which the contact time grows then
};
Softening softening(const Scene& scene, const Population& grains, double speed);
/// For particles of radius r_max [m] of all materials, `speed` or the fastest that the scene states.
Softening softening(const Scene& scene, double r_max, double speed = 0);

/// Time steps [s]: `accurate` keeps 20 steps per contact and 0.2 of the Rayleigh time, within the packing limit, which
/// is `limit`: what a run accepts. `advised` is the scene's own where that is no shorter than `accurate` and keeps 10
/// steps per contact.
struct StepAdvice {
  double accurate = 0, limit = 0, advised = 0;
};
StepAdvice step_advice(const TimeStepReport& report);

/// Largest `row` [1/s2] with effective_stiffness() up to `level` at the report's step, and largest step [s] at which
/// that of a given row is.
double largest_row(const Scene& scene, const TimeStepReport& report, double level);
double step_for_row(const Scene& scene, const TimeStepReport& report, double row, double level);

/// A limit [s] with four digits, rounded down: the printed number is within it.
std::string at_most(double seconds);

}  // namespace talus
