// Heat and conversion of grains compiled for avx2; see kernels/conversion/grain_lanes.hpp.
#include "kernels/conversion/grain_lanes.hpp"

namespace talus {
extern const GrainSolver k_grain_solver_avx2;
constinit const GrainSolver k_grain_solver_avx2 = kernels::advance_grains<simd::Avx2>;
}  // namespace talus
