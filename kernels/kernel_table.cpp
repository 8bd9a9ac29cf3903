// Run-time choice of the instruction set, and coefficients as the kernels read them.
#include "kernels/kernel_table.hpp"

#include <algorithm>
#include <cstdlib>

#include "core/base/error.hpp"

namespace talus {

extern const KernelTable k_table_scalar, k_table_sse2, k_table_avx2, k_table_avx512;
extern const KernelTable k_table_avx2_fast, k_table_avx512_fast;

namespace {

const KernelTable& table(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return k_table_avx512;
    case Isa::avx2:
      return k_table_avx2;
    case Isa::sse2:
      return k_table_sse2;
    default:
      return k_table_scalar;
  }
}

// __builtin_cpu_supports accounts for what the operating system enables (XCR0); xsimd's own detection does not.
bool has_processor(Isa isa) {
  switch (isa) {
    case Isa::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
             __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
             __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("bmi2");
    case Isa::avx2:
      return __builtin_cpu_supports("avx2");
    default:
      return true;
  }
}

bool built(const KernelTable& t) { return t.name != nullptr; }  // else left out by the build's TALUS_ISAS

}  // namespace

const char* isa_name(Isa isa) noexcept {
  switch (isa) {
    case Isa::scalar:
      return "scalar";
    case Isa::sse2:
      return "sse2";
    case Isa::avx2:
      return "avx2";
    case Isa::avx512:
      return "avx512";
    default:
      return "automatic";
  }
}

Isa parse_isa(const std::string& name) {
  for (Isa i : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512})
    if (name == isa_name(i)) return i;
  if (name == "auto" || name == "automatic" || name.empty()) return Isa::automatic;
  throw Error(ErrorCode::usage, "unknown instruction set '" + name + "'", "--isa",
              "allowed: scalar, sse2, avx2, avx512");
}

std::vector<Isa> available_isas() {
  std::vector<Isa> v;
  for (Isa i : {Isa::avx512, Isa::avx2, Isa::sse2, Isa::scalar})
    if (has_processor(i) && built(table(i))) v.push_back(i);
  return v;
}

/// The best set that can run here. Error{usage} where the build has none that this processor supports.
static Isa best_isa() {
  const std::vector<Isa> all = available_isas();
  if (all.empty())
    throw Error(ErrorCode::usage, "this processor supports none of the instruction sets of this build", "TALUS_ISAS",
                "a build with another TALUS_ISAS");
  return all.front();
}

const KernelTable& select_kernels(Isa isa, std::string* why, Precision precision) {
  std::string reason = "requested";
  if (isa == Isa::automatic) {
    const char* env = std::getenv("TALUS_ISA");
    if (env != nullptr && *env != '\0') {
      isa = parse_isa(env);
      reason = "TALUS_ISA";
    }
  }
  if (isa == Isa::automatic) {
    isa = best_isa();
    reason = "best that this processor and system support";
  }
  if (!has_processor(isa) || !built(table(isa)))
    throw Error(
        ErrorCode::usage,
        std::string(has_processor(isa) ? "this build leaves out " : "this processor does not support ") + isa_name(isa),
        "--isa", std::string("best available: ") + isa_name(best_isa()));
  if (why != nullptr) *why = reason;
  if (precision == Precision::exact) return table(isa);
  if (isa == Isa::avx512 && built(k_table_avx512_fast)) return k_table_avx512_fast;
  if (isa == Isa::avx2 && __builtin_cpu_supports("fma") && built(k_table_avx2_fast)) return k_table_avx2_fast;
  const bool could = isa == Isa::avx512 || (isa == Isa::avx2 && __builtin_cpu_supports("fma"));
  throw Error(ErrorCode::usage,
              could ? std::string("this build leaves out the fast kernels of ") + isa_name(isa)
                    : std::string("there are no fast kernels for ") + isa_name(isa) + " on this processor",
              "precision = \"fast\"", "precision = \"exact\", or avx2 with fused multiply-add, or avx512");
}

std::vector<PairParameters> pair_parameters(const Scene& scene) {
  const int n = static_cast<int>(scene.materials.size());
  std::vector<PairParameters> out;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      out.push_back(law_of(scene).parameters(scene, a, b));
      out.back().mu = scene.pair(a, b).friction;
    }
  return out;
}

bool recalls(const Scene& scene) {
  if (scene.contact.dashpot != Dashpot::centred) return false;
  // Elastic contacts too: leapfrog alone is off by up to (omega dt)^2/4 of the energy where they begin and end.
  if (law_of(scene).weighs_spring && scene.contact.onset_correction) return true;
  const auto all = pair_parameters(scene);
  return std::any_of(all.begin(), all.end(), [](const PairParameters& p) { return p.gn != 0; });
}

std::vector<AddOnParameters> add_on_parameters(const Scene& scene) {
  std::vector<AddOnParameters> out;
  for (const PairCoefficients& c : scene.pairs) {
    AddOnParameters p;
    p.rolling = c.rolling_friction;
    p.viscous = c.rolling_damping;
    p.twisting = c.twisting_friction;
    p.torsion = c.twisting_damping;
    p.cohesion = c.cohesion_energy;
    out.push_back(p);
  }
  return out;
}

MomentArgs moment_args(const Scene& scene) {
  MomentArgs a{};
  a.dt = scene.dt;
  a.rolling = static_cast<int>(scene.contact.rolling);
  a.twisting = scene.contact.twisting ? 1 : 0;
  const bool springs = scene.contact.rolling == Rolling::epsd || scene.contact.twisting;
  a.rescale = law_of(scene).by_modulus && springs ? 1 : 0;
  a.centred = scene.contact.dashpot != Dashpot::lagged ? 1 : 0;
  return a;
}

int moment_columns(const Scene& scene) {
  const MomentArgs a = moment_args(scene);
  return (a.rolling == 2 ? 3 : 0) + a.twisting + a.rescale;
}

unsigned moment_flips(const Scene& scene) { return moment_args(scene).rolling == 2 ? 7U : 0U; }

}  // namespace talus
