// Many pairs of superquadrics at once: columns in, columns out, a lane per pair. Who calls it: the narrow phase of
// bodies, tests, benchmarks. Invariant: each pair gets the bits that shapes::iterate<Plain> gives it alone.
#pragma once

#include <cstdint>
#include <string_view>

#include "core/base/types.hpp"

namespace talus {

/// What a pair brings and takes, one double per pair and field: see shapes::PairForm and shapes::PairState.
struct PairColumns {
  /// axes2 of i (3), p1, p2 of i; the same of j; turn (9, by rows); d (3); size; range; n (3); eta; care
  static constexpr int k_in = 29;
  /// n (3), delta, xi (3), residual, step, steps, done (1 or 0)
  static constexpr int k_out = 11;
  std::int64_t pairs = 0;
  std::int64_t stride = 0;  ///< doubles between two columns; at least `pairs` rounded up to 8
  const double* in = nullptr;
  double* out = nullptr;
};

/// What pairs bring where only the overlap along a given direction is asked for.
struct GapColumns {
  /// axes2 of i (3), p1, p2 of i, the direction in the frame of i (3); the same of j; direction . d
  static constexpr int k_in = 17;
  std::int64_t pairs = 0;
  std::int64_t stride = 0;  ///< as in PairColumns
  const double* in = nullptr;
  double* out = nullptr;  ///< h_i + h_j - direction . d [m]; negative: apart
};

/// Runs at most `most` evaluations per pair. Lanes beyond `pairs` in the last batch repeat what lies there: the padding
/// has to be readable and writable.
using PairSolver = void (*)(const PairColumns& columns, int most);

/// The solver of an instruction set: scalar, sse2, avx2, avx512. nullptr for another name. The caller has seen to it
/// that the processor has it (available_isas()).
PairSolver pair_solver(std::string_view isa) noexcept;

/// Overlaps along given directions, of the bodies rounded by k_eta: with the bits of `delta` of an evaluation there.
using PairGaps = void (*)(const GapColumns& columns);
PairGaps pair_gaps(std::string_view isa) noexcept;

}  // namespace talus
