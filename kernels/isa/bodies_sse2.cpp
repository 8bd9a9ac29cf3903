// Pairs of superquadrics compiled for sse2; see kernels/bodies/pair_batch_lanes.hpp.
#include "kernels/bodies/pair_batch_lanes.hpp"

namespace talus {
extern const PairSolver k_pair_solver_sse2;
constinit const PairSolver k_pair_solver_sse2 = kernels::solve_pairs<kernels::Lanes<simd::Sse2>>;
extern const PairGaps k_pair_gaps_sse2;
constinit const PairGaps k_pair_gaps_sse2 = kernels::find_gaps<kernels::Lanes<simd::Sse2>>;
}  // namespace talus
