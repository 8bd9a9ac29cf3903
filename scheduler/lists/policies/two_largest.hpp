// List policy "two_largest": one row may use up both skins of a pair.
#pragma once

#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline constexpr Policy k_two_largest{
    .word = ListPolicy::two_largest,
    .guarantee = "exact: one skin for all, the sum of the two largest displacements stays below two skins",
    .skin = Policy::Skin::common,
    .check = Policy::Check::largest,
    .one_bound = true,
    .skins_used = 2,
    .used_up = [](const Lists&, double first, double second, double skin) { return first + second > 2 * skin; },
};

}  // namespace talus::policies
