// Choice of the solver by the name of the instruction set. See grain_batch.hpp.
#include "kernels/conversion/grain_batch.hpp"

namespace talus {

extern const GrainSolver k_grain_solver_scalar, k_grain_solver_sse2, k_grain_solver_avx2, k_grain_solver_avx512;

GrainSolver grain_solver(std::string_view isa) noexcept {
  isa = isa.substr(0, isa.find(' '));  // "avx512 fast": grains are computed exactly in both precisions
  if (isa == "scalar") return k_grain_solver_scalar;
  if (isa == "sse2") return k_grain_solver_sse2;
  if (isa == "avx2") return k_grain_solver_avx2;
  if (isa == "avx512") return k_grain_solver_avx512;
  return nullptr;
}

}  // namespace talus
