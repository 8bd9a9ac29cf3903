// Heat and conversion of grains compiled for scalar; see kernels/conversion/grain_lanes.hpp.
#include "kernels/conversion/grain_lanes.hpp"

namespace talus {
extern const GrainSolver k_grain_solver_scalar;
constinit const GrainSolver k_grain_solver_scalar = kernels::advance_grains<simd::Scalar>;
}  // namespace talus
