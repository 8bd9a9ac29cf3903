// Part "heat": temperatures of grains. Every `heat.every` steps each grain exchanges heat with what it touches, what is
// near, walls, gas and radiation; explicit in time, so that what one grain gains its partner loses to the bit. Here is
// its state; what other parts see of it stands in doors.hpp.
//
//   heat_contacts[c]  conduction of pairs: flow and conductance of each row, in list order (I3)
//   heat_friction[c]  every step, where contacts heat grains: what they have dissipated
//   heat_step         walls, near grains, gas, enclosure; then enthalpies and temperatures
//
// Invariants: all flows of a heat step are those of the temperatures at its begin; a heat step in which some grain
// could overshoot what surrounds it (dt sum G > C) ends the run.
#pragma once

#include <vector>

#include "core/heat/contact.hpp"
#include "core/heat/convection.hpp"
#include "core/heat/enthalpy.hpp"
#include "scheduler/parts/doors.hpp"
#include "scheduler/parts/heat_bodies.hpp"

namespace talus {

/// Matter of a scene, ready to be asked.
struct HeatMatter {
  heat::Enthalpy enthalpy;
  heat::Property conductivity;
  double emissivity = 0;
  double least_capacity = 0;  ///< [J/kg/K]
  double expansion = 0;       ///< [1/K]
};

/// Contacts of two materials.
struct HeatPair {
  enum class Radius { overlap, force, neck } radius = Radius::overlap;
  double scale = 1;                                 ///< on the radius: softened contacts
  double kn = 0, e_star = 0;                        ///< Radius::force [N/m], [Pa]
  double kappa = 0;                                 ///< Radius::neck [m]
  double of(double r_star, double overlap) const {  ///< radius of the contact [m]
    if (radius == Radius::overlap) return scale * heat::hertz_contact_radius(r_star, overlap);
    return radius == Radius::force ? heat::hertz_radius_of_force(r_star, kn * overlap, e_star)
                                   : scale * heat::jkr_contact_radius(r_star, overlap, kappa);
  }
};

/// What has come in since the start [J].
struct HeatTotals {
  double sources = 0, removed = 0, walls = 0, gas = 0, radiation = 0, friction = 0, held = 0, inside = 0;
};

struct HeatMelt {
  bool any = false;
  Column<double> share, next;  ///< of the grain
};
struct HeatSizes {
  bool any = false;
  std::vector<double> areas;   ///< by shape of bodies, of scale 1 [m2]
  Column<double> radii, next;  ///< [2 n]: radius to come at the next heat step, at 0 K [m]
};
/// What a unit of conductance receives of a given flux, by heat.wall entries [K], of a step; for contact files.
struct HeatFluxes {
  std::vector<double> shares;
  std::int64_t step = -1;
};

/// How many steps the present heat step has: `every`, or `every` 2^k where an error is wanted (heat_pace.cpp). It ends
/// behind step n with (n + 1) mod steps = 0, so that it has begun where the last one ended.
struct HeatPace {
  std::int64_t steps = 1, steps_before = 1;
  double error = 0, error_before = 0;  ///< half of the largest change of temperature in the last heat step [K]
  std::vector<PartConcern> concerns;   ///< of the last heat step
};

/// State of the part; its nodes are free functions of it.
struct HeatState {
  explicit HeatState(const Rules& rules);

  const HeatScene& scene;
  std::vector<HeatMatter> matter;
  std::vector<HeatPair> pairs;  ///< materials squared
  std::vector<char> shells;     ///< by material: the part conversion computes its grains
  bool any_held = false;

  Column<double> temperature, next_temperature, enthalpy, next_enthalpy;  ///< [K], [J]
  HeatMelt molten;
  HeatSizes sizes;
  Column<double> loss;               ///< since the last heat step [J]
  Column<double> flow, conductance;  ///< of the present heat step [W], [W/K]
  Column<std::int16_t> held;         ///< source + 1 of grains that keep their temperature

  HeatTotals totals, totals_before;
  std::vector<double> wall_flow, wall_heat;  ///< of heat.wall entries, into grains: last heat step [W], all [J]
  std::vector<double> wall_area;             ///< of those with a flux [m2]; known from the first heat step on
  std::vector<double> source_flow;           ///< of sources that hold their temperature [W]
  std::int64_t last_step = -1;               ///< that ended with a heat step
  HeatPace pace;
  mutable HeatFluxes fluxes;
  const Clock* clock = nullptr;

  double dt(const PartView& w) const { return w.rules.scene.dt * static_cast<double>(pace.steps); }
  double middle(const PartView& w) const;  ///< time of the present heat step's middle [s]
  /// Mean of a table over the present heat step.
  double mean(const TimeTable& table, const PartView& w) const { return table.mean(middle(w), dt(w)); }
  bool ends(const PartView& w) const { return (w.clock.step + 1) % pace.steps == 0; }  ///< the heat step, behind this
  int material(const PartView& w, Row i) const { return w.rules.has.materials ? w.rows.material[i] : 0; }
  bool has_shells(const PartView& w, Row i) const { return shells[static_cast<std::size_t>(material(w, i))] != 0; }
  /// What gas and enclosure see of the grain that row i leads; of its other rows nothing [m2].
  double surface(const PartView& w, Row i) const;
  /// Heat step over the longest in which row i cannot overshoot: dt times its conductance over the capacity that
  /// follows at once; of a grain with shells that of the outermost one, behind half of it.
  double excess(const PartView& w, const GrainInside* inside, Row i) const;
  /// The same if six others of its kind touched row i, of a body each of its rows, by a hundredth of its radius.
  double excess_in_a_bed(const PartView& w, Row i) const;
  /// Of the surface; `inside`: null without grains that have shells.
  double conductivity(const PartView& w, const GrainInside* inside, Row i) const {
    if (inside != nullptr && has_shells(w, i)) return inside->surface(i).conductivity;
    return matter[static_cast<std::size_t>(material(w, i))].conductivity.at(temperature[static_cast<std::size_t>(i)]);
  }
  double emissivity(const PartView& w, const GrainInside* inside, Row i) const;
  const HeatPair& pair(int a, int b) const {
    return pairs[static_cast<std::size_t>(a) * matter.size() + static_cast<std::size_t>(b)];
  }
};

void heat_contacts(HeatState& s, const PartView& w, const Chunk& c);  ///< heat_contacts.cpp
/// The rows of a body behind its first one, i, show what that has come to; heat_bodies.cpp
void share_with_body(HeatState& s, const PartView& w, Row i);
/// Of the contact that rows i and j have now; `overlap` of their spheres; 0 of rows of one body [W/K].
double conductance_between(const HeatState& s, const PartView& w, Row i, Row j, double overlap);
double heat_of_pair(const HeatState& s, const PartView& w, Row i, Row j, double overlap);  ///< conducted into i [W]
/// The same of a contact with a wall. [W]; heat_walls.cpp
double heat_of_wall(const HeatState& s, const PartView& w, Row i, int wall, double overlap);
double layer_conductance(const WallHeat& wall, double r);  ///< over the cross-section of a grain of radius r [W/K]
/// Of the contact of row i at this place of a wall without the wall's layer; 0: they do not touch [W/K].
double touch_of_wall(const HeatState& s, const PartView& w, const WallHeat& wall, Row i, const WallContact& near);
std::vector<int> heat_wall_entries(const HeatState& s, const WallSet& walls);  ///< [[heat.wall]] of each wall, or -1
void heat_walls(HeatState& s, const PartView& w);  ///< heat_walls.cpp: adds to flow, conductance
void heat_step(HeatState& s, const PartView& w);   ///< heat_step.cpp
/// Steps of the next heat step, from the largest change of a temperature [K] and the largest excess in the last one.
void choose_pace(HeatState& s, const PartView& w, double change, double excess);  ///< heat_pace.cpp
GasNear given_gas(const HeatState& s, const PartView& w, Row i);                  ///< of [heat.gas]; heat_step.cpp
std::vector<std::string> heat_advice(const HeatState& s, const PartView& w);      ///< heat_advice.cpp

}  // namespace talus
