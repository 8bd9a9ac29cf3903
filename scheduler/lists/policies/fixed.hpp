// List policy "fixed", the one that may miss contacts.
#pragma once

#include "scheduler/lists/policies/policy.hpp"
#include "scheduler/state/clock.hpp"
#include "scheduler/state/rules.hpp"

namespace talus::policies {

inline constexpr Policy k_fixed{
    .word = ListPolicy::fixed,
    .guarantee = "NOT exact: rebuilt every list.interval steps, nothing is checked in between",
    .skin = Policy::Skin::common,
    .check = Policy::Check::none,
    .by_step = [](const Rules& rules, const Clock& clock) { return clock.step % rules.scene.list.interval == 0; },
};

}  // namespace talus::policies
