// The skin of one particle, from what its list policy says (scheduler/lists/policies).
// Who calls it: cell_grid.cpp (skins), skin_check.cpp (validity), tuner.cpp (K, floor). Invariants: I2 (the skin is
// clamped first; what is stored is what is checked); the largest R_NL on a periodic axis is L/4, so that displacements
// and pairs have one minimum image.
#pragma once

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/rules/adhesion.hpp"
#include "core/scene/scene.hpp"
#include "scheduler/lists/policies/policy.hpp"

namespace talus {

/// Cap of the skins, in radii, where the run chooses K. Grains in free fall use up r/2 within some 20 steps, and then
/// all lists have to be made again for the sake of a few. Beyond the ordinary cap they get cells of their own
/// (scheduler/lists/cell_grid.cpp), so that the others' search stays as it is.
inline constexpr double k_automatic_cap = 1.5;

/// velocity_profile: reaches are at most this much longer than those of local, which bounds slope times life of a
/// list; see scheduler/lists/velocity_profile.hpp.
inline constexpr double k_most_stretch = 1.25;

/// Parameters of the skin rule, fixed for one rebuild.
struct SkinRule {
  const Policy* policy = nullptr;
  double k_dt = 0;  ///< K * dt [s]
  bool floor_on = true, acceleration_on = true, cap_on = true;
  double floor = 0;         ///< of the particle's diameter
  double cell_edge = 0;     ///< nominal cell edge L_C [m] of the cap
  double cap = 0.5;         ///< largest grown skin of policies with a floor, of the radius
  double largest = 0;       ///< hard limit of R_NL [m]: L/4 on the shortest periodic axis
  double uniform = 0;       ///< skin of the policies with one skin [m]
  double reach = 0;         ///< R_C = r + reach r^(1/3): range of adhesion (core/rules/adhesion.hpp)
  double outer = 1;         ///< outer_inner: skins of the outer list / those of the inner one
  double drift_travel = 0;  ///< policies that drift: how far the drift may run past walls [m]

  SkinRule() = default;
  /// `r_min`, `r_max`: radii of the scene [m].
  SkinRule(const Scene& s, double r_min, double r_max) {
    policy = &policy_of(s.list.policy);
    k_dt = s.list.verlet_k * s.dt;
    floor_on = policy->floor && s.list.floor_on;
    acceleration_on = policy->terms && s.list.acceleration_on;
    cap_on = s.list.cap_on;
    floor = s.list.floor;
    cell_edge = (s.list.cell_factor > 0 ? s.list.cell_factor : 1.5) * 2 * r_max;
    if (policy->terms && s.list.automatic && !(s.list.cell_factor > 0)) {
      cap = k_automatic_cap;
      cell_edge = 1e300;
    }
    uniform = s.list.uniform_skin * r_min;
    reach = adhesion_reach(s);
    if (policy->cuts) outer = s.list.outer;
    if (policy->drifts) drift_travel = 0.5 * r_min;
    largest = 1e300;
    for (int k = 0; k < 3; ++k)
      if (s.domain.periodic(k)) largest = fmin2(largest, 0.25 * (s.domain.upper[k] - s.domain.lower[k]));
    largest /= policy->stretch;
    if (policy->one_bound) {
      uniform = fmin2(uniform, largest - r_max - range(r_max));
      if (!(uniform > 0)) uniform = 0;
    }
  }

  /// R_C - r [m]: how far beyond its surface a particle can be in contact with another one; with a wall, twice that.
  double range(double r) const { return reach > 0 ? reach * det::cbrt(r) : 0; }

  bool has_k() const noexcept { return policy->has_k; }
  bool drifts() const noexcept { return policy->drifts; }
  bool cuts() const noexcept { return policy->cuts; }
  /// The list is judged by skin_check.cpp instead of the check in the integration kernel.
  bool own_check() const noexcept { return policy->check != Policy::Check::each; }

  /// The most that operator() gives to a radius of r [m].
  double most(double r) const {
    const double rc = r + range(r);
    double s = largest - rc;
    if (cap_on) {
      s = fmin2(s, 0.5 * cell_edge - rc);
      if (policy->floor) s = fmin2(s, cap * r);
    }
    return s > 0 ? s : 0;
  }

  /// Skin [m] of a particle of radius r [m], speed v [m/s] (see Policy::speed), acceleration a [m/s2]. Grown skins are
  /// capped at L_C/2 - R_C (the paper's printed cap L_C loses pairs), with a floor also at r/2. With automatic K the
  /// cap is k_automatic_cap r alone: see there.
  double operator()(double r, double v, double a) const {
    if (policy->skin == Policy::Skin::none) return 0;
    const double rc = r + range(r);
    double s = uniform;
    if (policy->skin == Policy::Skin::grown) {
      s = policy->has_k ? k_dt * v : v;
      if (acceleration_on) s += 0.5 * a * k_dt * k_dt;
      if (floor_on) s = fmax2(s, floor * 2 * r);
      if (cap_on) {
        s = fmin2(s, 0.5 * cell_edge - rc);
        if (policy->floor) s = fmin2(s, cap * r);
      }
    }
    s = fmin2(s, largest - rc);
    return s > 0 ? s : 0;
  }

  /// Skin in the outer list of a particle of radius r whose skin in the inner one is s [m].
  double outer_skin(double r, double s) const { return fmax2(s, fmin2(outer * s, most(r))); }

  /// How far a particle of this skin may move before the list expires, beside its drift, seen from a wall at rest [m].
  double to_walls(double skin) const { return policy->skins_used * skin; }
};

}  // namespace talus
