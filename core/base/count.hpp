// From a quotient of lengths or times to a count: the one place where such a double becomes an integer. Who calls it:
// whoever divides a time by the step, a length by a cell, a mass by a rate. Invariant: every double has a result, also
// infinity and what is not a number; a cast of its own would be undefined beyond the integer's range.
#pragma once

#include <cstdint>

#include "core/base/det_math.hpp"

namespace talus {

/// Counts above this one cannot be told from their neighbours as doubles.
constexpr std::int64_t k_most_count = std::int64_t{1} << 53;

/// Nearest whole number to q (halves away from 0), kept within [low, high]; `low` where q is not a number.
inline std::int64_t count_nearest(double q, std::int64_t low = 0, std::int64_t high = k_most_count) noexcept {
  if (!(q > static_cast<double>(low))) return low;
  return q >= static_cast<double>(high) ? high : det::nearest(q);
}

/// Largest whole number not above q, kept within [low, high]; `low` where q is not a number.
inline std::int64_t count_floor(double q, std::int64_t low = 0, std::int64_t high = k_most_count) noexcept {
  if (!(q > static_cast<double>(low))) return low;
  return q >= static_cast<double>(high) ? high : det::floor_int(q);
}

/// Smallest whole number not below q, kept within [low, high]; `low` where q is not a number.
inline std::int64_t count_ceil(double q, std::int64_t low = 0, std::int64_t high = k_most_count) noexcept {
  const std::int64_t floor = count_floor(q, low, high);
  return floor < high && static_cast<double>(floor) < q ? floor + 1 : floor;
}

/// Cell of a grid that holds the coordinate `q` [cells]: within [0, cells). Without a call, for every particle.
inline int cell_index(double q, int cells) noexcept {
  return !(q > 0) ? 0 : (q >= cells - 1 ? cells - 1 : static_cast<int>(q));
}

}  // namespace talus
