// Kernels compiled for scalar; see kernels/isa/table.hpp.
#include "kernels/isa/table.hpp"

namespace talus {
extern const KernelTable k_table_scalar;
constinit const KernelTable k_table_scalar = kernels::make_table<simd::Scalar>();
}  // namespace talus
