// List policy "outer_inner"; the cutting is in scheduler/lists/inner_list.cpp.
#pragma once

#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline constexpr Policy k_outer_inner{
    .word = ListPolicy::outer_inner,
    .guarantee = "exact: as local, lists cut out of longer ones for as long as no displacement exceeds their skins",
    .has_k = true,
    .floor = true,
    .terms = true,
    .cuts = true,
};

}  // namespace talus::policies
