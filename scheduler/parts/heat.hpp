// Part "heat": temperatures of grains. Every `heat.every` steps each grain exchanges heat with what it touches, what is
// near, walls, gas and radiation; explicit in time, so that what one grain gains its partner loses to the bit. Here are
// its state and what it offers to other parts.
//
//   heat_contacts[c]  conduction of pairs: flow and conductance of each row, in list order (I3)
//   heat_friction[c]  every step, where contacts heat grains: what they have dissipated
//   heat_step         walls, near grains, gas, enclosure; then enthalpies and temperatures
//
// Invariants: all flows of a heat step are those of the temperatures at its begin; a heat step in which some grain
// could overshoot what surrounds it (dt sum G > C) ends the run.
#pragma once

#include <vector>

#include "core/heat/convection.hpp"
#include "core/heat/property.hpp"
#include "scheduler/part.hpp"

namespace talus {

/// A part that knows the gas around each grain, in place of [heat.gas].
class GasAround {
 public:
  virtual ~GasAround() = default;
  virtual heat::GasAt gas_at(const PartView& w, Row i) const = 0;
};

/// What a heat step has found for each row, with the temperatures at its begin: flow = sum G (T_other - T), and the sum
/// of G. An implicit grain may take flow - conductance (T_surface - T) as the heat into its surface, and breaks the
/// balance with its partners by the difference; flow alone keeps it.
struct SurfaceFlows {
  const double *flow, *conductance;  ///< [W], [W/K]; by row
  double dt = 0;                     ///< of the heat step [s]
};

/// A part that computes the inside of grains of some materials: it owns their enthalpy, heat owns what reaches their
/// surface.
class GrainInside {
 public:
  virtual ~GrainInside() = default;
  virtual bool owns(int material) const = 0;
  /// True: it exchanges with the gas and the enclosure by itself; the flows hold contacts, gaps and radiation of
  /// grains.
  virtual bool owns_film() const { return false; }
  /// Advances all rows that it owns by a heat step, and leaves their new surface temperatures [K] in `temperature`.
  virtual void advance(const PartView& w, const SurfaceFlows& flows, double* temperature) = 0;
  virtual double surface_capacity(Row i) const = 0;  ///< of what follows the surface at once: bounds the step [J/K]
};

/// What heat says of grains to other parts.
class GrainHeat {
 public:
  virtual ~GrainHeat() = default;
  virtual const Column<double>& temperature() const = 0;  ///< of the surface [K]
  virtual const Column<double>& from_gas() const = 0;     ///< heat that gas has given in the last heat step [J]
  virtual std::int64_t every() const = 0;                 ///< steps per heat step
};

/// Matter of a scene, ready to be asked.
struct HeatMatter {
  heat::Property capacity, conductivity;
  double emissivity = 0;
  double least_capacity = 0;  ///< [J/kg/K]
};

/// Contacts of two materials.
struct HeatPair {
  enum class Radius { overlap, force, neck } radius = Radius::overlap;
  double scale = 1;                                ///< on the radius: softened contacts
  double kn = 0, e_star = 0;                       ///< Radius::force [N/m], [Pa]
  double kappa = 0;                                ///< Radius::neck [m]
  double of(double r_star, double overlap) const;  ///< radius of the contact [m]
};

/// What has come in since the start [J].
struct HeatTotals {
  double sources = 0, removed = 0, walls = 0, gas = 0, radiation = 0, friction = 0, held = 0, inside = 0;
};

/// State of the part; its nodes are free functions of it.
struct HeatState {
  explicit HeatState(const Rules& rules);

  const HeatScene& scene;
  std::vector<HeatMatter> matter;
  std::vector<HeatPair> pairs;  ///< materials squared
  bool any_held = false;

  Column<double> temperature, next_temperature, enthalpy, next_enthalpy;  ///< [K], [J]
  Column<double> loss;                                                    ///< since the last heat step [J]
  Column<double> flow, conductance;                                       ///< of the present heat step [W], [W/K]
  Column<double> from_gas;                                                ///< in the last heat step [J]
  Column<std::int16_t> held;  ///< source + 1 of grains that keep their temperature

  HeatTotals totals, totals_before;
  std::vector<double> wall_flow, wall_heat;  ///< of heat.wall entries, into grains: last heat step [W], all [J]
  std::vector<double> wall_area;             ///< of those with a flux [m2]; known from the first heat step on
  std::vector<double> source_flow;           ///< of sources that hold their temperature [W]
  std::int64_t last_step = -1;               ///< that ended with a heat step
  const Clock* clock = nullptr;

  double dt(const PartView& w) const { return w.rules.scene.dt * static_cast<double>(scene.every); }
  double middle(const PartView& w) const;  ///< time of the present heat step's middle [s]
  int material(const PartView& w, Row i) const;
  const HeatPair& pair(int a, int b) const {
    return pairs[static_cast<std::size_t>(a) * matter.size() + static_cast<std::size_t>(b)];
  }
};

void heat_contacts(HeatState& s, const PartView& w, const Chunk& c);           ///< heat_contacts.cpp
std::vector<int> heat_wall_entries(const HeatState& s, const WallSet& walls);  ///< [[heat.wall]] of each wall, or -1
void heat_walls(HeatState& s, const PartView& w);  ///< heat_walls.cpp: adds to flow, conductance
void heat_step(HeatState& s, const PartView& w);   ///< heat_step.cpp
std::vector<std::string> heat_advice(const HeatState& s, const PartView& w);  ///< heat_advice.cpp

}  // namespace talus
