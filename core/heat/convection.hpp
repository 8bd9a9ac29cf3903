// Exchange of a grain with the gas around it: the interface between grains and whatever knows the gas, and Nusselt
// numbers. Who calls it: scheduler/parts/heat*, a part that computes the gas. Invariant: bits do not depend on the
// instruction set (I4).
#pragma once

#include "core/base/types.hpp"
#include "core/heat/value.hpp"
#include "core/scene/scene.hpp"

namespace talus::heat {

/// Gas at a grain.
struct GasAt {
  double temperature = 300;     ///< [K]
  Vec3 velocity;                ///< superficial [m/s]
  double density = 1.2;         ///< [kg/m3]
  double viscosity = 1.8e-5;    ///< [Pa s]
  double conductivity = 0.026;  ///< [W/m/K]
  double prandtl = 0.7;         ///< [-]
  double porosity = 1;          ///< of the bed there [-]
};

/// Ranz and Marshall 1952, Whitaker 1972, Gunn 1978, Wakao 1979. Re: of the superficial velocity and the diameter.
inline double nusselt(NusseltLaw law, double Re, double Pr, double porosity) {
  const double third = cube_root(Pr), e = porosity;
  switch (law) {
    case NusseltLaw::ranz_marshall:
      return 2 + 0.6 * square_root(Re) * third;
    case NusseltLaw::whitaker:
      return 2 + (0.4 * square_root(Re) + 0.06 * power(Re, 2.0 / 3)) * power(Pr, 0.4);
    case NusseltLaw::gunn:
      return (7 - 10 * e + 5 * e * e) * (1 + 0.7 * power(Re, 0.2) * third) +
             (1.33 - 2.4 * e + 1.2 * e * e) * power(Re, 0.7) * third;
    case NusseltLaw::wakao:
      return 2 + 1.1 * power(Re, 0.6) * third;
  }
  return 2;
}

/// Heat transfer coefficient of a sphere of diameter d that moves with v [W/m2/K].
inline double film_coefficient(NusseltLaw law, const GasAt& gas, Vec3 v, double d) {
  const double Re = gas.density * norm(gas.velocity - v) * d / gas.viscosity;
  return nusselt(law, Re, gas.prandtl, gas.porosity) * gas.conductivity / d;
}

}  // namespace talus::heat
