// Choice of instruction set at run time and the index of contact-law variants. Who calls it: scheduler/, tests, perf.
#pragma once

#include <string>
#include <vector>

#include "core/rules/laws/law.hpp"
#include "core/scene/scene.hpp"
#include "kernels/views.hpp"

namespace talus {

/// Variant index into KernelTable::law.
inline int law_index(const LawInfo& law, bool friction, bool multi, bool energy) {
  return law.slot() + (friction ? 1 : 0) + (multi ? 2 : 0) + (energy ? 4 : 0);
}

/// Kernels of `isa`, or of the best one the processor has for Isa::automatic (TALUS_ISA overrides). `why` tells the
/// reason. Error{usage} for an instruction set that the processor lacks or that has no kernels of the precision, or an
/// unknown TALUS_ISA.
const KernelTable& select_kernels(Isa isa, std::string* why = nullptr, Precision precision = Precision::exact);
/// Instruction sets that can run here, best first.
std::vector<Isa> available_isas();
const char* isa_name(Isa isa) noexcept;
/// Error{usage} with the allowed names.
Isa parse_isa(const std::string& name);

/// Coefficients of every material pair of the scene as its law reads them (set-up is trajectory code: det_math).
std::vector<PairParameters> pair_parameters(const Scene& scene);
/// Whether contacts keep the velocity that the centred dashpot predicts for the pair alone: the last column of the law.
bool recalls(const Scene& scene);
/// What is added to the law, per material pair: rolling, twisting, cohesion.
std::vector<AddOnParameters> add_on_parameters(const Scene& scene);
/// Arguments of KernelTable::moments but for the coefficients, and the history columns that rolling and twisting need.
MomentArgs moment_args(const Scene& scene);
int moment_columns(const Scene& scene);
/// Bit k set: moment column k changes sign when the partners are swapped.
unsigned moment_flips(const Scene& scene);

}  // namespace talus
