// Body: the one place of a grain's volume, mass and moment of inertia. Who uses it: whoever needs one of them; 1/mass
// as the rows store it comes from here too. Invariant (I4): the order of the products is part of the trajectory.
#pragma once

#include "core/base/det_math.hpp"

namespace talus {

/// A solid sphere.
struct Body {
  double radius;       ///< [m]
  double density = 0;  ///< [kg/m3]

  static constexpr double k_inertia = 0.4;  ///< moment of inertia / (mass radius^2)

  double volume() const noexcept { return 4.0 / 3.0 * det::k_pi * (radius * radius * radius); }            ///< [m3]
  double mass() const noexcept { return density * (4.0 / 3.0 * det::k_pi) * (radius * radius * radius); }  ///< [kg]
  double inertia() const noexcept { return k_inertia * mass() * (radius * radius); }  ///< about any axis [kg m2]
};

}  // namespace talus
