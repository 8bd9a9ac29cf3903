// List policy "accumulated".
#pragma once

#include "scheduler/lists/lists.hpp"
#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline constexpr Policy k_accumulated{
    .word = ListPolicy::accumulated,
    .guarantee = "exact: one skin for all, the largest travel of each step, summed, stays below it",
    .skin = Policy::Skin::common,
    .check = Policy::Check::largest_of_step,
    .one_bound = true,
    .used_up = [](const Lists& lists, double, double, double skin) { return lists.frame.travelled > skin; },
};

}  // namespace talus::policies
