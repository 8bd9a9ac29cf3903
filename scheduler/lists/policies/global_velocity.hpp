// List policy "global_velocity".
#pragma once

#include "scheduler/lists/lists.hpp"
#include "scheduler/lists/policies/motion.hpp"
#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline constexpr Policy k_global_velocity{
    .word = ListPolicy::global_velocity,
    .guarantee = "exact: skin K max|v| dt for all, each displacement is checked at every step",
    .has_k = true,
    .speed = [](SpeedQuery& q, Row, const double*, double) { return q.lists.frame.common_speed; },
    .prepare =
        [](const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists, Team& team) {
          lists.frame.common_speed = __builtin_sqrt(motion_of(rules, rows, contacts, team).fastest);
        },
};

}  // namespace talus::policies
