// Set-up arithmetic of adhesion and cohesion; det_math where the trajectory depends on it.
#include "core/rules/adhesion.hpp"

#include <fmt/format.h>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/rules/laws/law.hpp"

namespace talus {

double adhesion_length(const Scene& scene, int a, int b) {
  const auto length = law_of(scene).adhesion;
  return length != nullptr ? length(scene, a, b) : 0;
}

double adhesion_reach(const Scene& scene) {
  const int n = static_cast<int>(scene.materials.size());
  double longest = 0;
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) longest = fmax2(longest, adhesion_length(scene, a, b));
  const double root = det::cbrt(longest);
  return 1.5 * (root * root) * (1 + 1e-9);  // the narrow phase compares cubes: cover the roundings
}

void check_attraction(const Scene& scene, double r_min, double r_max) {
  if (!(r_min > 0)) return;  // no particle can ever appear
  const int n = static_cast<int>(scene.materials.size());
  const Law& law = law_of(scene);
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      const PairCoefficients& c = scene.pair(a, b);
      // R* of a wall contact is the largest that a grain can have, also against one much larger than itself.
      if (scene.contact.cohesion == Cohesion::sjkr && c.cohesion_energy > 0 && law.judge_cohesion != nullptr)
        law.judge_cohesion(scene, a, b, r_max);
      if (const double kappa = adhesion_length(scene, a, b); kappa > 0) {
        // overlap without load 2 6^(1/3) kappa^(2/3) R*^(1/3): relative to R* the smallest grains are pulled in most
        const double root = det::cbrt(kappa / (0.5 * r_min)), overlap = 2 * 1.8171205928321397 * root * root;
        if (0.5 * overlap >= scene.max_overlap)
          throw Error(
              ErrorCode::scene,
              fmt::format("contact.work_of_adhesion of {}: {:g} J/m2 pulls grains of radius {:g} in by {:.3g} of "
                          "it: beyond the theory of small deformations",
                          pair_name(scene, a, b), c.work_of_adhesion, r_min, 0.5 * overlap),
              scene.file, "less adhesion or stiffer materials");
      }
    }
}

}  // namespace talus
