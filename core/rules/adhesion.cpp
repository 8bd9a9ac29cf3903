// Set-up arithmetic of adhesion and cohesion; det_math where the trajectory depends on it.
#include "core/rules/adhesion.hpp"

#include <fmt/format.h>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"

namespace talus {

namespace {

double reduced_modulus(const Material& a, const Material& b) {
  return 1 / ((1 - a.poisson * a.poisson) / a.young + (1 - b.poisson * b.poisson) / b.young);
}

}  // namespace

double adhesion_length(const Scene& scene, int a, int b) {
  if (scene.contact.model != ContactModel::jkr) return 0;
  const Material &m = scene.materials[static_cast<std::size_t>(a)], &k = scene.materials[static_cast<std::size_t>(b)];
  return det::k_pi * scene.pair(a, b).work_of_adhesion / (8 * reduced_modulus(m, k));
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
  const ContactLaw& law = scene.contact;
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      const PairCoefficients& c = scene.pair(a, b);
      const std::string pair =
          scene.materials[static_cast<std::size_t>(a)].name + " - " + scene.materials[static_cast<std::size_t>(b)].name;
      // R* of a wall contact is the largest that a grain can have, also against one much larger than itself.
      if (law.cohesion == Cohesion::sjkr && c.cohesion_energy > 0) {
        if (law.model == ContactModel::linear) {
          // attraction c 2 pi R* delta to first order, against k_n delta
          const double most = law.normal_stiffness / (2 * det::k_pi * r_max);
          if (c.cohesion_energy >= most)
            throw Error(
                ErrorCode::scene,
                fmt::format("contact.cohesion_energy of {}: {:g} J/m3 attracts more than the spring of {:g} N/m "
                            "repels: grains would fall into each other",
                            pair, c.cohesion_energy, law.normal_stiffness),
                scene.file, fmt::format("less than {:.4g} J/m3, or a stiffer contact", most));
        } else {
          // 4/3 E* sqrt(R*) delta^(3/2) = c 2 pi R* delta: delta/R* = (3/2 pi c/E*)^2
          const double e_star = reduced_modulus(scene.materials[static_cast<std::size_t>(a)],
                                                scene.materials[static_cast<std::size_t>(b)]);
          const double root = 1.5 * det::k_pi * c.cohesion_energy / e_star, overlap = root * root;
          if (overlap >= scene.max_overlap)
            throw Error(
                ErrorCode::scene,
                fmt::format("contact.cohesion_energy of {}: {:g} J/m3 pulls grains in by {:.3g} of their radius", pair,
                            c.cohesion_energy, overlap),
                scene.file,
                fmt::format("at most {:.4g} J/m3 keeps it below checks.max_overlap = {:g}",
                            e_star * __builtin_sqrt(scene.max_overlap) / (1.5 * det::k_pi), scene.max_overlap));
        }
      }
      if (const double kappa = adhesion_length(scene, a, b); kappa > 0) {
        // overlap without load 2 6^(1/3) kappa^(2/3) R*^(1/3): relative to R* the smallest grains are pulled in most
        const double root = det::cbrt(kappa / (0.5 * r_min)), overlap = 2 * 1.8171205928321397 * root * root;
        if (0.5 * overlap >= scene.max_overlap)
          throw Error(
              ErrorCode::scene,
              fmt::format("contact.work_of_adhesion of {}: {:g} J/m2 pulls grains of radius {:g} in by {:.3g} of "
                          "it: beyond the theory of small deformations",
                          pair, c.work_of_adhesion, r_min, 0.5 * overlap),
              scene.file, "less adhesion or stiffer materials");
      }
    }
}

}  // namespace talus
