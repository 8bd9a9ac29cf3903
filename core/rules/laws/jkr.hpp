// Law "jkr": adhesive hertz_mindlin (kernels/models/jkr.hpp).
#pragma once

#include "core/rules/laws/hertz.hpp"

namespace talus::laws {

inline PairParameters jkr_parameters(const Scene& scene, int a, int b) {
  PairParameters p = hertz_parameters(scene, a, b, hertz_damping(scene, a, b));
  p.w = scene.pair(a, b).work_of_adhesion;
  return p;
}

/// kappa = pi w / (8 E*) [m].
inline double jkr_length(const Scene& scene, int a, int b) {
  return det::k_pi * scene.pair(a, b).work_of_adhesion / (8 * reduced_modulus(material(scene, a), material(scene, b)));
}

/// Largest contact radius [m] of an impact at speed v: the energy 1/2 m v^2 and what attaching sets free, pi w a_c^2
/// (s^10/15 - 2/3 s^7 + s^4 + 12/5 4^(1/3)) with a = a_c s^2.
inline double jkr_radius(double kappa, double e_star, double r, double m, double v) {
  const double a_c = det::cbrt(kappa * r * r), scale = 8 * e_star * kappa * (a_c * a_c);  // pi w = 8 E* kappa
  const double energy = 0.5 * m * (v * v) / scale;
  double low = 1.5874010519681994, high = 1e6;  // s at zero overlap
  for (int k = 0; k < 100; ++k) {
    const double s = 0.5 * (low + high), s3 = s * s * s, s4 = s3 * s;
    const bool above = s4 * (s3 * s3 / 15 - 2 * s3 / 3 + 1) + 2.4 * 1.5874010519681994 > energy;
    (above ? high : low) = s;
  }
  return a_c * high * high;
}

/// Adhesion pulls the contact open wider than the impact alone; 4.03 / omega is the same duration for Hertz.
inline ContactDynamics jkr_dynamics(const Scene& scene, const ContactCase& c, const ReducedPair& p, double speed,
                                    double pressure) {
  HertzImpact h = hertz_impact(scene, c, p, speed, pressure);
  if (const double kappa = jkr_length(scene, c.a, c.b); kappa > 0) {
    h.radius = fmax2(h.radius, jkr_radius(kappa, h.e_star, p.r, p.m, h.speed));
    h.duration = 2.9433 * std::sqrt(15.0 / 8.0) / std::sqrt(2 * h.e_star * h.radius / p.m);
  }
  return dynamics_at(scene, c, p, h);
}

inline constexpr Law k_jkr{
    .model = ContactModel::jkr,
    .what = "adhesive hertz_mindlin",
    .force = {.name = "jkr", .force = LawForce::jkr, .history = 4, .flips = 0b0111, .wants_reff = true},
    .by_modulus = true,
    .never_clips = "contradicts adhesion and cohesion, which pull",
    .parameters = jkr_parameters,
    .dynamics = jkr_dynamics,
    .overlaps = hertz_overlaps,
    .impact_power = 0.4,
    .load_power = 2.0 / 3.0,
    .adhesion = jkr_length,
};

}  // namespace talus::laws
