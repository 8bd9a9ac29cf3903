// Kernels compiled for avx2 with contraction, for precision = "fast"; see kernels/simd/simd_fast.hpp.
#include "kernels/isa/table.hpp"
#include "kernels/simd/simd_fast.hpp"

namespace talus {
extern const KernelTable k_table_avx2_fast;
constinit const KernelTable k_table_avx2_fast = kernels::make_table<simd::Avx2Fast>();
}  // namespace talus
