// Kernels compiled for avx2; see kernels/isa/table.hpp.
#include "kernels/isa/table.hpp"

namespace talus {
extern const KernelTable k_table_avx2;
constinit const KernelTable k_table_avx2 = kernels::make_table<simd::Avx2>();
}  // namespace talus
