// What laws of elastic spheres share: Hertz's contact of two materials and what limits follow from it.
#pragma once

#include <fmt/format.h>

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/rules/laws/law.hpp"
#include "core/rules/restitution.hpp"

namespace talus::laws {

inline const Material& material(const Scene& scene, int a) { return scene.materials[static_cast<std::size_t>(a)]; }

/// E* and G* of two materials [Pa].
inline double reduced_modulus(const Material& a, const Material& b) {
  return 1 / ((1 - a.poisson * a.poisson) / a.young + (1 - b.poisson * b.poisson) / b.young);
}
inline double reduced_shear_modulus(const Material& a, const Material& b) {
  const double ga = a.young / (2 * (1 + a.poisson)), gb = b.young / (2 * (1 + b.poisson));
  return 1 / ((2 - a.poisson) / ga + (2 - b.poisson) / gb);
}

/// With the dashpot's coefficient alpha [-].
inline PairParameters hertz_parameters(const Scene& scene, int a, int b, double alpha) {
  const Material &m = material(scene, a), &k = material(scene, b);
  PairParameters p;
  p.kn = 4.0 / 3.0 * reduced_modulus(m, k);
  p.kt = 8 * reduced_shear_modulus(m, k);
  p.gn = alpha;
  p.gt = __builtin_sqrt(2.0 / 3.0) * alpha;
  return p;
}

inline StoredEnergy hertz_stored(const PairParameters& p, double reduced, double overlap) {
  const double f = p.kn * __builtin_sqrt(reduced * overlap) * overlap, e = 0.4 * f * overlap;
  return {e, f, 0.5 * e / reduced};
}

/// alpha of the exact restitution.
inline double hertz_damping(const Scene& scene, int a, int b) {
  return damping_coefficient(scene.pair(a, b).restitution, DampedSpring::hertz, scene.contact.clip_tension);
}

/// Largest contact radius and duration of an impact.
struct HertzImpact {
  double e_star = 0, g_star = 0;  ///< [Pa]
  double speed = 0;               ///< [m/s]
  double radius = 0;              ///< [m]
  double duration = 0;            ///< [s]
};

inline HertzImpact hertz_impact(const Scene& scene, const ContactCase& c, const ReducedPair& p, double speed,
                                double pressure) {
  const Material &a = material(scene, c.a), &b = material(scene, c.b);
  HertzImpact h;
  h.e_star = reduced_modulus(a, b);
  h.g_star = 1 / ((2 - a.poisson) * 2 * (1 + a.poisson) / a.young + (2 - b.poisson) * 2 * (1 + b.poisson) / b.young);
  h.speed = speed > 0 || pressure > 0 ? fmax2(speed, 1e-9) : 1e-5 * std::sqrt(h.e_star / a.density);
  // delta_max = (15 m v^2 / (16 E* sqrt(R)))^(2/5), t_c = 2.9433 delta_max / v
  const double delta = det::pow(15 * p.m * (h.speed * h.speed) / (16 * h.e_star * std::sqrt(p.r)), 0.4);
  // under load a^3 = 3 F R / (4 E*)
  const double width = 2 * (c.wall() ? c.r_a : fmin2(c.r_a, c.r_b)), load = pressure * (width * width);
  h.radius = fmax2(std::sqrt(p.r * delta), det::cbrt(3 * load * p.r / (4 * h.e_star)));
  h.duration = 2.9433 * delta / h.speed;
  return h;
}

/// Tangent stiffness 2 E* a, dashpot alpha sqrt(m 4/3 E* a); tangentially 8 G* a, sqrt(2/3) alpha sqrt(m 8 G* a).
inline ContactDynamics dynamics_at(const Scene& scene, const ContactCase& c, const ReducedPair& p,
                                   const HertzImpact& h) {
  const double alpha = scene.pair(c.a, c.b).restitution > 0 ? hertz_damping(scene, c.a, c.b) : 0;
  ContactDynamics d;
  d.duration = h.duration;
  d.stiffness = 2 * h.e_star * h.radius;
  d.normal = 2 * h.e_star * h.radius / p.m;
  d.normal_rate = alpha * std::sqrt(2.0 / 3.0 * d.normal);
  if (scene.contact.friction) {
    d.tangential = 8 * h.g_star * h.radius / p.m;
    d.tangential_rate = alpha * std::sqrt(2.0 / 3.0 * d.tangential);
  }
  return d;
}

inline ContactDynamics hertz_dynamics(const Scene& scene, const ContactCase& c, const ReducedPair& p, double speed,
                                      double pressure) {
  return dynamics_at(scene, c, p, hertz_impact(scene, c, p, speed, pressure));
}

/// delta = (15 m v^2 / (16 E* sqrt(r)))^(2/5), delta = (3 F / (4 E* sqrt(r/2)))^(2/3)
inline Overlaps hertz_overlaps(const Scene&, const Material& material, double r, double m, double speed, double load) {
  const double e_star = material.young / (2 * (1 - material.poisson * material.poisson));
  return {det::pow(15 * m * (speed * speed) / (16 * e_star * std::sqrt(r)), 0.4) / r,
          det::pow(3 * load / (4 * e_star * std::sqrt(0.5 * r)), 2.0 / 3.0) / r};
}

/// 4/3 E* sqrt(R*) delta^(3/2) = c 2 pi R* delta: delta/R* = (3/2 pi c/E*)^2.
inline void judge_hertz_cohesion(const Scene& scene, int a, int b, double) {
  const double energy = scene.pair(a, b).cohesion_energy,
               e_star = reduced_modulus(material(scene, a), material(scene, b));
  const double root = 1.5 * det::k_pi * energy / e_star, overlap = root * root;
  if (overlap < scene.max_overlap) return;
  throw Error(ErrorCode::scene,
              fmt::format("contact.cohesion_energy of {}: {:g} J/m3 pulls grains in by {:.3g} of their radius",
                          pair_name(scene, a, b), energy, overlap),
              scene.file,
              fmt::format("at most {:.4g} J/m3 keeps it below checks.max_overlap = {:g}",
                          e_star * __builtin_sqrt(scene.max_overlap) / (1.5 * det::k_pi), scene.max_overlap));
}

/// Columns: the elastic tangential force, the last contact radius; with partial slip those of a second ring.
inline constexpr LawInfo k_partial_slip{
    .name = "partial_slip", .force = LawForce::partial_slip, .history = 7, .flips = 0b1110111, .wants_reff = true};

}  // namespace talus::laws
