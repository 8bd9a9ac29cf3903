// List policy "displacement_history".
#pragma once

#include <algorithm>

#include "scheduler/lists/lists.hpp"
#include "scheduler/lists/policies/policy.hpp"
#include "scheduler/lists/skin_check.hpp"
#include "scheduler/state/clock.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus::policies {

/// What each row's skin should be: what it has travelled, over as many steps as K, but no less than 0.9 of a skin that
/// was not used up.
inline void note_displacements(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                               Lists& lists, Team& team) {
  constexpr double k_shrink = 0.9;
  if (lists.frame.noted) return;
  lists.frame.noted = true;
  const double stored_scale = rules.hooks.skin;
  const std::int64_t elapsed = std::max<std::int64_t>(1, clock.step - lists.frame.built);
  const double steps_ahead = lists.skin.k_dt / (rules.scene.dt * static_cast<double>(elapsed));
  parallel(team, static_cast<int>(contacts.chunks.size()), [&](int q) {
    const Chunk& c = *contacts.chunks[static_cast<std::size_t>(q)];
    for (Row i = c.lo; i < c.hi; ++i) {
      double& next = lists.next_skin[static_cast<std::size_t>(i)];
      const double *x = rows.p.data() + 4L * i, *ref = lists.x0.data() + 4L * i;
      next = -1;  // no past
      if (i >= lists.frame.rows || !(x[0] < k_far) || !(ref[3] < k_far)) continue;
      const double travel = __builtin_sqrt(distance2(rules, x, ref));
      next = fmax2(k_shrink * (__builtin_sqrt(ref[3]) / stored_scale), travel * steps_ahead);
    }
  });
}

inline double noted_length(SpeedQuery& q, Row i, const double*, double speed2) {
  const double length = q.lists.next_skin[static_cast<std::size_t>(i)];
  return length >= 0 ? length : q.lists.skin.k_dt * __builtin_sqrt(speed2);
}

inline constexpr Policy k_displacement_history{
    .word = ListPolicy::displacement_history,
    .guarantee = "exact: skin from what each particle travelled under the last lists, checked at every step",
    .floor = true,
    .past = true,
    .speed = noted_length,
    .note = note_displacements,
};

}  // namespace talus::policies
