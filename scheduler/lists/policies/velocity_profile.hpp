// List policy "velocity_profile"; the fit is in scheduler/lists/velocity_profile.cpp.
#pragma once

#include "scheduler/lists/policies/mean_subtracted.hpp"
#include "scheduler/lists/velocity_profile.hpp"

namespace talus::policies {

inline void drift_with_profile(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists,
                               Team& team) {
  lists.frame.life = lists.skin.k_dt;
  const double fastest = fit_velocity_profile(rules, rows, contacts, lists, team, lists.frame.life);
  lists.frame.rounding = 6e-8 * fastest * lists.frame.life;
  if (rules.has.walls && fastest > 0) lists.frame.life = fmin2(lists.frame.life, lists.skin.drift_travel / fastest);
}

inline constexpr Policy k_velocity_profile{
    .word = ListPolicy::velocity_profile,
    .guarantee =
        "exact: as local, speeds and displacements relative to a velocity profile across one axis, pairs listed "
        "in a longer reach",
    .has_k = true,
    .floor = true,
    .terms = true,
    .drifts = true,
    .row_drift = true,
    .ages = true,
    .stretch = k_most_stretch,
    .speed = speed_beside_drift,
    .prepare = drift_with_profile,
};

}  // namespace talus::policies
