// List policy "neighbourhood".
#pragma once

#include <algorithm>

#include "scheduler/lists/policies/policy.hpp"
#include "scheduler/state/contacts.hpp"
#include "scheduler/state/rows.hpp"

namespace talus::policies {

/// Rows lie in Morton order: 64 of them fill a compact part of space.
inline double speed_of_neighbours(SpeedQuery& q, Row i, const double*, double) {
  constexpr Row k_neighbours = 64;
  if (i < q.block_end) return q.block;
  q.block_end = std::min<Row>(q.chunk.hi, (i / k_neighbours + 1) * k_neighbours);
  double largest = 0;
  for (Row k = i; k < q.block_end; ++k) {
    const double* u = q.rows.v.data() + static_cast<long>(q.rows.stride) * k;
    if (q.rows.is_alive(k)) largest = fmax2(largest, (u[0] * u[0] + u[1] * u[1]) + u[2] * u[2]);
  }
  return q.block = __builtin_sqrt(largest);
}

inline constexpr Policy k_neighbourhood{
    .word = ListPolicy::neighbourhood,
    .guarantee = "exact: as local with the largest speed among 64 neighbouring rows",
    .has_k = true,
    .floor = true,
    .terms = true,
    .speed = speed_of_neighbours,
};

}  // namespace talus::policies
