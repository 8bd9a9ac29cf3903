// The multi-component scheme of Debiagi, Gentile, Cuoci, Frassoldati, Ranzi, Faravelli, J. Anal. Appl. Pyrolysis 134
// (2018) 326, for hardwood: cellulose, xylan, three lignins, extractives, char and gas trapped in it ("G...").
// Equations in moles as published; A in 1/s/K^n, E in cal/mol, heats of reaction (differences of heats of formation at
// 298 K, taken at all temperatures unless a reference is given) in kJ/g of the reactant.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <stdexcept>

#include "core/conversion/matter.hpp"

namespace talus::conversion {
namespace {

struct Atoms {
  const char* name;
  int C, H, O;
  char kind;  ///< f fuel, c char or trapped, g gas
};
constexpr Atoms k_atoms[] = {
    {"CELL", 6, 10, 5, 'f'},       {"CELLA", 6, 10, 5, 'f'},     {"XYHW", 5, 8, 4, 'f'},     {"HCE1", 5, 8, 4, 'f'},
    {"HCE2", 5, 8, 4, 'f'},        {"LIGH", 22, 28, 9, 'f'},     {"LIGO", 20, 22, 10, 'f'},  {"LIGC", 15, 14, 4, 'f'},
    {"LIGCC", 15, 14, 4, 'f'},     {"LIGOH", 19, 22, 8, 'f'},    {"LIG", 11, 12, 4, 'f'},    {"TGL", 57, 100, 7, 'f'},
    {"TANN", 15, 12, 7, 'f'},      {"ITANN", 8, 4, 4, 'f'},      {"CHAR", 1, 0, 0, 'c'},     {"GCO", 1, 0, 1, 'c'},
    {"GCO2", 1, 0, 2, 'c'},        {"GCH2O", 1, 2, 1, 'c'},      {"GCOH2", 1, 2, 1, 'c'},    {"GH2", 0, 2, 0, 'c'},
    {"GCH4", 1, 4, 0, 'c'},        {"GC2H4", 2, 4, 0, 'c'},      {"GC2H6", 2, 6, 0, 'c'},    {"GCH3OH", 1, 4, 1, 'c'},
    {"GC6H5OH", 6, 6, 1, 'c'},     {"CO", 1, 0, 1, 'g'},         {"CO2", 1, 0, 2, 'g'},      {"H2", 0, 2, 0, 'g'},
    {"H2O", 0, 2, 1, 'g'},         {"CH4", 1, 4, 0, 'g'},        {"C2H4", 2, 4, 0, 'g'},     {"C2H6", 2, 6, 0, 'g'},
    {"CH2O", 1, 2, 1, 'g'},        {"CH3OH", 1, 4, 1, 'g'},      {"HCOOH", 1, 2, 2, 'g'},    {"CH2OHCHO", 2, 4, 2, 'g'},
    {"CHOCHO", 2, 2, 2, 'g'},      {"CH3CHO", 2, 4, 1, 'g'},     {"C6H6O3", 6, 6, 3, 'g'},   {"C2H5CHO", 3, 6, 1, 'g'},
    {"CH2OHCH2CHO", 3, 6, 2, 'g'}, {"C6H10O5", 6, 10, 5, 'g'},   {"C5H8O4", 5, 8, 4, 'g'},   {"FURFURAL", 5, 4, 2, 'g'},
    {"C2H5OH", 2, 6, 1, 'g'},      {"CH3CO2H", 2, 4, 2, 'g'},    {"VANILLIN", 8, 8, 3, 'g'}, {"C6H5OCH3", 7, 8, 1, 'g'},
    {"CRESOL", 7, 8, 1, 'g'},      {"C24H28O4", 24, 28, 4, 'g'}, {"C2H3CHO", 3, 4, 1, 'g'},  {"MLINO", 19, 34, 2, 'g'},
    {"U2ME12", 13, 22, 2, 'g'},    {"C6H5OH", 6, 6, 1, 'g'},
};

/// Heat capacities of the gases between 300 and 1000 K over the gas constant: a0 + a1 T + ... + a4 T^4.
struct GasCapacity {
  const char* name;
  double a[5];
};
constexpr GasCapacity k_gas_capacities[] = {
    {"CO", {3.59508, -0.000721197, 1.28238e-06, 6.52429e-10, -8.21715e-13}},
    {"CO2", {2.20664, 0.010097, -9.96339e-06, 5.47156e-09, -1.27734e-12}},
    {"H2", {2.37694, 0.00773917, -1.88735e-05, 1.95517e-08, -7.17096e-12}},
    {"H2O", {4.20148, -0.00205584, 6.56547e-06, -5.52907e-09, 1.78283e-12}},
    {"CH4", {5.14911, -0.0136622, 4.91454e-05, -4.84247e-08, 1.66603e-11}},
    {"C2H4", {3.9592, -0.00757051, 5.7099e-05, -6.91588e-08, 2.69884e-11}},
    {"C2H6", {4.29143, -0.00550155, 5.99438e-05, -7.08466e-08, 2.68686e-11}},
    {"CH2O", {4.79372, -0.00990833, 3.7322e-05, -3.79285e-08, 1.31773e-11}},
    {"CH3OH", {5.65851, -0.0162983, 6.91938e-05, -7.58373e-08, 2.80428e-11}},
    {"HCOOH", {3.89836, -0.00355878, 3.55205e-05, -4.385e-08, 1.71078e-11}},
    {"CH2OHCHO", {6.14926, -0.00596828, 5.96003e-05, -7.16664e-08, 2.74014e-11}},
    {"CHOCHO", {4.68412, 0.000478013, 4.26391e-05, -5.79018e-08, 2.31669e-11}},
    {"CH3CHO", {4.72946, -0.00319329, 4.75349e-05, -5.74586e-08, 2.19311e-11}},
    {"C6H6O3", {0.598815, 0.0618494, -4.38009e-05, 1.55531e-08, -2.20507e-12}},
    {"C2H5CHO", {4.2453, 0.00668297, 4.93338e-05, -6.71986e-08, 2.67262e-11}},
    {"CH2OHCH2CHO", {2.66613, 0.0346302, -2.14381e-05, 6.90469e-09, -9.16939e-13}},
    {"C6H10O5", {-7.81242, 0.125425, -0.000116272, 5.44735e-08, -1.00746e-11}},
    {"C5H8O4", {-6.84199, 0.100611, -9.24173e-05, 4.29801e-08, -7.89719e-12}},
    {"FURFURAL", {-1.8626, 0.0570946, -4.76339e-05, 1.97949e-08, -3.26586e-12}},
    {"C2H5OH", {0.215806, 0.0295228, -1.68271e-05, 4.49485e-09, -4.02452e-13}},
    {"CH3CO2H", {2.7895, 0.00999942, 3.42572e-05, -5.09031e-08, 2.06222e-11}},
    {"VANILLIN", {-4.86637, 0.107211, -9.42598e-05, 4.25396e-08, -7.82416e-12}},
    {"C6H5OCH3", {-5.40889, 0.0873332, -7.3964e-05, 3.20208e-08, -5.56947e-12}},
    {"CRESOL", {-4.1048, 0.0823736, -6.80002e-05, 2.87115e-08, -4.87124e-12}},
    {"C24H28O4", {5.42487, 0.0999123, -5.13977e-05, -4.30175e-09, 8.76107e-12}},
    {"C2H3CHO", {0.733844, 0.0317483, -2.29599e-05, 8.42104e-09, -1.23613e-12}},
    {"MLINO", {-1.58762, 0.219527, -0.000145761, 4.95348e-08, -6.88637e-12}},
    {"U2ME12", {0.0679798, 0.15253, -0.000111376, 4.35664e-08, -7.15843e-12}},
    {"C6H5OH", {-0.290979, 0.0408562, 2.42829e-05, -7.14478e-08, 3.46002e-11}},
};

struct Equation {
  const char* text;
  double A, n, E, heat;
};
constexpr Equation k_equations[] = {
    {"CELL => CELLA", 1.5e14, 0, 47000, 0},
    {"CELLA => 0.40 CH2OHCHO + 0.03 CHOCHO + 0.17 CH3CHO + 0.25 C6H6O3 + 0.35 C2H5CHO + 0.20 CH3OH + 0.15 CH2O + "
     "0.49 CO + 0.05 GCO + 0.43 CO2 + 0.13 H2 + 0.93 H2O + 0.05 GCH2O + 0.02 HCOOH + 0.05 CH2OHCH2CHO + 0.05 CH4 + "
     "0.1 GH2 + 0.66 CHAR",
     2.5e6, 0, 19100, 0.72214},
    {"CELLA => C6H10O5", 3.3, 1, 10000, 0.78067},
    {"CELL => 4.45 H2O + 5.45 CHAR + 0.12 GCOH2 + 0.18 GCH2O + 0.25 GCO + 0.125 GH2 + 0.125 H2", 9e7, 0, 31000,
     -1.22687},
    {"XYHW => 0.35 HCE1 + 0.65 HCE2", 1.25e11, 0, 31400, 0.02272},
    {"HCE1 => 0.25 C5H8O4 + 0.25 C6H10O5 + 0.16 FURFURAL + 0.13 C6H6O3 + 0.09 CO2 + 0.1 CH4 + 0.54 H2O + "
     "0.06 CH2OHCH2CHO + 0.1 CHOCHO + 0.02 H2 + 0.1 CHAR",
     1.6e1, 1, 12900, 0.82425},
    {"HCE1 => 0.4 H2O + 0.39 CO2 + 0.05 HCOOH + 0.49 CO + 0.01 GCO + 0.51 GCO2 + 0.05 GH2 + 0.4 CH2O + 0.43 GCH2O + "
     "0.3 CH4 + 0.325 GCH4 + 0.1 C2H4 + 0.075 GC2H4 + 0.975 CHAR + 0.37 GCOH2 + 0.1 H2 + 0.2 GC2H6",
     3.0e-3, 1, 3600, -0.18173},
    {"HCE2 => 0.3 CO + 0.5125 CO2 + 0.1895 CH4 + 0.5505 H2 + 0.056 H2O + 0.049 C2H5OH + 0.035 CH2OHCHO + "
     "0.105 CH3CO2H + 0.0175 HCOOH + 0.145 FURFURAL + 0.05 GCH4 + 0.105 GCH3OH + 0.1 GC2H4 + 0.45 GCO2 + 0.18 GCH2O + "
     "0.7125 CHAR + 0.21 GH2 + 0.78 GCOH2 + 0.2 GC2H6",
     7.0e9, 0, 30500, 0.18632},
    {"LIGH => LIGOH + 0.5 C2H5CHO + 0.4 C2H4 + 0.2 CH2OHCHO + 0.1 CO + 0.1 C2H6", 6.7e12, 0, 37500, 0.30202},
    {"LIGO => LIGOH + CO2", 3.3e8, 0, 25500, 0.30206},
    {"LIGC => 0.35 LIGCC + 0.1 VANILLIN + 0.1 C6H5OCH3 + 0.27 C2H4 + H2O + 0.17 GCH2O + 0.4 GCOH2 + 0.22 CH2O + "
     "0.21 CO + 0.1 CO2 + 0.36 GCH4 + 5.85 CHAR + 0.2 GC2H6 + 0.1 GH2",
     1.0e11, 0, 37200, -0.04490},
    {"LIGCC => 0.25 VANILLIN + 0.15 CRESOL + 0.15 C6H5OCH3 + 0.35 CH2OHCHO + 0.7 H2O + 0.45 CH4 + 0.3 C2H4 + 0.7 H2 + "
     "1.15 CO + 0.4 GCO + 6.80 CHAR + 0.4 C2H6",
     1.0e4, 0, 24800, -0.35163},
    {"LIGOH => 0.9 LIG + H2O + 0.1 CH4 + 0.6 CH3OH + 0.3 GCH3OH + 0.05 CO2 + 0.65 CO + 0.6 GCO + 0.05 HCOOH + "
     "0.45 GCH2O + 0.40 GCOH2 + 0.25 GCH4 + 0.1 GC2H4 + 0.15 GC2H6 + 4.25 CHAR + 0.025 C24H28O4 + 0.1 C2H3CHO",
     1.5e8, 0, 30000, -0.20730},
    {"LIG => VANILLIN + 0.1 C6H5OCH3 + 0.5 C2H4 + 0.6 CO + 0.3 CH3CHO + 0.1 CHAR", 4.0, 1, 12000, 1.02146},
    {"LIG => 0.6 H2O + 0.3 CO + 0.1 CO2 + 0.2 CH4 + 0.4 CH2O + 0.2 GCO + 0.4 GCH4 + 0.5 GC2H4 + 0.4 GCH3OH + "
     "1.25 GCH2O + 0.65 GCOH2 + 6.1 CHAR + 0.1 GH2",
     8.3e2, 1, 8000, -0.70439},
    {"LIG => 0.6 H2O + 2.6 CO + 0.6 CH4 + 0.4 CH2O + 0.75 C2H4 + 0.4 CH3OH + 4.5 CHAR + 0.5 C2H6", 1.5e9, 0, 31500,
     0.37043},
    {"TGL => C2H3CHO + 2.5 MLINO + 0.5 U2ME12", 7.0e12, 0, 45700, 0.06461},
    {"TANN => 0.85 C6H5OH + 0.15 GC6H5OH + GCO + H2O + ITANN", 2.0e1, 0, 10000, 0.19905},
    {"ITANN => 5 CHAR + 2 CO + H2O + 0.55 GCH2O + 0.45 GCOH2", 1.0e3, 0, 25000, -0.04378},
    {"GCO2 => CO2", 1.0e6, 0, 24500, -1.87232},
    {"GCO => CO", 5.0e12, 0, 52500, -1.63223},
    {"GCH3OH => CH3OH", 2.0e12, 0, 50000, 0.06842},
    {"GCH2O => 0.8 CHAR + 0.8 H2O + 0.2 CO + 0.2 H2", 6.0e10, 0, 50000, -0.88508},
    {"GC2H6 => C2H6", 1.0e11, 0, 52000, -0.22626},
    {"GCH4 => CH4", 1.0e11, 0, 53000, -0.36545},
    {"GC2H4 => C2H4", 1.0e11, 0, 54000, -0.07881},
    {"GC6H5OH => C6H5OH", 1.5e12, 0, 55000, 0.12863},
    {"GCOH2 => 0.2 CHAR + 0.2 H2O + 0.8 CO + 0.8 H2", 1.0e9, 0, 59000, 6.80600},
    {"GH2 => H2", 1.8e8, 0, 70000, -5.02583},
};

const Atoms& atoms_of(const std::string& name) {
  for (const Atoms& a : k_atoms)
    if (name == a.name) return a;
  throw std::logic_error("no atoms of " + name);
}

double molar_mass(const Atoms& a) { return 12.011 * a.C + 1.008 * a.H + 15.999 * a.O; }

Composition composition_of(const Atoms& a) {
  const double m = molar_mass(a);
  return {12.011 * a.C / m, 1.008 * a.H / m, 15.999 * a.O / m, 0, 0};
}

/// Sum over the gases of a reaction: yield times heat capacity [J/K per kg of the reactant].
Property gas_capacity(const Matter& m, const Reaction& r) {
  std::vector<double> sum(5, 0.0);
  for (const Yield& y : r.gases) {
    const std::string& name = m.gases[y.species].name;
    for (const GasCapacity& c : k_gas_capacities)
      if (name == c.name)
        for (std::size_t k = 0; k < 5; ++k)
          sum[k] += y.mass * c.a[k] * k_gas_constant / (1e-3 * molar_mass(atoms_of(name)));
  }
  return Property::polynomial(sum, 0, 300, 1000);
}

struct Term {
  double moles;
  std::string name;
};

/// "0.4 H2O + CHAR" as terms.
std::vector<Term> terms_of(const std::string& side) {
  std::vector<Term> terms;
  for (std::size_t at = 0; at < side.size();) {
    const std::size_t plus = std::min(side.find(" + ", at), side.size());
    const std::string term = side.substr(at, plus - at);
    const std::size_t space = term.find(' ');
    const bool counted = space != std::string::npos;
    terms.push_back({counted ? std::strtod(term.c_str(), nullptr) : 1, counted ? term.substr(space + 1) : term});
    at = plus + 3;
  }
  return terms;
}

Reaction reaction_of(const Matter& m, const Equation& e) {
  const std::string text = e.text;
  const std::size_t arrow = text.find(" => ");
  const std::string from = text.substr(0, arrow);
  const double mass = molar_mass(atoms_of(from));
  Reaction r;
  r.name = from + " " + text.substr(arrow + 1, 20);
  r.reactant = m.solid(from);
  r.A = e.A;
  r.n = e.n;
  r.E = e.E * 4.184;
  r.heat = e.heat * 1e6;
  for (const Term& t : terms_of(text.substr(arrow + 4))) {
    const Atoms& a = atoms_of(t.name);
    const double yield = t.moles * molar_mass(a) / mass;
    if (a.kind == 'g')
      r.gases.push_back({m.gas(t.name), yield});
    else
      r.solids.push_back({m.solid(t.name), yield});
  }
  r.gas_capacity = gas_capacity(m, r);
  return r;
}

}  // namespace

void add_debiagi(Matter& m) {
  for (const Atoms& a : k_atoms) {
    if (a.kind == 'g')
      m.gases.push_back({a.name, composition_of(a)});
    else
      m.solids.push_back({a.name, a.kind == 'f' ? Kind::fuel : Kind::char_, 0, composition_of(a)});
  }
  for (const Equation& e : k_equations) m.reactions.push_back(reaction_of(m, e));
}

}  // namespace talus::conversion
