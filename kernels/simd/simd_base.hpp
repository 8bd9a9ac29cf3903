// What every SIMD shim needs: the intrinsics, xsimd, forced inlining. Included by kernels/simd_*.hpp only.
#pragma once

#include <immintrin.h>

#include <cstdint>
#include <xsimd/xsimd.hpp>

#define TALUS_INLINE inline __attribute__((always_inline))
