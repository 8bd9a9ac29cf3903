// Heat and conversion of many grains at once: a lane per grain, shells along each (core/conversion/bed_step.hpp). Who
// calls it: the part `conversion`, tests, benchmarks. Invariant: each grain gets the bits that it gets alone, on every
// instruction set.
#pragma once

#include <string_view>

#include "core/conversion/bed_matter.hpp"

namespace talus {

using GrainSolver = void (*)(const conversion::BedMatter& matter, const conversion::GrainBatch& batch);

/// The solver of an instruction set: scalar, sse2, avx2, avx512, with " fast" behind it or not. nullptr for another name.
/// The caller has seen to it that the processor has it (available_isas()).
GrainSolver grain_solver(std::string_view isa) noexcept;

}  // namespace talus
