// See heat_scene.hpp.
#include "scheduler/parts/heat_scene.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/rules/laws/law.hpp"

namespace talus {
namespace {

bool of_walls_alone(const Scene& scene, int material) {
  const auto has = [&](const auto& x) { return x.material == material; };
  return std::none_of(scene.sources.begin(), scene.sources.end(), has) &&
         std::any_of(scene.walls.begin(), scene.walls.end(), has);
}

/// A spring k is a Hertz contact of E* = 3 k / (4 sqrt(R* d)) at the overlap d: softest for the largest grain on a wall
/// at the deepest overlap. A real modulus below that is softer than the model at every overlap. Walls may be: of
/// rubber.
void refuse_soft_modulus(const Rules& rules) {
  const Scene& scene = rules.scene;
  if (rules.law.info->wants_reff || !(rules.r_max > 0)) return;
  const double softest = 3 * scene.contact.normal_stiffness / (4 * rules.r_max * __builtin_sqrt(scene.max_overlap));
  for (std::size_t k = 0; k < scene.materials.size() && k < scene.heat.matter.size(); ++k) {
    const double young = scene.heat.matter[k].young, nu = scene.materials[k].poisson;
    const double least = 2 * (1 - nu * nu) * softest;
    if (!(young > 0) || young >= least || of_walls_alone(scene, static_cast<int>(k))) continue;
    throw Error(
        ErrorCode::scene,
        fmt::format("heat.young: {:g} Pa of material '{}' is softer than the spring of the contact law "
                    "({:g} N/m) at every overlap that the run allows",
                    young, scene.materials[k].name, scene.contact.normal_stiffness),
        scene.file,
        fmt::format("is the real modulus, which a model softens and never stiffens: at least {:.3g} Pa", least));
  }
}

/// As wide as the layer of the smallest grain, it is the width of every gap that conducts, near or far.
void refuse_wide_least_gap(const Rules& rules) {
  const GapHeat& gap = rules.scene.heat.gap;
  if (!(gap.conductivity > 0) || !(rules.r_min < k_never) || gap.least_gap < gap.layer * rules.r_min) return;
  throw Error(ErrorCode::scene,
              fmt::format("heat.gap.least_gap: {:g} m is no less than the layer of gas that the smallest grain carries "
                          "(heat.gap.layer * {:g} m = {:g} m): all gaps would conduct alike",
                          gap.least_gap, rules.r_min, gap.layer * rules.r_min),
              rules.scene.file, "of the size of the roughness, or of the mean free path of the gas");
}

}  // namespace

void refuse_odd_heat(const Rules& rules) {
  refuse_soft_modulus(rules);
  refuse_wide_least_gap(rules);
}

}  // namespace talus
