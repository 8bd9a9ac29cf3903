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

/// Root s >= 1 of s^4 - 4 s = D for excess = D + 3 > 0, as in the kernel.
inline double jkr_root(double excess) {
  const double target = __builtin_sqrt(excess), wide = __builtin_sqrt(target), flat = target * 0.408248290463863016;
  double u = fmin2(flat, wide);
  for (int k = 0; k < 6; ++k) {
    const double root = __builtin_sqrt((u * u + 4 * u) + 6);
    u = u - ((u * root - target) * root) / ((2 * (u * u) + 6 * u) + 6);
  }
  return 1 + u;
}

/// Necks below zero overlap store nothing: what is done on them counts as lost.
inline StoredEnergy jkr_stored(const PairParameters& p, double reduced, double overlap) {
  if (!(overlap > 0)) return {};
  const double modulus = 0.75 * p.kn, w = fmax2(p.w, 1e-20 * (modulus * reduced));
  const double ac = det::cbrt(det::k_pi * w * (reduced * reduced / (8 * modulus)));
  const double unit = ac * ac / reduced, pull = det::k_pi * w * reduced;
  const double s = jkr_root(fmax2(overlap / unit + 3, 0)), s3 = s * s * s;
  const double f = pull * (s3 * (s3 / 6 - 1));
  const double e = pull * unit * (s3 * s * (s3 * s3 / 15 - s3 * (2.0 / 3) + 1) + 3.8097625247236784);
  return {e, f, (4 * e - overlap * f) / (3 * reduced)};  // pull goes with R, unit with R^(1/3)
}

inline constexpr Law k_jkr{
    .model = ContactModel::jkr,
    .what = "adhesive hertz_mindlin",
    .force = {.name = "jkr", .force = LawForce::jkr, .history = 4, .flips = 0b0111, .wants_reff = true},
    .by_modulus = true,
    .never_clips = "contradicts adhesion and cohesion, which pull",
    .parameters = jkr_parameters,
    .stored = jkr_stored,
    .dynamics = jkr_dynamics,
    .overlaps = hertz_overlaps,
    .impact_power = 0.4,
    .load_power = 2.0 / 3.0,
    .adhesion = jkr_length,
};

}  // namespace talus::laws
