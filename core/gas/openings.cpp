// See openings.hpp.
#include "core/gas/openings.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/gas/species.hpp"

namespace talus::gas {

int axis_of(GasSide side) noexcept { return static_cast<int>(side) / 2; }
bool is_high(GasSide side) noexcept { return static_cast<int>(side) % 2 == 1; }

std::vector<Opening> openings_of(const Grid& g, const GasSettings& s) {
  std::vector<Opening> all(g.outer.size());
  std::vector<int> owner(g.outer.size());
  int number = 0;
  for (const GasInlet& i : s.inlets) {
    ++number;
    const double t = i.temperature > 0 ? i.temperature : s.temperature;
    const GasFractions& y = i.own_fractions ? i.fractions : s.fractions;
    Opening o;
    o.gas_constant_t = specific_gas_constant(y) * t;
    o.enthalpy = enthalpy(y, t);
    o.fractions = y;
    o.pressure = i.pressure > 0 ? i.pressure : s.pressure;
    int faces = 0;
    for (std::size_t k = 0; k < g.outer.size(); ++k) {
      const OuterFace& f = g.outer[k];
      if (f.axis != axis_of(i.side) || f.high != is_high(i.side)) continue;
      bool inside = true;
      for (int q = 0; q < 3; ++q) {
        const double reach = q == f.axis ? 0.5 * g.h[q] : 0;  // a rectangle that is given lies in its side
        inside = inside && f.middle[q] >= i.lower[q] - reach && f.middle[q] <= i.upper[q] + reach;
      }
      if (!inside) continue;
      ++faces;
      o.kind = i.kind == GasInlet::Kind::flow ? Opening::Kind::flow : Opening::Kind::pressure;
      if (i.kind == GasInlet::Kind::flow)
        o.flux = s.pressure / o.gas_constant_t * i.velocity * g.area[static_cast<std::size_t>(f.axis)];
      all[k] = o;
      owner[k] = number;
    }
    if (faces == 0)
      throw Error(ErrorCode::scene,
                  fmt::format("gas.inlet {} ({}) covers no face of the grid", number, enum_word(i.side)), "gas",
                  "lower and upper must hold the middle of a cell's face, on a side that is not periodic");
  }
  for (int k = 1; k <= number; ++k)
    if (std::find(owner.begin(), owner.end(), k) == owner.end())
      throw Error(ErrorCode::scene, fmt::format("gas.inlet {} has no effect: later ones cover all of its faces", k),
                  "gas", "lower and upper say which part of a side an inlet has");
  return all;
}

}  // namespace talus::gas
