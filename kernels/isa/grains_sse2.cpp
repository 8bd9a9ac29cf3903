// Heat and conversion of grains compiled for sse2; see kernels/conversion/grain_lanes.hpp.
#include "kernels/conversion/grain_lanes.hpp"

namespace talus {
extern const GrainSolver k_grain_solver_sse2;
constinit const GrainSolver k_grain_solver_sse2 = kernels::advance_grains<simd::Sse2>;
}  // namespace talus
