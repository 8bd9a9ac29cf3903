// Bodies compiled for avx2: pairs of superquadrics and motion; see kernels/bodies/*_lanes.hpp.
#include "kernels/bodies/motion_lanes.hpp"
#include "kernels/bodies/pair_batch_lanes.hpp"

namespace talus {
extern const PairSolver k_pair_solver_avx2;
constinit const PairSolver k_pair_solver_avx2 = kernels::solve_pairs<kernels::Lanes<simd::Avx2>>;
extern const PairGaps k_pair_gaps_avx2;
constinit const PairGaps k_pair_gaps_avx2 = kernels::find_gaps<kernels::Lanes<simd::Avx2>>;
extern const BodyMover k_body_mover_avx2;
constinit const BodyMover k_body_mover_avx2 = kernels::move_batch<kernels::Lanes<simd::Avx2>>;
}  // namespace talus
