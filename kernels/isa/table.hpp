// Builds the kernel table of one architecture struct. Included by isa_*.cpp only.
#pragma once

#include "kernels/models/cohesion.hpp"
#include "kernels/models/hertz_mindlin.hpp"
#include "kernels/models/linear.hpp"
#include "kernels/models/moments.hpp"
#include "kernels/passes/integrate.hpp"
#include "kernels/passes/narrow.hpp"
#include "kernels/passes/narrow_adhesive.hpp"
#include "kernels/passes/search.hpp"

namespace talus::kernels {

template <class S, class Law, bool Friction, bool Multi, bool Energy>
void law(Block& b, const LawArgs& a) {
  force<S, Friction, Multi, Energy>(Law{}, b, a);
}

/// Eight variants per law in the order of law_index(): friction + 2 multi + 4 energy.
template <class S, class Law>
constexpr void fill_law(void (**out)(Block&, const LawArgs&)) {
  out[0] = law<S, Law, false, false, false>;
  out[1] = law<S, Law, true, false, false>;
  out[2] = law<S, Law, false, true, false>;
  out[3] = law<S, Law, true, true, false>;
  out[4] = law<S, Law, false, false, true>;
  out[5] = law<S, Law, true, false, true>;
  out[6] = law<S, Law, false, true, true>;
  out[7] = law<S, Law, true, true, true>;
}

/// Forces in the order of LawForce.
template <class S, class... Laws>
constexpr void fill_laws(KernelTable& t) {
  static_assert(8 * sizeof...(Laws) == sizeof t.law / sizeof t.law[0]);
  int force = 0;
  const auto fill = [&]<class Law>(Law) {
    static_assert(Law::history + 1 <= k_max_history);
    if (enum_word(static_cast<LawForce>(force)) != Law::name) throw "LawForce has another order";
    fill_law<S, Law>(t.law + 8 * force++);
  };
  (fill(Laws{}), ...);
}

/// constexpr: the tables are constant-initialised, no instruction of a foreign set runs at program start.
template <class S>
constexpr KernelTable make_table() {
  KernelTable t{};
  t.name = S::name;
  t.width = S::W;
  t.narrow = narrow<S>;
  t.gather[0] = gather<S, false>;
  t.gather[1] = gather<S, true>;
  t.geometry = geometry<S>;
  t.scatter[0] = scatter<S, false>;
  t.scatter[1] = scatter<S, true>;
  t.integrate[0] = integrate<S, false>;
  t.integrate[1] = integrate<S, true>;
  t.search = search_rows<S>;
  fill_laws<S, Linear, HertzMindlin, Jkr, PartialSlip>(t);
  t.trial = linear_trial<S>;
  t.scatter_limited = scatter_limited<S>;
  t.late = linear_late<S>;
  t.narrow_adhesive = narrow_adhesive<S>;
  t.carry = carry<S>;
  t.spin = spin<S>;
  t.moments = moments<S>;
  t.cohesion = cohesion<S>;
  return t;
}

}  // namespace talus::kernels
