// SIMD shim: what the kernels need beyond xsimd 8.1 (row loads with transposition, compress, expand, bit masks), one
// struct per architecture. Included only by kernel headers, which only isa_*.cpp instantiate, so that no function
// compiled for a newer instruction set can be linked into a path for an older one (everything is a template on or a
// static member of the architecture struct). All lanes compute the same IEEE operations on every architecture.
#pragma once

#include "kernels/simd/simd_avx2.hpp"
#include "kernels/simd/simd_avx512.hpp"
#include "kernels/simd/simd_scalar.hpp"
#include "kernels/simd/simd_sse2.hpp"
