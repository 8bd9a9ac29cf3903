// List policies: the skin of one particle and what keeps a list valid. Adding a policy is one case here, its name in
// the scene keys and its guarantee in k_policies.
// Who calls it: scheduler/lists/cell_grid.cpp (skins), scheduler/lists/skin_check.cpp (validity),
// scheduler/lists/tuner.cpp (K, floor). Invariants: I2 (the skin is clamped first; what is stored is what is checked);
// the largest R_NL on a periodic axis is L/4, so that displacements and pairs have one minimum image.
#pragma once

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/rules/adhesion.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// Name and guarantee of a list policy, in the order of ListPolicy; the names are those of the scene key.
struct PolicyText {
  const char* name;
  const char* guarantee;
};
inline constexpr PolicyText k_policies[] = {
    {"always", "exact: rebuilt at every step, no skin"},
    {"paper", "exact: skin K |v| dt of each particle, its displacement is checked at every step"},
    {"local", "exact: as paper, with a smallest skin and an acceleration term"},
    {"uniform", "exact: one skin for all, each displacement is checked at every step"},
    {"two_largest", "exact: one skin for all, the sum of the two largest displacements stays below two skins"},
    {"accumulated", "exact: one skin for all, the largest travel of each step, summed, stays below it"},
    {"global_velocity", "exact: skin K max|v| dt for all, each displacement is checked at every step"},
    {"neighbourhood", "exact: as local with the largest speed among 64 neighbouring rows"},
    {"mean_subtracted", "exact: as local, speeds and displacements relative to the mean velocity"},
    {"velocity_profile",
     "exact: as local, speeds and displacements relative to a velocity profile across one axis, pairs listed in a "
     "longer reach"},
    {"displacement_history",
     "exact: skin from what each particle travelled under the last lists, checked at every step"},
    {"outer_inner", "exact: as local, lists cut out of longer ones for as long as no displacement exceeds their skins"},
    {"fixed", "NOT exact: rebuilt every list.interval steps, nothing is checked in between"},
};
inline const PolicyText& policy_text(ListPolicy p) noexcept { return k_policies[static_cast<int>(p)]; }

/// Cap of the skins, in radii, where the run chooses K. Grains in free fall use up r/2 within some 20 steps, and then
/// all lists have to be made again for the sake of a few. Beyond the ordinary cap they get cells of their own
/// (scheduler/lists/cell_grid.cpp), so that the others' search stays as it is.
inline constexpr double k_automatic_cap = 1.5;

/// velocity_profile: reaches are at most this much longer than those of local, which bounds slope times life of a
/// list; see scheduler/lists/velocity_profile.hpp.
inline constexpr double k_most_stretch = 1.25;

/// Parameters of the skin rule, fixed for one rebuild.
struct SkinRule {
  ListPolicy policy = ListPolicy::local;
  double k_dt = 0;  ///< K * dt [s]
  bool floor_on = true, acceleration_on = true, cap_on = true;
  double floor = 0;         ///< of the particle's diameter
  double cell_edge = 0;     ///< nominal cell edge L_C [m] of the cap
  double cap = 0.5;         ///< largest skin of the policies with has_terms(), of the radius
  double largest = 0;       ///< hard limit of R_NL [m]: L/4 on the shortest periodic axis
  double uniform = 0;       ///< skin of the policies with one skin [m]
  double reach = 0;         ///< R_C = r + reach r^(1/3): range of adhesion (core/rules/adhesion.hpp)
  double outer = 1;         ///< outer_inner: skins of the outer list / those of the inner one
  double drift_travel = 0;  ///< policies that drift: how far the drift may run past walls [m]

  SkinRule() = default;
  /// `r_min`, `r_max`: radii of the scene [m].
  SkinRule(const Scene& s, double r_min, double r_max) {
    policy = s.list.policy;
    k_dt = s.list.verlet_k * s.dt;
    const bool terms = has_terms();
    floor_on = (terms || policy == ListPolicy::displacement_history) && s.list.floor_on;
    acceleration_on = terms && s.list.acceleration_on;
    cap_on = s.list.cap_on;
    floor = s.list.floor;
    cell_edge = (s.list.cell_factor > 0 ? s.list.cell_factor : 1.5) * 2 * r_max;
    if (terms && s.list.automatic && !(s.list.cell_factor > 0)) {
      cap = k_automatic_cap;
      cell_edge = 1e300;
    }
    uniform = s.list.uniform_skin * r_min;
    reach = adhesion_reach(s);
    if (cuts()) outer = s.list.outer;
    if (drifts()) drift_travel = 0.5 * r_min;
    largest = 1e300;
    for (int k = 0; k < 3; ++k)
      if (s.domain.periodic(k)) largest = fmin2(largest, 0.25 * (s.domain.upper[k] - s.domain.lower[k]));
    if (policy == ListPolicy::velocity_profile) largest /= k_most_stretch;
    // their bound is one for all particles, so their skin must be
    if (policy == ListPolicy::two_largest || policy == ListPolicy::accumulated) {
      uniform = fmin2(uniform, largest - r_max - range(r_max));
      if (!(uniform > 0)) uniform = 0;
    }
  }

  /// R_C - r [m]: how far beyond its surface a particle can be in contact with another one; with a wall, twice that.
  double range(double r) const { return reach > 0 ? reach * det::cbrt(r) : 0; }

  /// The skin has a floor, a term of the acceleration and a cap in radii.
  bool has_terms() const noexcept {
    return policy == ListPolicy::local || policy == ListPolicy::neighbourhood || cuts() || drifts();
  }
  bool has_k() const noexcept {
    return policy == ListPolicy::paper || policy == ListPolicy::global_velocity || has_terms();
  }
  /// Displacements count from where a drift velocity would have taken the particle.
  bool drifts() const noexcept {
    return policy == ListPolicy::mean_subtracted || policy == ListPolicy::velocity_profile;
  }
  /// Lists are cut out of longer ones (scheduler/lists/inner_list.cpp).
  bool cuts() const noexcept { return policy == ListPolicy::outer_inner; }
  /// The list is judged by scheduler/lists/skin_check.cpp instead of the check in the integration kernel.
  bool own_check() const noexcept {
    return policy == ListPolicy::two_largest || policy == ListPolicy::accumulated || policy == ListPolicy::fixed;
  }

  /// The most that operator() gives to a radius of r [m].
  double most(double r) const {
    const double rc = r + range(r);
    double s = largest - rc;
    if (cap_on) {
      s = fmin2(s, 0.5 * cell_edge - rc);
      if (policy != ListPolicy::paper && policy != ListPolicy::global_velocity) s = fmin2(s, cap * r);
    }
    return s > 0 ? s : 0;
  }

  /// Skin [m] of a particle of radius r [m], speed v [m/s] (whose speed: skin_check.hpp), acceleration a [m/s2]. For
  /// displacement_history v is a length [m], see SkinSpeeds.
  /// paper, global_velocity: K v dt, capped at L_C/2 - R_C (the paper's printed cap L_C loses pairs); local,
  /// neighbourhood, mean_subtracted, velocity_profile, outer_inner: with floor and 1/2 |a| (K dt)^2, also capped at
  /// r/2; displacement_history: floor and the same caps; the others: one skin. With automatic K the cap is
  /// k_automatic_cap r alone: see there.
  double operator()(double r, double v, double a) const {
    double s = 0;
    const double rc = r + range(r);
    switch (policy) {
      case ListPolicy::always:
        return 0;
      case ListPolicy::uniform:
      case ListPolicy::two_largest:
      case ListPolicy::accumulated:
      case ListPolicy::fixed:
        s = uniform;
        break;
      case ListPolicy::paper:
      case ListPolicy::local:
      case ListPolicy::global_velocity:
      case ListPolicy::neighbourhood:
      case ListPolicy::mean_subtracted:
      case ListPolicy::velocity_profile:
      case ListPolicy::outer_inner:
      case ListPolicy::displacement_history:
        s = policy == ListPolicy::displacement_history ? v : k_dt * v;
        if (acceleration_on) s += 0.5 * a * k_dt * k_dt;
        if (floor_on) s = fmax2(s, floor * 2 * r);
        if (cap_on) {
          s = fmin2(s, 0.5 * cell_edge - rc);
          if (policy != ListPolicy::paper && policy != ListPolicy::global_velocity) s = fmin2(s, cap * r);
        }
        break;
    }
    s = fmin2(s, largest - rc);
    return s > 0 ? s : 0;
  }

  /// Skin in the outer list of a particle of radius r whose skin in the inner one is s [m].
  double outer_skin(double r, double s) const { return fmax2(s, fmin2(outer * s, most(r))); }

  /// How far a particle of this skin may move before the list expires, beside its drift, seen from a wall at rest [m]:
  /// two_largest lets one particle use up both skins.
  double to_walls(double skin) const { return policy == ListPolicy::two_largest ? 2 * skin : skin; }
};

}  // namespace talus
