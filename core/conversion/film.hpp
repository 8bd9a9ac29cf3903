// Heat and mass transfer of a sphere-like grain in a gas stream: gas properties, Nusselt and Sherwood numbers. Who
// calls it: the command. Invariant: properties at the film temperature, the mean of gas and surface.
#pragma once

#include "core/conversion/around.hpp"

namespace talus::conversion {

enum class FilmLaw { ranz_marshall, whitaker, wakao };

struct GasKind {
  double molar;                               ///< [kg/mol]
  double viscosity, viscosity_S;              ///< Sutherland: at 273.15 K [Pa s], constant [K]
  double conductivity, conductivity_S;        ///< [W/m/K], [K]
  double heat_capacity, heat_capacity_slope;  ///< at 300 K [J/kg/K], [J/kg/K2]
  double inert;                               ///< without its oxygen [kg/mol]
};
/// White, Viscous Fluid Flow (Sutherland's law); heat capacities: JANAF, straight line between 300 and 1500 K.
inline constexpr GasKind k_air{0.028965, 1.716e-5, 111, 0.0241, 194, 1005, 0.175, 0.028154};
inline constexpr GasKind k_nitrogen{0.028013, 1.663e-5, 107, 0.0242, 150, 1040, 0.17, 0.028013};

/// Molar mass [kg/mol] of a mixture with these fractions by mass; `rest`: of what else is in it.
inline double mixture_molar(double oxygen, double carbon_dioxide, double steam, double rest) {
  return 1 / (oxygen / 0.031998 + carbon_dioxide / 0.04401 + steam / 0.018015 +
              (1 - oxygen - carbon_dioxide - steam) / rest);
}

inline double sutherland(double at_ice, double S, double T) {
  const double x = T / 273.15;
  return at_ice * x * heat::square_root(x) * (273.15 + S) / (T + S);
}

struct Film {
  double heat, mass;  ///< [W/m2/K], [m/s]
};

inline double transfer_number(FilmLaw law, double Re, double Pr) {
  const double root = heat::square_root(Re), third = heat::cube_root(Pr);
  switch (law) {
    case FilmLaw::ranz_marshall:
      return 2 + 0.6 * root * third;
    case FilmLaw::whitaker:
      return 2 + (0.4 * root + 0.06 * heat::power(Re, 2.0 / 3)) * heat::power(Pr, 0.4);
    case FilmLaw::wakao:
      return 2 + 1.1 * heat::power(Re, 0.6) * third;
  }
  return 2;
}

/// Of a grain of diameter d [m] in gas of temperature T with velocity u [m/s] at the film's conditions of the gas.
inline Film film_of(const GasKind& gas, FilmLaw law, double d, double u, double T_gas, double T_surface,
                    double pressure) {
  const double T = 0.5 * (T_gas + T_surface);
  const double mu = sutherland(gas.viscosity, gas.viscosity_S, T);
  const double k = sutherland(gas.conductivity, gas.conductivity_S, T);
  const double cp = gas.heat_capacity + gas.heat_capacity_slope * (T - 300);
  const double rho = gas_density(T, pressure, gas.molar), D = gas_diffusivity(T, pressure);
  const double Re = rho * u * d / mu;
  return {transfer_number(law, Re, mu * cp / k) * k / d, transfer_number(law, Re, mu / (rho * D)) * D / d};
}

}  // namespace talus::conversion
