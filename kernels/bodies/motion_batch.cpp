// Choice of the mover by the name of the instruction set. See motion_batch.hpp.
#include "kernels/bodies/motion_batch.hpp"

namespace talus {

extern const BodyMover k_body_mover_scalar, k_body_mover_sse2, k_body_mover_avx2, k_body_mover_avx512;

BodyMover body_mover(std::string_view isa) noexcept {
  if (isa == "scalar") return k_body_mover_scalar;
  if (isa == "sse2") return k_body_mover_sse2;
  if (isa == "avx2") return k_body_mover_avx2;
  if (isa == "avx512") return k_body_mover_avx512;
  return nullptr;
}

}  // namespace talus
