// Run-time choice of the instruction set and coefficients of the contact laws.
#include "kernels/kernel_table.hpp"

#include <algorithm>
#include <cstdlib>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/rules/restitution.hpp"

namespace talus {

extern const KernelTable k_table_scalar, k_table_sse2, k_table_avx2, k_table_avx512;
extern const KernelTable k_table_avx2_fast, k_table_avx512_fast;

namespace {

constexpr LawInfo k_laws[] = {
    {ContactModel::linear, "linear", 0, 3, false},
    {ContactModel::hertz_mindlin, "hertz_mindlin", 8, 4, true},
    {ContactModel::hertz_tsuji, "hertz_tsuji", 8, 4, true},
    {ContactModel::jkr, "jkr", 16, 4, true},
};
constexpr LawInfo k_partial_slip{ContactModel::hertz_mindlin, "partial_slip", 24, 7, true};

// __builtin_cpu_supports accounts for what the operating system enables (XCR0); xsimd's own detection does not.
bool supported(Isa isa) {
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

}  // namespace

const LawInfo& law_info(ContactModel model) {
  for (const LawInfo& l : k_laws)
    if (l.model == model) return l;
  throw Error(ErrorCode::scene, "contact model without a kernel");
}

const LawInfo& law_info(const ContactLaw& law) { return law.partial_slip ? k_partial_slip : law_info(law.model); }

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
    if (supported(i)) v.push_back(i);
  return v;
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
    isa = available_isas().front();
    reason = "best that this processor and system support";
  }
  if (!supported(isa))
    throw Error(ErrorCode::usage, std::string("this processor does not support ") + isa_name(isa), "--isa",
                std::string("best available: ") + isa_name(available_isas().front()));
  if (why != nullptr) *why = reason;
  if (precision == Precision::exact) return table(isa);
  if (isa == Isa::avx512) return k_table_avx512_fast;
  if (isa == Isa::avx2 && __builtin_cpu_supports("fma")) return k_table_avx2_fast;
  throw Error(ErrorCode::usage, std::string("there are no fast kernels for ") + isa_name(isa) + " on this processor",
              "precision = \"fast\"", "precision = \"exact\", or avx2 with fused multiply-add, or avx512");
}

std::vector<PairParameters> pair_parameters(const Scene& scene) {
  const auto n = scene.materials.size();
  const ContactLaw& law = scene.contact;
  std::vector<PairParameters> out(n * n);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) {
      const PairCoefficients& c = scene.pair(static_cast<int>(a), static_cast<int>(b));
      PairParameters& p = out[a * n + b];
      p.mu = c.friction;
      if (law.model == ContactModel::linear) {
        p.kn = law.normal_stiffness;
        p.kt = law.tangential_stiffness;
        if (law.by_restitution) {
          // rate = 2 beta sqrt(k/m_eff); the same rate tangentially
          p.gn = damping_coefficient(c.restitution, DampedSpring::linear, law.clip_tension);
          p.gt = law.tangential_damping > 0 ? law.tangential_damping : 0;
        } else {
          p.gn = law.normal_damping;
          p.gt = law.tangential_damping;
        }
      } else {
        const Material &m = scene.materials[a], &k = scene.materials[b];
        const double e_star = 1 / ((1 - m.poisson * m.poisson) / m.young + (1 - k.poisson * k.poisson) / k.young);
        const double ga = m.young / (2 * (1 + m.poisson)), gb = k.young / (2 * (1 + k.poisson));
        const double g_star = 1 / ((2 - m.poisson) / ga + (2 - k.poisson) / gb);
        const double e = c.restitution;
        double alpha = 0;
        if (law.model == ContactModel::hertz_tsuji) {
          alpha = 1.2728 + e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218)))));
        } else {
          alpha = damping_coefficient(e, DampedSpring::hertz, law.clip_tension);
        }
        p.kn = 4.0 / 3.0 * e_star;
        p.kt = 8 * g_star;
        p.gn = alpha;
        p.gt = __builtin_sqrt(2.0 / 3.0) * alpha;
        p.w = law.model == ContactModel::jkr ? c.work_of_adhesion : 0;
      }
    }
  return out;
}

bool recalls(const Scene& scene) {
  if (scene.contact.dashpot != Dashpot::centred) return false;
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
  a.rescale = scene.contact.model != ContactModel::linear && springs ? 1 : 0;
  a.centred = scene.contact.dashpot != Dashpot::lagged ? 1 : 0;
  return a;
}

int moment_columns(const Scene& scene) {
  const MomentArgs a = moment_args(scene);
  return (a.rolling == 2 ? 3 : 0) + a.twisting + a.rescale;
}

unsigned moment_flips(const Scene& scene) { return moment_args(scene).rolling == 2 ? 7U : 0U; }

}  // namespace talus
