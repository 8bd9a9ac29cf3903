// Kernels compiled for sse2; see kernels/isa/table.hpp.
#include "kernels/isa/table.hpp"

namespace talus {
extern const KernelTable k_table_sse2;
constinit const KernelTable k_table_sse2 = kernels::make_table<simd::Sse2>();
}  // namespace talus
