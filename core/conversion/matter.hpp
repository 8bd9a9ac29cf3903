// What a grain consists of and what becomes of it, as data: species, reactions, drying, char reactions, shrinkage,
// properties. Who calls it: the grain solver, which reads it, and readers of grain files and presets, which make it.
// Invariants (checked by check_matter): mass and, where compositions are known, elements balance in every reaction;
// reactions lead from a species to later ones, never back.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/heat/property.hpp"

namespace talus::conversion {

using heat::both;
using heat::clamped;
using heat::exponential;
using heat::least;
using heat::less;
using heat::most;
using heat::power;
using heat::Property;
using heat::select;

inline constexpr double k_gas_constant = 8.31446261815324;  ///< [J/mol/K]

/// Conserved parts of matter, each a share of mass. Water is that of moisture and its vapour.
enum Element : std::size_t { carbon, hydrogen, oxygen, ash_element, water, k_elements };
using Composition = std::array<double, k_elements>;
inline constexpr const char* k_element_names[] = {"carbon", "hydrogen", "oxygen", "ash", "water"};

/// Which properties a solid has and how it counts in shrinkage.
enum class Kind : std::size_t { moisture, fuel, char_, ash, k_kinds };
inline constexpr std::size_t k_kinds = static_cast<std::size_t>(Kind::k_kinds);

struct Solid {
  std::string name;
  Kind kind = Kind::fuel;
  double initial = 0;  ///< share of the initial mass
  std::optional<Composition> composition;
};

struct Gas {
  std::string name;
  std::optional<Composition> composition;
};

struct Yield {
  std::size_t species;
  double mass;  ///< [kg] per kg of the reactant; of a gas it may be negative: taken up
};

/// First order in the reactant: rate = A T^n exp(-E/RT) times its mass.
struct Reaction {
  std::string name;
  std::size_t reactant = 0;    ///< a solid, or a gas where of_gas
  bool of_gas = false;         ///< secondary: of gas on its way through the shells
  double A = 0, n = 0, E = 0;  ///< [1/s/K^n], [-], [J/mol]
  double heat = 0;             ///< taken up per kg of the reactant [J/kg]; negative: released
  std::vector<Yield> solids, gases;
  std::optional<Property> gas_capacity =
      {};                    ///< of its gases, per kg of the reactant [J/K/kg]; none: gas_heat_capacity
  bool at_reaction = false;  ///< the heat holds at the temperature of reaction, whatever the others refer to
  double to_cells = 0;       ///< beside gas cells: cell_gases.hpp [J/kg]
};

/// Char with a gas from outside, at the char's front: rate of the surface A T^n exp(-E/RT) [m/s].
struct CharReaction {
  enum class Oxidant { oxygen, carbon_dioxide, steam };
  Oxidant oxidant = Oxidant::oxygen;
  double A = 0, n = 0, E = 0;               ///< [m/s/K^n], [-], [J/mol]
  double ratio_A = 4.3, ratio_E = 28186.0;  ///< CO/CO2 = A exp(-E/RT) of the products with oxygen
  double to_cells = 0;                      ///< beside gas cells: cell_gases.hpp [J/kg]
};

enum class Drying { none, arrhenius, boiling, equilibrium };
/// Boiling: at a constant temperature as heat arrives. Equilibrium: vapour pressure at the wet front, resistance of the
/// dry shells and the film, besides boiling.
struct DryingLaw {
  Drying kind = Drying::none;
  double A = 5.13e10, E = 88000;  ///< [1/s], [J/mol]
  double temperature = 373.15;    ///< of boiling [K]
  double heat = 2.26e6;           ///< of evaporation [J/kg]
  double to_cells = 0;            ///< beside gas cells: cell_gases.hpp [J/kg]
};

/// Volume = initial volume (1 - drying X)(1 - devolatilisation Y)(1 - burn_off Z), X, Y: shares of moisture and fuel
/// that have gone, Z: Y times the share of the char that has burnt.
struct Shrinkage {
  double drying = 0, devolatilisation = 0, burn_off = 0;
};

struct Melting {
  double solidus = 0, liquidus = 0, latent = 0;  ///< [K], [K], [J/kg]; latent = 0: none
};

struct Matter {
  std::string name;
  double density = 0;  ///< apparent, of the initial grain [kg/m3]
  std::vector<Solid> solids;
  std::vector<Gas> gases;
  std::vector<Reaction> reactions;
  std::vector<CharReaction> char_reactions;
  DryingLaw drying;
  Shrinkage shrinkage;
  Melting melting;
  std::array<Property, k_kinds> heat_capacity;  ///< [J/kg/K] by kind
  Property gas_heat_capacity;                   ///< of released gas [J/kg/K]
  Property conductivity_wet;                    ///< of the initial, moist matter [W/m/K]
  std::array<Property, k_kinds> conductivity;   ///< of dry fuel, char, ash (moisture: not used) [W/m/K]
  double least_conductivity = 0;
  bool conductivity_by_mass = false;  ///< weights of fuel and char: masses (else fuel's share of its initial mass)
  std::array<double, 3> emissivity{1, 1, 1};    ///< of fuel, char, ash surfaces
  std::optional<double> reference_temperature;  ///< heats of reaction hold there; none: at the temperature of reaction
  bool gas_convection = false;                  ///< released gas exchanges heat with the shells that it passes
  bool blowing = false;                         ///< released gas thins the film's exchange
  double porosity = 0.6;           ///< for the residence time of gas in secondary reactions and diffusion [-]
  double tortuosity_factor = 0.5;  ///< effective diffusivity of pores over that of gas, beside porosity [-]

  /// Of a kg of char that burns: its carbon, and what its other elements leave as (settle_char).
  double char_carbon = 1, char_steam = 0, char_hydrogen = 0;

  /// Gases of drying and of char reactions; check_matter adds those that are needed.
  std::optional<std::size_t> vapour, carbon_monoxide, carbon_dioxide, hydrogen;

  std::size_t solid(const std::string& solid_name) const;  ///< index; Error{scene} with the nearest name
  std::size_t gas(const std::string& gas_name) const;
};

/// Puts solids into an order in which every reaction leads forward. Error{scene}: a loop; a reaction whose mass (1e-6)
/// or elements (1e-3 of mass) do not balance; shares that do not sum to 1.
void check_matter(Matter& matter);

/// Sets what a kg of char is that burns: its carbon burns, its hydrogen and oxygen leave as steam and hydrogen, without
/// heat. Error{scene}: ash in it, more oxygen than steam takes, chars of several compositions. Part of check_matter,
/// which leaves such a mixture as carbon; defined beside the cells' gases.
void settle_char(Matter& matter);

/// Names of the pyrolysis presets, and one of them with wood (share 1 of the dry mass), its products and heat of
/// reaction 0; sources beside each. Error{scene}: no such preset.
std::vector<std::string> scheme_names();
void add_scheme(Matter& matter, const std::string& name);
/// The multi-component scheme, part of add_scheme; with compositions and heats of reaction.
void add_debiagi(Matter& matter);

}  // namespace talus::conversion
