// Kernels compiled for avx512 with contraction, for precision = "fast"; see kernels/simd/simd_fast.hpp.
#include "kernels/isa/table.hpp"
#include "kernels/simd/simd_fast.hpp"

namespace talus {
extern const KernelTable k_table_avx512_fast;
constinit const KernelTable k_table_avx512_fast = kernels::make_table<simd::Avx512Fast>();
}  // namespace talus
