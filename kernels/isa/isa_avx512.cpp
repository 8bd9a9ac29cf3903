// Kernels compiled for avx512; see kernels/isa/table.hpp.
#include "kernels/isa/table.hpp"

namespace talus {
extern const KernelTable k_table_avx512;
constinit const KernelTable k_table_avx512 = kernels::make_table<simd::Avx512>();
}  // namespace talus
