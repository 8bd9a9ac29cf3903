// List policy "paper".
#pragma once

#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline constexpr Policy k_paper{
    .word = ListPolicy::paper,
    .guarantee = "exact: skin K |v| dt of each particle, its displacement is checked at every step",
    .has_k = true,
};

}  // namespace talus::policies
