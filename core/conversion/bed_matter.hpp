// Matter as plain arrays for the solver of many grains (bed_step.hpp), and how the numbers of a grain lie in its row.
// Who calls it: kernels/conversion, parts, tests. Invariant: no std container and no inline function in what crosses
// units of different instruction sets; pointers are to the arrays of the BedTables that made it.
#pragma once

#include <memory>

namespace talus::conversion {

struct Matter;

inline constexpr int k_bed_kinds = 4;     ///< moisture, fuel, char, ash: as Kind
inline constexpr int k_bed_elements = 5;  ///< as Element
inline constexpr int k_bed_shells = 32;   ///< the most
inline constexpr int k_bed_gases = 32;
inline constexpr int k_bed_solids = 40;

/// From low on the value grows by the sum of power[k] (T - low)^(k + 1); beyond high it stays.
struct BedPiece {
  double low, high;
  int powers;
  const double* power;
  const double* area;  ///< power[k] / (k + 2)
};
struct BedProperty {
  double first;
  int pieces;
  const BedPiece* piece;
};

struct BedYield {
  int species;
  double mass;  ///< [kg] per kg of the reactant
};

struct BedReaction {
  int reactant;
  double A, n, E;   ///< [1/s/K^n], [-], E over the gas constant [K]
  double heat;      ///< released per kg of the reactant [J/kg], where it holds
  double standard;  ///< that and what goes to gas cells beyond it [J/kg]
  int solids, gases;
  const BedYield *solid, *gas;
  double leaving[k_bed_elements];  ///< elements that leave the solid per kg
  double by_kind[k_bed_kinds];     ///< sensible heat of the reactant less that of its solid products, by kind
  double gas_mass, takes_gas;      ///< made; taken up, 1 for reactions of gas
  int own_capacity, refers;        ///< gas_capacity counts; `heat` holds at the reference temperature
  BedProperty gas_capacity;
  double own_sensible0;
};

struct BedChar {
  int oxidant;  ///< 0 oxygen, 1 carbon dioxide, 2 steam
  double A, n, E;
  double ratio_A, ratio_E;  ///< CO/CO2; E over the gas constant [K]
  double to_cells;          ///< [J/kg]
};

struct BedMatter {
  int shells, solids, gases;
  const int* kind;                              ///< [solid]
  const double (*composition)[k_bed_elements];  ///< [solid]
  const double* density;                        ///< [solid] of the initial grain [kg/m3]
  double trace;                                 ///< what remains of a solid below it reacts too [kg/m3]
  const double* volume;                         ///< [shell] initial volume of a grain of radius 1 m
  const BedReaction* reaction;                  ///< primary ones by reactant, then those of gas
  const int* first;                             ///< [solids + 1] into reaction
  const double* cold;                           ///< [solid] below this temperature its reactions are left out [K]
  const double* still;                          ///< [solid] below this they do next to nothing in a second [K]
  int secondary, reactions;                     ///< reactions [secondary, reactions) are those of gas
  const BedChar* burning;
  int chars;
  int moisture;                                  ///< the solid, or -1
  int boils, dries;                              ///< at boiling temperature; by vapour pressure too
  double boiling, evaporation, per_evaporation;  ///< [K], [J/kg], [kg/J]
  double vapour_to_cells;                        ///< [J/kg]
  double shrink[3];                              ///< by drying, devolatilisation, burn-off
  BedProperty capacity[k_bed_kinds], conductivity[k_bed_kinds], gas_capacity;  ///< conductivity[0]: of moist matter
  int present[k_bed_kinds];                                                    ///< some solid is of this kind
  double sensible0[k_bed_kinds], gas_sensible0;  ///< integrals at the reference temperature; 0 without
  double least_conductivity;
  double char_carbon, char_steam, char_hydrogen;  ///< as in Matter
  int by_mass, convects, blows, carries;          ///< carries: the flow of gas through the shells counts
  int asks_gas;                                   ///< its heat capacity is asked for in the shells
  double emissivity[3], porosity, pores;          ///< pores: porosity times tortuosity factor
  double fuel_density, moisture_density;          ///< of the initial grain [kg/m3]
  double per_fuel_density, per_moisture_density;  ///< their reciprocals, 0 where there is none
  int first_of_kind[k_bed_kinds + 1];
  const int* turns;                                       ///< [solid] place among those that something consumes, or -1
  const int* grows;                                       ///< [solid] place among those that a reaction makes, or -1
  int turning, growing;                                   ///< how many
  int changes[k_bed_kinds], grown[k_bed_kinds];           ///< masses of this kind may change; grow
  const int* of_kind;                                     ///< solids by kind
  const double* per_volume;                               ///< [shell] 1 / volume
  int vapour, carbon_monoxide, carbon_dioxide, hydrogen;  ///< gases, or -1
  double gas_molar, viscosity, viscosity_S, gas_conductivity, gas_conductivity_S, gas_heat, gas_heat_slope;
  int film_law;  ///< 0 Ranz-Marshall, 1 Whitaker, 2 Wakao
};

/// Places in the row of a grain; each of the first stretches over the shells, from the centre outwards.
struct BedRow {
  int temperature, debt, face, mass, burnt;
  int radius0, surface;  ///< initial radius [m], surface temperature [K]
  int carried, outflow;  ///< heat capacity flow [W/K] and mass flow [kg/s] of the gas that comes out
  int size;              ///< doubles, a multiple of 8
};
BedRow bed_row(const BedMatter& m);

struct GasKind;
enum class FilmLaw;

/// Owns the arrays of a BedMatter.
class BedTables {
 public:
  /// `matter` has passed check_matter. Error{scene}: melting, or more shells than k_bed_shells.
  BedTables(const Matter& matter, int shells, const GasKind& gas, FilmLaw law);
  BedTables(const BedTables&) = delete;
  BedTables& operator=(const BedTables&) = delete;
  ~BedTables();
  const BedMatter& matter() const;
  double thinnest_shell() const;  ///< its width in a grain of radius 1 m
  /// The row of a grain of this radius at one temperature [m, K].
  void begin(double radius, double temperature, double* row) const;

  struct Arrays;

 private:
  std::unique_ptr<Arrays> a_;
};

/// Heat [J], mass [kg], elements [kg] and means of a row.
struct BedTotals {
  double heat = 0, mass = 0, mean = 0, moisture = 0, fuel = 0, char_mass = 0, ash = 0;
  double elements[k_bed_elements] = {};
};
BedTotals bed_totals(const Matter& matter, const BedMatter& m, const double* row);

// Columns that go in and come out of a step, one double per grain each.
enum BedIn : int {
  k_in_gas,           ///< temperature of the gas [K]
  k_in_velocity,      ///< relative to the grain [m/s]
  k_in_wall,          ///< temperature of what the surface sees [K]
  k_in_sees,          ///< share of the surface that radiates to it [-]
  k_in_flux,          ///< into the surface [W/m2]
  k_in_contact,       ///< conductance to neighbours [W/K]
  k_in_contact_heat,  ///< sum of conductance times temperature of the neighbours [W]
  k_in_film,          ///< coefficient [W/m2/K]; negative: by the law
  k_in_apart,         ///< share of the film's heat that is not exchanged here but comes with k_in_flow
  k_in_flow,          ///< heat into the surface whatever its temperature [W]
  k_in_partner,       ///< sum of the conductances that k_in_flow came through [W/K]
  k_in_partner_heat,  ///< sum of conductance times temperature of what it came from [W]
  k_in_oxygen,
  k_in_carbon_dioxide,
  k_in_steam,       ///< mass fractions
  k_in_molar,       ///< of the gas, a mixture [kg/mol]
  k_in_pressure,    ///< of the gas now; that of the batch decides where water boils [Pa]
  k_in_condensing,  ///< water that the surface gets from the gas while it is as cold as at the start [kg]; mostly 0
  k_in_dew,         ///< temperature of the outermost shell at which it gets none [K]
  k_in_dew_heat,    ///< heat that it brings, less that of the water at the temperature of the shell [J/kg]
  k_bed_in
};
enum BedOut : int {
  k_out_heat_in,   ///< through the surface in the step [J]
  k_out_contact,   ///< of that, from neighbours and with k_in_flow [J]
  k_out_reaction,  ///< released by reactions and evaporation [J]
  k_out_with_gas,  ///< sensible heat of solids that became gas [J]
  k_out_standard,  ///< constants of what reacted, by extents alone: cell_gases.hpp [J]
  k_out_oxygen,
  k_out_carbon_dioxide,
  k_out_steam,  ///< taken from outside [kg]
  k_out_radius,
  k_out_mass,
  k_out_mean,
  k_out_surface,
  k_out_centre,
  k_out_moisture,
  k_out_fuel,
  k_out_char,
  k_out_ash,
  k_out_outside,       ///< surface temperature at which it would be in balance with its partners too [K]
  k_out_excess,        ///< step over the time that heat takes through a shell that still holds fuel, the largest
  k_out_capacity,      ///< heat into the surface over the rise of the outermost shell that it makes in the step [J/K]
  k_out_inner,         ///< conductance from its middle to the surface [W/K]
  k_out_conductivity,  ///< of the outermost shell [W/m/K]
  k_out_emissivity,
  k_out_condensed,                              ///< water, a part of k_out_steam [kg]
  k_out_gone,                                   ///< elements that left [kg]
  k_out_released = k_out_gone + k_bed_elements  ///< gases [kg]
};

/// Grains to be advanced by one step.
struct GrainBatch {
  long grains = 0;
  double* const* row = nullptr;  ///< [grains]
  const double* in = nullptr;    ///< [k_bed_in] columns
  double* out = nullptr;         ///< [k_out_released + gases] columns
  long stride = 0;               ///< doubles between columns: at least `grains` rounded up to 8
  double dt = 0, pressure = 101325;
  double* scratch = nullptr;  ///< bed_scratch() doubles, 64-byte aligned
};
/// For batches of any instruction set.
long bed_scratch(const BedMatter& m);
long bed_work(const BedMatter& m);  ///< [doubles per lane] of the working arrays alone

}  // namespace talus::conversion
