// Bodies compiled for avx512: pairs of superquadrics and motion; see kernels/bodies/*_lanes.hpp.
#include "kernels/bodies/motion_lanes.hpp"
#include "kernels/bodies/pair_batch_lanes.hpp"

namespace talus {
extern const PairSolver k_pair_solver_avx512;
constinit const PairSolver k_pair_solver_avx512 = kernels::solve_pairs<kernels::Lanes<simd::Avx512>>;
extern const PairGaps k_pair_gaps_avx512;
constinit const PairGaps k_pair_gaps_avx512 = kernels::find_gaps<kernels::Lanes<simd::Avx512>>;
extern const BodyMover k_body_mover_avx512;
constinit const BodyMover k_body_mover_avx512 = kernels::move_batch<kernels::Lanes<simd::Avx512>>;
}  // namespace talus
