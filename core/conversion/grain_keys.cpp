// The table of grain_keys.hpp, and the help made from it.
#include "core/conversion/grain_keys.hpp"

#include <fmt/format.h>

#include <vector>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"

namespace talus::conversion {
namespace {

using T = GrainKeyType;
constexpr double k_big = 1e30, k_hot = 1e4;

constexpr GrainSection k_sections[] = {
    {"", false, "keys at the top of the file"},
    {"time", false, "steps and output"},
    {"grain", false, "shape, size and resolution"},
    {"material", false, "the grain's matter"},
    {"heat_capacity", false, "heat capacities as functions of temperature"},
    {"conductivity", false, "conductivities as functions of temperature"},
    {"drying", false, "how moisture leaves"},
    {"shrinkage", false,
     "volume = initial volume (1 - drying X)(1 - devolatilisation Y)(1 - burn_off Z) per shell, with the shares of "
     "moisture and fuel that have gone, and Z = Y times the share of the char that has burnt"},
    {"melting", false, "enthalpy method: solidus, liquidus, latent heat"},
    {"solid", true, "a solid of the grain, beside those of the scheme"},
    {"gas", true, "a gas that reactions release"},
    {"reaction", true, "first-order reaction of a solid, or of a gas on its way out: A T^n exp(-E/RT)"},
    {"char_reaction", true, "char with a gas from outside: rate of the surface A T^n exp(-E/RT)"},
    {"surroundings", false, "what the grain's surface meets"},
};

// section, name, type, unit, low, high, low_open, choices, fallback, doc, example
constexpr GrainKey k_keys[] = {
    {"", "title", T::text, "", 0, 0, false, "", "\"\"", "a line for reports", "\"Beech sphere in nitrogen\""},
    {"", "scheme", T::choice, "", 0, 0, false,
     "none|thurner_mann|chan|di_blasi|di_blasi_branca|wagenaar|font|liden|sadhukhan|debiagi", "\"none\"",
     "published pyrolysis scheme; its solids are wood, char and char2, or those of debiagi (hardwood)", "\"chan\""},

    {"time", "step", T::number, "s", 0, 1e6, true, "", "required", "heat step", "0.1"},
    {"time", "duration", T::number, "s", 0, 1e9, false, "", "required", "length of the run, in whole steps", "600"},
    {"time", "output_every", T::number, "s", 0, 1e9, true, "", "(the step)", "time between rows, in whole steps", "1"},
    {"time", "method", T::choice, "", 0, 0, false, "tr_bdf2|euler", "\"tr_bdf2\"",
     "second order and L-stable, or first order and monotone", "\"euler\""},
    {"time", "iterations", T::integer, "-", 1, 50, false, "", "3", "iterations of a stage", "4"},

    {"grain", "shape", T::choice, "", 0, 0, false, "plate|cylinder|sphere", "\"sphere\"", "what the shells are",
     "\"cylinder\""},
    {"grain", "diameter", T::number, "m", 0, 1e3, true, "", "required", "thickness of a plate", "0.02"},
    {"grain", "length", T::number, "m", 0, 1e6, true, "", "1", "length of a cylinder whose ends are insulated", "0.03"},
    {"grain", "area", T::number, "m2", 0, 1e9, true, "", "1", "area of one face of a plate", "0.01"},
    {"grain", "level", T::choice, "", 0, 0, false, "shells|lumped", "\"shells\"",
     "with gradients, or one temperature for all", "\"lumped\""},
    {"grain", "shells", T::integer, "-", 2, 1000, false, "", "20", "shells of equal thickness", "30"},
    {"grain", "temperature", T::number, "K", 1, k_hot, false, "", "required", "initial temperature", "300"},

    {"material", "density", T::number, "kg/m3", 0, 1e5, true, "", "required",
     "apparent density of the initial grain, moisture included", "682"},
    {"material", "moisture", T::number, "-", 0, 1, false, "", "0", "share of the initial mass", "0.1"},
    {"material", "ash", T::number, "-", 0, 1, false, "", "0", "share of the initial mass", "0.01"},
    {"material", "initial", T::shares, "-", 0, 1, false, "", "(wood = the rest)",
     "shares of the initial mass of solids beside moisture and ash", "{ CELL = 0.48, XYHW = 0.26 }"},
    {"material", "heat_of_pyrolysis", T::number, "J/kg", -1e8, 1e8, false, "", "0",
     "taken up by the scheme's reactions per kg of solid that becomes gas; not with debiagi, which has its own", "2e5"},
    {"material", "reference_temperature", T::number, "K", 1, k_hot, false, "", "(the temperature of reaction)",
     "where heats of reaction hold; else they hold at every temperature", "298.15"},
    {"material", "emissivity", T::one_or_three, "-", 0, 1, false, "", "0.9", "of the surface; or of fuel, char and ash",
     "[0.85, 0.95, 0.7]"},
    {"material", "porosity", T::number, "-", 0, 0.999, false, "", "0.6", "pores that gas fills and passes", "0.5"},
    {"material", "pore_diffusion", T::number, "-", 0, 1, true, "", "0.5",
     "effective diffusivity of pores over porosity times that of gas", "0.3"},
    {"material", "gas_convection", T::boolean, "", 0, 0, false, "", "true",
     "released gas exchanges heat with the shells that it passes", "false"},
    {"material", "blowing", T::boolean, "", 0, 0, false, "", "true", "outflow thins the exchange of the film", "false"},

    {"heat_capacity", "moisture", T::property, "J/kg/K", 0, k_big, true, "", "4180", "", "4180"},
    {"heat_capacity", "fuel", T::property, "J/kg/K", 0, k_big, true, "", "required", "of the dry solid",
     "{ polynomial = [1112, 4.85], origin = 273.15 }"},
    {"heat_capacity", "char", T::property, "J/kg/K", 0, k_big, true, "", "(that of fuel)", "", "1100"},
    {"heat_capacity", "ash", T::property, "J/kg/K", 0, k_big, true, "", "(that of char)", "",
     "{ table = [[300, 750], [1300, 1350]] }"},
    {"heat_capacity", "gas", T::property, "J/kg/K", 0, k_big, true, "", "1100", "of released gas", "1150"},

    {"conductivity", "fuel", T::property, "W/m/K", 0, k_big, true, "", "required", "of the dry solid",
     "{ polynomial = [0.13, 3e-4], origin = 273.15 }"},
    {"conductivity", "wet", T::property, "W/m/K", 0, k_big, true, "", "(that of fuel)", "of the initial, moist solid",
     "0.3"},
    {"conductivity", "char", T::property, "W/m/K", 0, k_big, true, "", "(that of fuel)", "", "0.1"},
    {"conductivity", "ash", T::property, "W/m/K", 0, k_big, true, "", "(that of char)", "", "1.2"},
    {"conductivity", "weights", T::choice, "", 0, 0, false, "fuel|mass", "\"fuel\"",
     "fuel's share of its initial mass, or of the mass of fuel and char", "\"mass\""},
    {"conductivity", "least", T::number, "W/m/K", 0, k_big, false, "", "0", "no conductivity is below", "0.02"},

    {"drying", "law", T::choice, "", 0, 0, false, "boiling|arrhenius|equilibrium", "\"boiling\"",
     "at a constant temperature as heat arrives; a rate; or by vapour pressure at the wet front, besides boiling, and "
     "backwards beside [gas]: steam above saturation condenses on the grain",
     "\"arrhenius\""},
    {"drying", "A", T::number, "1/s", 0, k_big, true, "", "5.13e10", "of the rate", "5.13e6"},
    {"drying", "E", T::number, "J/mol", 0, 1e7, false, "", "88000", "of the rate", "87900"},
    {"drying", "temperature", T::number, "K", 200, 1000, false, "", "373.15",
     "of boiling at the pressure of the gas around", "373.15"},
    {"drying", "heat", T::number, "J/kg", 0, 1e8, false, "", "2.2569e6", "of evaporation", "2.4e6"},

    {"shrinkage", "drying", T::number, "-", -1, 0.9, false, "", "0", "share of the volume", "0.1"},
    {"shrinkage", "devolatilisation", T::number, "-", -1, 0.9, false, "", "0", "share of the volume", "0.3"},
    {"shrinkage", "burn_off", T::number, "-", 0, 0.999, false, "", "0", "share of the volume", "0.95"},

    {"melting", "solidus", T::number, "K", 1, k_hot, false, "", "(none)", "", "1650"},
    {"melting", "liquidus", T::number, "K", 1, k_hot, false, "", "(the solidus)", "", "1700"},
    {"melting", "latent_heat", T::number, "J/kg", 0, 1e8, true, "", "(none)", "", "2.7e5"},

    {"solid", "name", T::text, "", 0, 0, false, "", "required", "", "\"intermediate\""},
    {"solid", "kind", T::choice, "", 0, 0, false, "moisture|fuel|char|ash", "\"fuel\"", "which properties it has",
     "\"char\""},
    {"solid", "composition", T::shares, "-", 0, 1, false, "", "(by its kind)", "shares of C, H, O, ash",
     "{ C = 0.5, H = 0.06, O = 0.44 }"},

    {"gas", "name", T::text, "", 0, 0, false, "", "required", "", "\"CO\""},
    {"gas", "composition", T::shares, "-", 0, 1, false, "", "(not known)", "shares of C, H, O",
     "{ C = 0.4288, O = 0.5712 }"},

    {"reaction", "name", T::text, "", 0, 0, false, "", "(from its reactant)", "", "\"wood to tar\""},
    {"reaction", "reactant", T::text, "", 0, 0, false, "", "required", "a solid, or a gas on its way out", "\"wood\""},
    {"reaction", "products", T::shares, "-", -10, 10, false, "", "required",
     "mass of each per mass of the reactant; a gas may be taken up (negative)", "{ char = 0.3, gas = 0.7 }"},
    {"reaction", "A", T::number, "1/s/K^n", 0, k_big, true, "", "required", "", "1e10"},
    {"reaction", "n", T::number, "-", -10, 10, false, "", "0", "", "1"},
    {"reaction", "E", T::number, "J/mol", 0, 1e7, false, "", "required", "", "1.5e5"},
    {"reaction", "heat", T::number, "J/kg", -1e9, 1e9, false, "", "0",
     "taken up per kg of the reactant; negative: released", "-3e5"},

    {"char_reaction", "oxidant", T::choice, "", 0, 0, false, "O2|CO2|H2O", "\"O2\"", "", "\"CO2\""},
    {"char_reaction", "A", T::number, "m/s/K^n", 0, k_big, true, "", "required", "", "1.715"},
    {"char_reaction", "n", T::number, "-", -10, 10, false, "", "1", "", "1"},
    {"char_reaction", "E", T::number, "J/mol", 0, 1e7, false, "", "required", "", "74830"},
    {"char_reaction", "ratio_A", T::number, "-", 0, k_big, false, "", "4.3", "CO/CO2 = ratio_A exp(-ratio_E/RT)",
     "2500"},
    {"char_reaction", "ratio_E", T::number, "J/mol", 0, 1e7, false, "", "28186", "", "51900"},

    {"surroundings", "gas", T::choice, "", 0, 0, false, "air|nitrogen", "\"nitrogen\"",
     "whose conductivity, viscosity and density the film has", "\"air\""},
    {"surroundings", "temperature", T::series, "K", 1, k_hot, false, "", "required", "of the gas",
     "[[0, 300], [100, 800]]"},
    {"surroundings", "wall_temperature", T::series, "K", 1, k_hot, false, "", "(none: no radiation)",
     "of the walls that the surface sees", "1273"},
    {"surroundings", "surface_temperature", T::series, "K", 1, k_hot, false, "", "(none)",
     "given surface temperature in place of all exchange", "[[0, 300], [60, 800]]"},
    {"surroundings", "film", T::series, "W/m2/K", 0, 1e7, false, "", "(from velocity)", "convective coefficient", "48"},
    {"surroundings", "velocity", T::series, "m/s", 0, 1e3, false, "", "0", "of the gas past the grain", "0.6"},
    {"surroundings", "law", T::choice, "", 0, 0, false, "ranz_marshall|whitaker|wakao", "\"ranz_marshall\"",
     "Nusselt and Sherwood numbers from the velocity", "\"whitaker\""},
    {"surroundings", "flux", T::series, "W/m2", -1e9, 1e9, false, "", "0", "given heat flux into the surface", "5e4"},
    {"surroundings", "contact_conductance", T::series, "W/K", 0, 1e6, false, "", "0", "to a body that touches", "0.01"},
    {"surroundings", "contact_temperature", T::series, "K", 1, k_hot, false, "", "(that of the gas)", "of that body",
     "500"},
    {"surroundings", "oxygen", T::series, "-", 0, 1, false, "", "0", "mass fraction in the gas", "0.233"},
    {"surroundings", "carbon_dioxide", T::series, "-", 0, 1, false, "", "0", "mass fraction in the gas", "0.1"},
    {"surroundings", "steam", T::series, "-", 0, 1, false, "", "0",
     "mass fraction in the gas; it slows drying, and does not condense", "0.2"},
    {"surroundings", "pressure", T::number, "Pa", 1e3, 1e8, false, "", "101325", "", "101325"},
};

std::string range_text(const GrainKey& k) {
  return fmt::format("{}{:g}, {:g}]{}", k.low_open ? "(" : "[", k.low, k.high,
                     k.unit.empty() ? "" : fmt::format(" [{}]", k.unit));
}

std::string full_text(const GrainKey& k) {
  return fmt::format("  {}{}{}: {}; {}. {}{}Example: {}\n", k.section, k.section.empty() ? "" : ".", k.name,
                     allowed_text(k), k.fallback == "required" ? "required" : fmt::format("default {}", k.fallback),
                     k.doc, k.doc.empty() ? "" : ". ", k.example);
}

}  // namespace

std::span<const GrainKey> grain_keys() noexcept { return k_keys; }
std::span<const GrainSection> grain_sections() noexcept { return k_sections; }

std::string allowed_text(const GrainKey& k) {
  switch (k.type) {
    case T::number:
      return "a number in " + range_text(k);
    case T::integer:
      return "an integer in " + range_text(k);
    case T::boolean:
      return "true or false";
    case T::text:
      return "a text of one line";
    case T::choice: {
      std::string words;
      for (const char c : k.choices) words += c == '|' ? std::string(", ") : std::string(1, c);
      return "one of " + words;
    }
    case T::property:
      return "a number, { polynomial = [a0, a1, ...], origin, range } or { table = [[T, value], ...] }, values in " +
             range_text(k);
    case T::series:
      return "a number or a list [[time, value], ...], values in " + range_text(k);
    case T::one_or_three:
      return "a number or 3 numbers, each in " + range_text(k);
    case T::shares:
      return "a table { name = number, ... }, each in " + range_text(k);
  }
  return {};
}

std::string grain_help(std::string_view key) {
  std::string text;
  std::vector<std::string> names;
  for (const GrainSection& s : k_sections) {
    std::string part;
    for (const GrainKey& k : k_keys) {
      if (k.section != s.name) continue;
      const std::string full = s.name.empty() ? std::string(k.name) : fmt::format("{}.{}", s.name, k.name);
      names.push_back(full);
      if (key.empty() || key == s.name || key == k.name || key == full) part += full_text(k);
    }
    names.emplace_back(s.name);
    if (part.empty()) continue;
    text += fmt::format("{}{}: {}\n{}\n",
                        s.name.empty() ? "top"
                        : s.repeated   ? fmt::format("[[{}]]", s.name)
                                       : fmt::format("[{}]", s.name),
                        "", s.doc, part);
  }
  if (!text.empty()) return text;
  throw Error(ErrorCode::usage, fmt::format("no grain key or section '{}'{}", key, did_you_mean(key, names)), "",
              "'talus help grain' lists all keys");
}

}  // namespace talus::conversion
