// What the surface of a grain is to gas and radiation: its area, film and emissivity. Invariants: see heat.hpp.
#include "scheduler/parts/heat.hpp"

namespace talus {

double HeatState::surface(const PartView& w, Row i) const {
  const double r = w.rows.p[4L * i + 3];
  const std::int32_t b = w.rows.body_of(i);
  if (b < 0) return 4 * det::k_pi * (r * r);
  if (!w.rows.leads(i)) return 0;
  const double scale = w.rows.bodies.scale(b);
  return sizes.areas[static_cast<std::size_t>(w.rows.bodies.shape[static_cast<std::size_t>(b)])] * (scale * scale);
}

GasNear given_gas(const HeatState& s, const PartView& w, Row i) {
  const GasHeat& g = s.scene.gas;
  if (!g.on) return {};
  const double* u = velocity_of(w.rows, i).v;
  const Vec3 v{u[0], u[1], u[2]};
  GasNear gas{s.mean(g.temperature, w), g.film, norm(g.velocity - v), 0, {}};
  if (g.film >= 0) return gas;
  const heat::GasAt at{gas.temperature, g.velocity,     g.density,
                       g.viscosity,     g.conductivity, g.viscosity * g.capacity / g.conductivity,
                       g.porosity};
  gas.film = heat::film_coefficient(g.law, at, v, 2 * heat_size(w, i));
  return gas;
}

double HeatState::emissivity(const PartView& w, const GrainInside* inside, Row i) const {
  if (inside != nullptr && has_shells(w, i)) return inside->surface(i).emissivity;
  return matter[static_cast<std::size_t>(material(w, i))].emissivity;
}

}  // namespace talus
