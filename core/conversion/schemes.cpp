// The pyrolysis presets: published schemes of first-order reactions of wood. A in 1/s, E in J/mol. Char and gas that a
// source leaves unnamed are "char" and "gas"; heats are 0 unless a grain gives them.
#include <fmt/format.h>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"
#include "core/conversion/matter.hpp"

namespace talus::conversion {
namespace {

struct Primary {
  double gas_A, gas_E, tar_A, tar_E, char_A, char_E;
};
struct Secondary {
  double gas_A, gas_E, char_A, char_E;  ///< tar -> gas, tar -> char; A = 0: none
};
struct Scheme {
  const char* name;
  Primary primary;
  Secondary secondary;
};

constexpr Scheme k_schemes[] = {
    // Thurner, Mann, Ind. Eng. Chem. Process Des. Dev. 20 (1981) 482
    {"thurner_mann", {1.44e4, 88.6e3, 4.13e6, 112.7e3, 7.38e5, 106.5e3}, {}},
    // Chan, Kelbon, Krieger, Fuel 64 (1985) 1505
    {"chan", {1.3e8, 140e3, 2.0e8, 133e3, 1.08e7, 121e3}, {1.48e6, 144e3, 0, 0}},
    // Di Blasi, Combust. Sci. Technol. 90 (1993) 315
    {"di_blasi", {1.4345e4, 88.6e3, 4.125e6, 112.7e3, 7.3766e5, 106.5e3}, {4.28e6, 108e3, 1.0e6, 108e3}},
    // Di Blasi, Branca, Ind. Eng. Chem. Res. 40 (2001) 5547 (beech)
    {"di_blasi_branca", {4.38e9, 152.7e3, 1.08e10, 148e3, 3.27e6, 111.7e3}, {}},
    // Wagenaar, Prins, van Swaaij, Fuel Process. Technol. 36 (1994) 291; tar: Janse, Chem. Eng. Process. 39 (2000) 239
    {"wagenaar", {1.11e11, 177e3, 9.28e9, 149e3, 3.05e7, 125e3}, {8.6e4, 87.8e3, 7.7e4, 87.8e3}},
    // Font et al., Ind. Eng. Chem. Res. 29 (1990) 1846
    {"font", {6.8e8, 156e3, 8.23e8, 148e3, 2.91e2, 61e3}, {}},
};

void add(Matter& m, Reaction r) { m.reactions.push_back(std::move(r)); }

void add_three(Matter& m, const Scheme& s) {
  const std::size_t wood = m.solid("wood"), ch = m.solid("char");
  const std::size_t gas = m.gas("gas"), tar = m.gas("tar");
  const Primary& p = s.primary;
  add(m, {"wood to gas", wood, false, p.gas_A, 0, p.gas_E, 0, {}, {{gas, 1}}});
  add(m, {"wood to tar", wood, false, p.tar_A, 0, p.tar_E, 0, {}, {{tar, 1}}});
  add(m, {"wood to char", wood, false, p.char_A, 0, p.char_E, 0, {{ch, 1}}, {}});
  if (s.secondary.gas_A > 0)
    add(m, {"tar to gas", tar, true, s.secondary.gas_A, 0, s.secondary.gas_E, 0, {}, {{gas, 1}}});
  if (s.secondary.char_A > 0)
    add(m, {"tar to char", tar, true, s.secondary.char_A, 0, s.secondary.char_E, 0, {{ch, 1}}, {}});
}

/// Liden, Berruti, Scott, Chem. Eng. Commun. 65 (1988) 207: one decomposition; 0.703 of it to tar, the rest gas and
/// char.
void add_liden(Matter& m) {
  const std::size_t wood = m.solid("wood"), ch = m.solid("char"), gas = m.gas("gas"), tar = m.gas("tar");
  add(m, {"wood to tar, gas and char", wood, false, 1e13, 0, 183.3e3, 0, {{ch, 0.14}}, {{tar, 0.703}, {gas, 0.157}}});
  add(m, {"tar to gas", tar, true, 4.28e6, 0, 107.5e3, 0, {}, {{gas, 1}}});
}

/// Sadhukhan, Gupta, Saha, Bioresour. Technol. 100 (2009) 3134: char takes 0.38 of its mass from the volatiles.
void add_sadhukhan(Matter& m) {
  const std::size_t wood = m.solid("wood"), first = m.solid("char"), gas = m.gas("gas");
  m.solids.push_back({"char2", Kind::char_, 0, m.solids[first].composition});
  const std::size_t second = m.solid("char2");
  add(m, {"wood to volatiles", wood, false, 168.4, 0, 51.965e3, 0, {}, {{gas, 1}}});
  add(m, {"wood to char", wood, false, 13.2, 0, 45.96e3, 0, {{first, 1}}, {}});
  add(m, {"char and volatiles to char2", first, false, 5.7e6, 0, 92.4e3, 0, {{second, 1.38}}, {{gas, -0.38}}});
}

template <class List, class Entry>
void ensure(List& list, Entry entry) {
  for (const auto& x : list)
    if (x.name == entry.name) return;
  list.push_back(std::move(entry));
}

}  // namespace

std::vector<std::string> scheme_names() {
  std::vector<std::string> names;
  for (const Scheme& s : k_schemes) names.emplace_back(s.name);
  names.emplace_back("liden");
  names.emplace_back("sadhukhan");
  names.emplace_back("debiagi");
  return names;
}

void add_scheme(Matter& m, const std::string& name) {
  if (name == "debiagi") return add_debiagi(m);
  ensure(m.solids, Solid{"wood", Kind::fuel, 0, {}});
  ensure(m.solids, Solid{"char", Kind::char_, 0, {}});
  ensure(m.gases, Gas{"gas", {}});
  if (name != "sadhukhan") ensure(m.gases, Gas{"tar", {}});
  if (name == "liden") return add_liden(m);
  if (name == "sadhukhan") return add_sadhukhan(m);
  for (const Scheme& s : k_schemes)
    if (s.name == name) return add_three(m, s);
  const std::vector<std::string> names = scheme_names();
  std::string all;
  for (const std::string& n : names) all += (all.empty() ? "" : ", ") + n;
  throw Error(ErrorCode::scene, fmt::format("no scheme '{}'{}; there is {}", name, did_you_mean(name, names), all));
}

}  // namespace talus::conversion
