// Drag of a gas on the grains of a bed, without the force of the pressure gradient, which is a term of its own. Who
// calls it: core/gas/flow.cpp (resistance of a cell), scheduler/parts/gas_coupling.cpp (shares of its grains). All laws
// are given as F = drag / (3 pi mu d U), with U = porosity * |gas - grain| and Re = rho U d / mu (both superficial).
#pragma once

#include "core/scene/gas_settings.hpp"

namespace talus::gas {

/// F of a bed of equal spheres [-]. ergun: Ergun (1952). gidaspow: Ergun below a porosity of 0.7, Wen and Yu (1966)
/// above 0.9, a smooth step between. di_felice: Di Felice (1994), force of model A. beetstra: Beetstra et al. (2007).
/// gidaspow and di_felice end in the drag of a single sphere at porosity 1; beetstra was fitted for porosities of 0.4
/// to 0.9 and is above it there (by 49 % at Re 500); ergun has no such limit.
double drag_factor(GasDrag law, double porosity, double re) noexcept;

/// Pressure gradient / superficial velocity of a bed: 18 mu (1 - e) F / (e d^2) [Pa s/m2]. `slip`: superficial [m/s].
double bed_resistance(GasDrag law, double porosity, double diameter, double viscosity, double density,
                      double slip) noexcept;

/// A grain's shape as its drag sees it. Alone in the gas a grain of drag coefficient C(Re), Re with the diameter of the
/// sphere of its volume, has C / newton = that of a sphere at stokes * newton * Re (Ganser 1993: K1, K2).
struct DragShape {
  double sphericity = 1;  ///< surface of the sphere of its volume / its own
  double stokes = 1, newton = 1;
};
/// K1 = 1 / (d_n / (3 d_v) + 2 / (3 sqrt(psi))) with d_n of the mean shadow of a convex body, a quarter of its surface
/// (Cauchy): K1 = sqrt(psi). lg K2 = 1.8148 (-lg psi)^0.5743. A sphericity of 1 gives a sphere, to the bit.
DragShape drag_shape(double sphericity) noexcept;

/// Of a grain whose volume is that of a sphere of diameter `own`, in a bed of Sauter diameter `mean` (6 volumes over
/// surfaces): drag / (gas - grain velocity) [kg/s]. Ergun's part goes by the volume of the grain (it holds for the bed
/// as a whole), the others by its own diameter and shape; beetstra knows spheres alone. `slip`: superficial [m/s].
double grain_drag(GasDrag law, double porosity, double own, double mean, double viscosity, double density, double slip,
                  const DragShape& shape = {}) noexcept;

/// Nusselt number of a grain [-]. Gunn (1978), Whitaker (1972), Ranz and Marshall (1952), Wakao (1979).
double nusselt(GasNusselt law, double porosity, double re, double prandtl) noexcept;

}  // namespace talus::gas
