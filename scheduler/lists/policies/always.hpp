// List policy "always".
#pragma once

#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline constexpr Policy k_always{
    .word = ListPolicy::always,
    .guarantee = "exact: rebuilt at every step, no skin",
    .skin = Policy::Skin::none,
    .by_step = [](const Rules&, const Clock&) { return true; },
};

}  // namespace talus::policies
