// Beds that tests of the gas put into a grid: uniform porosity without any grain of its own.
#pragma once

#include <cmath>

#include "core/gas/gas.hpp"

namespace talus::gas::testing {

/// Grains of diameter d at rest that leave `porosity` in every cell.
inline FromGrains uniform_bed(const Grid& g, double porosity, double d, Vec3 velocity = {}) {
  FromGrains s(g.cells());
  for (std::size_t c = 0; c < s.solid.size(); ++c) {
    s.solid[c] = (1 - porosity) * g.volume;
    s.specific[c] = s.solid[c] / d;
    s.moment[c] = s.solid[c] * velocity;
  }
  return s;
}

/// A column of n cells along z with a cross section of 1 cm2, blown from below, open at the top.
inline GasSettings column(double length, int n, double velocity) {
  GasSettings s;
  s.on = true;
  s.upper = {0.01, 0.01, length};
  s.cells = {1, 1, n};
  s.drag = GasDrag::ergun;
  GasInlet in, out;
  in.side = GasSide::bottom;
  in.velocity = velocity;
  out.side = GasSide::top;
  out.kind = GasInlet::Kind::pressure;
  s.inlets = {in, out};
  return s;
}

/// Mass per time that leaves through a side [kg/s].
inline double leaving(const Gas& gas, GasSide side) {
  double sum = 0;
  const Grid& g = gas.grid();
  for (std::size_t k = 0; k < g.outer.size(); ++k)
    if (g.outer[k].axis == static_cast<int>(side) / 2 && g.outer[k].high == (static_cast<int>(side) % 2 == 1))
      sum += gas.flow().outer_flux[k];
  return sum;
}

inline double largest(const GasFractions& y) {
  double m = 0;
  for (const double x : y) m = std::fmax(m, std::fabs(x));
  return m;
}

}  // namespace talus::gas::testing
