// Bodies compiled for scalar: pairs of superquadrics and motion; see kernels/bodies/*_lanes.hpp.
#include "kernels/bodies/motion_lanes.hpp"
#include "kernels/bodies/pair_batch_lanes.hpp"

namespace talus {
extern const PairSolver k_pair_solver_scalar;
constinit const PairSolver k_pair_solver_scalar = kernels::solve_pairs<kernels::Lanes<simd::Scalar>>;
extern const PairGaps k_pair_gaps_scalar;
constinit const PairGaps k_pair_gaps_scalar = kernels::find_gaps<kernels::Lanes<simd::Scalar>>;
extern const BodyMover k_body_mover_scalar;
constinit const BodyMover k_body_mover_scalar = kernels::move_batch<kernels::Lanes<simd::Scalar>>;
}  // namespace talus
