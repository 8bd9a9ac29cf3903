// List policy "local".
#pragma once

#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline constexpr Policy k_local{
    .word = ListPolicy::local,
    .guarantee = "exact: as paper, with a smallest skin and an acceleration term",
    .has_k = true,
    .floor = true,
    .terms = true,
};

}  // namespace talus::policies
