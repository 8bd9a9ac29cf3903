// Choice of the solver and of the gaps by the name of the instruction set. See pair_batch.hpp.
#include "kernels/bodies/pair_batch.hpp"

namespace talus {

extern const PairSolver k_pair_solver_scalar, k_pair_solver_sse2, k_pair_solver_avx2, k_pair_solver_avx512;
extern const PairGaps k_pair_gaps_scalar, k_pair_gaps_sse2, k_pair_gaps_avx2, k_pair_gaps_avx512;

PairSolver pair_solver(std::string_view isa) noexcept {
  if (isa == "scalar") return k_pair_solver_scalar;
  if (isa == "sse2") return k_pair_solver_sse2;
  if (isa == "avx2") return k_pair_solver_avx2;
  if (isa == "avx512") return k_pair_solver_avx512;
  return nullptr;
}

PairGaps pair_gaps(std::string_view isa) noexcept {
  if (isa == "scalar") return k_pair_gaps_scalar;
  if (isa == "sse2") return k_pair_gaps_sse2;
  if (isa == "avx2") return k_pair_gaps_avx2;
  if (isa == "avx512") return k_pair_gaps_avx512;
  return nullptr;
}

}  // namespace talus
