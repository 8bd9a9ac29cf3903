// List policy "uniform".
#pragma once

#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline constexpr Policy k_uniform{
    .word = ListPolicy::uniform,
    .guarantee = "exact: one skin for all, each displacement is checked at every step",
    .skin = Policy::Skin::common,
};

}  // namespace talus::policies
