// List policy "mean_subtracted".
#pragma once

#include "scheduler/lists/lists.hpp"
#include "scheduler/lists/policies/motion.hpp"
#include "scheduler/lists/policies/policy.hpp"

namespace talus::policies {

inline double speed_beside_drift(SpeedQuery& q, Row i, const double* v, double) {
  return norm(Vec3{v[0], v[1], v[2]} - q.lists.drift_of(i));
}

inline void drift_with_mean(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists, Team& team) {
  const Motion all = motion_of(rules, rows, contacts, team);
  const Vec3 u = (1.0 / fmax2(1, static_cast<double>(rows.alive))) * all.sum;
  for (int k = 0; k < 3; ++k) lists.frame.drift[k] = static_cast<float>(u[k]);
  if (rules.has.walls && norm(u) > 0) lists.frame.life = lists.skin.drift_travel / norm(u);
}

inline constexpr Policy k_mean_subtracted{
    .word = ListPolicy::mean_subtracted,
    .guarantee = "exact: as local, speeds and displacements relative to the mean velocity",
    .has_k = true,
    .floor = true,
    .terms = true,
    .drifts = true,
    .speed = speed_beside_drift,
    .prepare = drift_with_mean,
};

}  // namespace talus::policies
