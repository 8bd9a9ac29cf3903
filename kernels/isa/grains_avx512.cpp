// Heat and conversion of grains compiled for avx512; see kernels/conversion/grain_lanes.hpp.
#include "kernels/conversion/grain_lanes.hpp"

namespace talus {
extern const GrainSolver k_grain_solver_avx512;
constinit const GrainSolver k_grain_solver_avx512 = kernels::advance_grains<simd::Avx512>;
}  // namespace talus
