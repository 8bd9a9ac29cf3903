// Pairs of superquadrics compiled for avx2; see kernels/bodies/pair_batch_lanes.hpp.
#include "kernels/bodies/pair_batch_lanes.hpp"

namespace talus {
extern const PairSolver k_pair_solver_avx2;
constinit const PairSolver k_pair_solver_avx2 = kernels::solve_pairs<kernels::Lanes<simd::Avx2>>;
extern const PairGaps k_pair_gaps_avx2;
constinit const PairGaps k_pair_gaps_avx2 = kernels::find_gaps<kernels::Lanes<simd::Avx2>>;
}  // namespace talus
