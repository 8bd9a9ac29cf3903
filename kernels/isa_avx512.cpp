// Kernels compiled for avx512; see kernels/table.hpp.
#include "kernels/table.hpp"

namespace talus {
extern const KernelTable k_table_avx512;
constinit const KernelTable k_table_avx512 = kernels::make_table<simd::Avx512>();
}  // namespace talus
