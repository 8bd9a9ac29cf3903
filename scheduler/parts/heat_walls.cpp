// Heat between walls and the grains that touch them. Serial, in row order and for each row in the order of walls (I3):
// contacts with walls are few. A wall without an entry in [[heat.wall]] is adiabatic.
#include <algorithm>

#include "core/heat/contact.hpp"
#include "scheduler/parts/heat.hpp"

namespace talus {
namespace {

/// At step 0, whatever the present pose: a resumed run finds the same.
double area_of(const PartView& w, const std::string& name) {
  WallSet walls = w.walls;
  walls.set_step(0, w.rules.scene.dt);
  double area = 0;
  for (int k = 0; k < walls.size(); ++k)
    if (walls.name(k) == name) area += walls.area(k);
  return area;
}

/// Of one contact with the wall's surface, which is as warm as the wall where its temperature is given [W/K]. r: radius
/// of the grain there [m].
double touch_conductance(const HeatState& s, const PartView& w, const WallHeat& wall, Row i, int number, double overlap,
                         double r) {
  const double T = wall.temperature.given() ? s.mean(wall.temperature, w) : s.temperature[static_cast<std::size_t>(i)];
  const int m = s.material(w, i), k = w.walls.material(number);
  return heat::contact_conductance(s.conductivity(w, part_as<GrainInside>(w.parts), i),
                                   s.matter[static_cast<std::size_t>(k)].conductivity.at(T),
                                   s.pair(m, k).of(r, overlap));
}

/// The same with the wall's layer behind it.
double conductance_of(const HeatState& s, const PartView& w, const WallHeat& wall, Row i, int number, double overlap,
                      double r) {
  const double g = touch_conductance(s, w, wall, i, number, overlap, r);
  return wall.layer.empty() ? g : heat::in_series(g, layer_conductance(wall, heat_size(w, i)));
}

double conductance_of(const HeatState& s, const PartView& w, const WallHeat& wall, const WallState& t) {
  return conductance_of(s, w, wall, t.row, t.contact.wall, w.rows.p[4L * t.row + 3] - t.contact.distance,
                        contact_radius(w, t.row, t.contact.normal));
}

template <class F>
void for_contacts(const PartView& w, const std::vector<int>& entry, F fn) {
  for (const auto& c : w.contacts.chunks)
    for (const WallState& t : c->wall.state) {
      const int e = entry[static_cast<std::size_t>(t.contact.wall)];
      if (e >= 0 && w.rows.is_alive(t.row)) fn(static_cast<std::size_t>(e), t);
    }
}

/// Radius of row i at the wall's contact of this overlap [m].
double radius_at_wall(const PartView& w, Row i, int wall, double overlap) {
  const double bound = w.rows.p[4L * i + 3];
  if (shaped_body(w, i) == nullptr) return bound;
  const WallState* found = nullptr;
  const auto off = [&](const WallState& t) { return __builtin_fabs((bound - t.contact.distance) - overlap); };
  for (const WallState& t : w.contacts.of(i).wall.state)
    if (t.row == i && t.contact.wall == wall && (found == nullptr || off(t) < off(*found))) found = &t;
  return found != nullptr ? contact_radius(w, i, found->contact.normal) : bound;
}

}  // namespace

double layer_conductance(const WallHeat& wall, double r) {
  return wall.layer[1] * (det::k_pi * (r * r)) / wall.layer[0];
}

double touch_of_wall(const HeatState& s, const PartView& w, const WallHeat& wall, Row i, const WallContact& near) {
  const WallState* found = nullptr;  // of several images the same
  const auto off = [&](const WallState& t) { return __builtin_fabs(t.contact.distance - near.distance); };
  for (const WallState& t : w.contacts.of(i).wall.state)
    if (t.row == i && t.contact.wall == near.wall && t.contact.element == near.element &&
        (found == nullptr || off(t) < off(*found)))
      found = &t;
  if (found == nullptr) return 0;
  return touch_conductance(s, w, wall, i, near.wall, w.rows.p[4L * i + 3] - found->contact.distance,
                           contact_radius(w, i, found->contact.normal));
}

std::vector<int> heat_wall_entries(const HeatState& s, const WallSet& walls) {
  std::vector<int> entry(static_cast<std::size_t>(walls.size()), -1);
  for (int k = 0; k < walls.size(); ++k)
    for (std::size_t e = 0; e < s.scene.walls.size(); ++e)
      if (s.scene.walls[e].wall == walls.name(k)) entry[static_cast<std::size_t>(k)] = static_cast<int>(e);
  return entry;
}

/// What a unit of conductance receives of a given flux, by entry [K].
std::vector<double> shares_of_flux(const HeatState& s, const PartView& w, const std::vector<int>& entry) {
  std::vector<double> share(s.scene.walls.size(), 0.0), sum(s.scene.walls.size(), 0.0);
  for_contacts(w, entry, [&](std::size_t e, const WallState& t) {
    if (s.scene.walls[e].flux.given()) sum[e] = sum[e] + conductance_of(s, w, s.scene.walls[e], t);
  });
  for (std::size_t e = 0; e < share.size(); ++e)
    if (sum[e] > 0)
      share[e] = s.mean(s.scene.walls[e].flux, w) *
                 (s.wall_area.empty() ? area_of(w, s.scene.walls[e].wall) : s.wall_area[e]) / sum[e];
  return share;
}

double heat_of_wall(const HeatState& s, const PartView& w, Row i, int wall, double overlap) {
  const std::vector<int> entry = heat_wall_entries(s, w.walls);
  const int e = entry[static_cast<std::size_t>(wall)];
  if (e < 0) return 0;
  const WallHeat& h = s.scene.walls[static_cast<std::size_t>(e)];
  const double g = conductance_of(s, w, h, i, wall, overlap, radius_at_wall(w, i, wall, overlap));
  if (h.temperature.given()) return g * (s.mean(h.temperature, w) - s.temperature[static_cast<std::size_t>(i)]);
  if (s.fluxes.step != w.clock.step) {
    s.fluxes.shares = shares_of_flux(s, w, entry);
    s.fluxes.step = w.clock.step;
  }
  return g * s.fluxes.shares[static_cast<std::size_t>(e)];
}

void heat_walls(HeatState& s, const PartView& w) {
  std::fill(s.wall_flow.begin(), s.wall_flow.end(), 0.0);
  if (s.scene.walls.empty()) return;
  const std::vector<int> entry = heat_wall_entries(s, w.walls);
  if (s.wall_area.empty())
    for (const WallHeat& wall : s.scene.walls) s.wall_area.push_back(wall.flux.given() ? area_of(w, wall.wall) : 0.0);
  const std::vector<double> share = shares_of_flux(s, w, entry);
  for_contacts(w, entry, [&](std::size_t e, const WallState& t) {
    const WallHeat& wall = s.scene.walls[e];
    const auto i = static_cast<std::size_t>(t.row);
    const double g = conductance_of(s, w, wall, t);
    double f = g * share[e];
    if (wall.temperature.given()) {
      f = g * (s.mean(wall.temperature, w) - s.temperature[i]);
      s.conductance[i] = s.conductance[i] + g;
    }
    s.flow[i] = s.flow[i] + f;
    s.wall_flow[e] = s.wall_flow[e] + f;
  });
}

}  // namespace talus
