// Checks and order of the data of matter.hpp.
#include "core/conversion/matter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/suggest.hpp"

namespace talus::conversion {
namespace {

template <class List>
std::size_t index_of(const List& list, const std::string& name, const char* what) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].name == name) return i;
    names.push_back(list[i].name);
  }
  std::string all;
  for (const std::string& n : names) all += (all.empty() ? "" : ", ") + n;
  throw Error(ErrorCode::scene, fmt::format("no {} '{}'{}; there is {}", what, name, did_you_mean(name, names),
                                            all.empty() ? "none" : all));
}

constexpr Composition k_default[k_kinds] = {{0, 0, 0, 0, 1}, {0.5, 0.06, 0.44, 0, 0}, {1, 0, 0, 0, 0}, {0, 0, 0, 1, 0}};

/// Solids in an order in which each comes after those that it is made from.
std::vector<std::size_t> forward_order(const Matter& m) {
  std::vector<std::size_t> order, makers(m.solids.size());
  for (const Reaction& r : m.reactions)
    if (!r.of_gas)
      for (const Yield& y : r.solids) ++makers[y.species];
  std::vector<char> placed(m.solids.size());
  while (order.size() < m.solids.size()) {
    const std::size_t before = order.size();
    for (std::size_t s = 0; s < m.solids.size(); ++s) {
      if (placed[s] || makers[s] > 0) continue;
      placed[s] = 1;
      order.push_back(s);
      for (const Reaction& r : m.reactions)
        if (!r.of_gas && r.reactant == s)
          for (const Yield& y : r.solids) --makers[y.species];
    }
    if (order.size() > before) continue;
    for (std::size_t s = 0; s < m.solids.size(); ++s)
      if (!placed[s])
        throw Error(ErrorCode::scene, fmt::format("the reactions lead from '{}' back to it", m.solids[s].name),
                    "reaction", "reactions must lead forward only");
  }
  return order;
}

void reorder(Matter& m, const std::vector<std::size_t>& order) {
  std::vector<std::size_t> place(order.size());
  std::vector<Solid> solids;
  for (std::size_t k = 0; k < order.size(); ++k) {
    place[order[k]] = k;
    solids.push_back(m.solids[order[k]]);
  }
  m.solids = std::move(solids);
  for (Reaction& r : m.reactions) {
    if (!r.of_gas) r.reactant = place[r.reactant];
    for (Yield& y : r.solids) y.species = place[y.species];
  }
}

void check_balance(const Matter& m, const Reaction& r) {
  double mass = -1;
  for (const Yield& y : r.solids) mass += y.mass;
  for (const Yield& y : r.gases) mass += y.mass;
  if (!(std::fabs(mass) <= 1e-6))
    throw Error(ErrorCode::scene,
                fmt::format("the products of '{}' are {:.6g} kg per kg of '{}'", r.name, mass + 1,
                            r.of_gas ? m.gases[r.reactant].name : m.solids[r.reactant].name),
                "reaction", "yields must sum to 1");
  std::array<double, k_elements> sum{};
  const auto add = [&](const std::optional<Composition>& c, double factor) {
    for (std::size_t e = 0; c && e < k_elements; ++e) sum[e] += factor * (*c)[e];
    return c.has_value();
  };
  bool known = add(r.of_gas ? m.gases[r.reactant].composition : m.solids[r.reactant].composition, -1);
  for (const Yield& y : r.solids) known = add(m.solids[y.species].composition, y.mass) && known;
  for (const Yield& y : r.gases) known = add(m.gases[y.species].composition, y.mass) && known;
  for (std::size_t e = 0; known && e < k_elements; ++e)
    if (std::fabs(sum[e]) > 1e-3)
      throw Error(ErrorCode::scene,
                  fmt::format("'{}' makes {:.4g} kg of {} per kg of its reactant", r.name, sum[e], k_element_names[e]),
                  "reaction", "compositions and yields must agree");
}

std::size_t gas_or_new(Matter& m, const char* name, const Composition& composition) {
  for (std::size_t i = 0; i < m.gases.size(); ++i)
    if (m.gases[i].name == name) return i;
  m.gases.push_back({name, composition});
  return m.gases.size() - 1;
}

bool chars_are_alike(const Matter& m) {
  const Solid* first = nullptr;
  for (const Solid& s : m.solids)
    if (s.kind == Kind::char_) {
      if (first == nullptr) first = &s;
      if (*s.composition != *first->composition) return false;
    }
  return true;
}

}  // namespace

std::size_t Matter::solid(const std::string& solid_name) const { return index_of(solids, solid_name, "solid"); }
std::size_t Matter::gas(const std::string& gas_name) const { return index_of(gases, gas_name, "gas"); }

void check_matter(Matter& m) {
  double shares = 0;
  std::size_t moistures = 0;
  for (const Solid& s : m.solids) {
    shares += s.initial;
    moistures += s.kind == Kind::moisture;
  }
  if (!(std::fabs(shares - 1) <= 1e-6))
    throw Error(ErrorCode::scene, fmt::format("the initial shares of the solids sum to {:.6g}", shares), "material",
                "they must sum to 1");
  if (moistures > 1) throw Error(ErrorCode::scene, "two solids are moisture", "material", "one is allowed");
  for (Reaction& r : m.reactions) check_balance(m, r);
  for (Solid& s : m.solids)
    if (!s.composition) s.composition = k_default[static_cast<std::size_t>(s.kind)];
  reorder(m, forward_order(m));
  if (moistures > 0 && m.drying.kind != Drying::none && m.drying.kind != Drying::arrhenius)
    m.vapour = gas_or_new(m, "vapour", {0, 0, 0, 0, 1});
  for (const CharReaction& r : m.char_reactions) {
    m.carbon_monoxide = gas_or_new(m, "CO", {0.42880, 0, 0.57120, 0, 0});
    if (r.oxidant == CharReaction::Oxidant::oxygen)
      m.carbon_dioxide = gas_or_new(m, "CO2", {0.27291, 0, 0.72709, 0, 0});
    if (r.oxidant == CharReaction::Oxidant::steam) m.hydrogen = gas_or_new(m, "H2", {0, 1, 0, 0, 0});
  }
  if (chars_are_alike(m)) settle_char(m);
  if (m.char_steam > 0) m.vapour = gas_or_new(m, "vapour", {0, 0, 0, 0, 1});
  if (m.char_hydrogen > 0) m.hydrogen = gas_or_new(m, "H2", {0, 1, 0, 0, 0});
}

}  // namespace talus::conversion
