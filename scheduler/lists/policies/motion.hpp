// Motion of all rows together, for policies that measure speeds against it.
#pragma once

#include <vector>

#include "core/base/types.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/state/rows.hpp"
#include "scheduler/state/rules.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus::policies {

struct alignas(64) Motion {
  Vec3 sum;            ///< of the velocities [m/s]
  double fastest = 0;  ///< squared speed [m2/s2]
};

inline Motion motion_of(const Rules& rules, const Rows& rows, const Contacts& contacts, Team& team) {
  std::vector<Motion> parts(contacts.chunks.size());
  parallel(team, static_cast<int>(contacts.chunks.size()), [&](int q) {
    const Chunk& c = *contacts.chunks[static_cast<std::size_t>(q)];
    Motion& part = parts[static_cast<std::size_t>(q)];
    for (Row i = c.lo; i < c.hi; ++i) {
      if (!rows.is_alive(i)) continue;
      const double* u = rows.v.data() + static_cast<long>(rules.stride) * i;
      const Vec3 v{u[0], u[1], u[2]};
      part.sum = part.sum + v;
      part.fastest = fmax2(part.fastest, norm2(v));
    }
  });
  Motion all;
  for (const Motion& p : parts) {
    all.sum = all.sum + p.sum;
    all.fastest = fmax2(all.fastest, p.fastest);
  }
  return all;
}

}  // namespace talus::policies
