// List policies: the skin of one particle. Adding a policy is one case here and its name in the scene keys.
// Who calls it: scheduler/rebuild.cpp. Invariants: I2 (the skin is clamped first; what is stored is what is checked).
#pragma once

#include <cmath>

#include "core/adhesion.hpp"
#include "core/det_math.hpp"
#include "core/scene.hpp"

namespace talus {

/// Parameters of the skin rule, fixed for one rebuild.
struct SkinRule {
  ListPolicy policy = ListPolicy::local;
  double k_dt = 0;  ///< K * dt [s]
  bool floor_on = true, acceleration_on = true, cap_on = true;
  double floor = 0;      ///< of the particle's diameter
  double cell_edge = 0;  ///< nominal cell edge L_C [m] of the cap
  double largest = 0;    ///< hard limit of R_NL [m]: L/4 on the shortest periodic axis
  double uniform = 0;    ///< uniform skin [m]
  double reach = 0;      ///< R_C = r + reach r^(1/3): range of adhesion (core/adhesion.hpp)

  SkinRule() = default;
  /// `r_min`, `r_max`: radii of the scene [m].
  SkinRule(const Scene& s, double r_min, double r_max) {
    policy = s.list.policy;
    k_dt = s.list.verlet_k * s.dt;
    const bool local = policy == ListPolicy::local;
    floor_on = local && s.list.floor_on;
    acceleration_on = local && s.list.acceleration_on;
    cap_on = s.list.cap_on;
    floor = s.list.floor;
    cell_edge = (s.list.cell_factor > 0 ? s.list.cell_factor : 1.5) * 2 * r_max;
    uniform = s.list.uniform_skin * r_min;
    reach = adhesion_reach(s);
    largest = 1e300;
    for (int k = 0; k < 3; ++k)
      if (s.domain.periodic(k)) largest = fmin2(largest, 0.25 * (s.domain.upper[k] - s.domain.lower[k]));
  }

  /// R_C - r [m]: how far beyond its surface a particle can be in contact with another one; with a wall, twice that.
  double range(double r) const { return reach > 0 ? reach * det::cbrt(r) : 0; }

  /// Skin [m] of a particle of radius r [m], speed v [m/s], acceleration a [m/s2]:
  /// paper: K |v| dt, capped at L_C/2 - r (the paper's printed cap L_C loses pairs); local: with floor and
  /// 1/2 |a| (K dt)^2, also capped at r/2; uniform: one skin; always: 0.
  double operator()(double r, double v, double a) const {
    double s = 0;
    const double rc = r + range(r);
    switch (policy) {
      case ListPolicy::always:
        return 0;
      case ListPolicy::uniform:
        s = uniform;
        break;
      case ListPolicy::paper:
      case ListPolicy::local:
        s = k_dt * v;
        if (acceleration_on) s += 0.5 * a * k_dt * k_dt;
        if (floor_on) s = fmax2(s, floor * 2 * r);
        if (cap_on) {
          s = fmin2(s, 0.5 * cell_edge - rc);
          if (policy == ListPolicy::local) s = fmin2(s, 0.5 * r);
        }
        break;
    }
    s = fmin2(s, largest - rc);
    return s > 0 ? s : 0;
  }
};

}  // namespace talus
