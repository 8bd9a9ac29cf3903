// Law "linear": spring and dashpot (kernels/models/linear.hpp).
#pragma once

#include <fmt/format.h>

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/rules/laws/law.hpp"
#include "core/rules/restitution.hpp"

namespace talus::laws {

inline PairParameters linear_parameters(const Scene& scene, int a, int b) {
  const ContactLaw& law = scene.contact;
  PairParameters p;
  p.kn = law.normal_stiffness;
  p.kt = law.tangential_stiffness;
  // by restitution rate = 2 beta sqrt(k/m_eff); the tangential rate stays in 1/s
  p.gn = law.by_restitution ? damping_coefficient(scene.pair(a, b).restitution, DampedSpring::linear, law.clip_tension)
                            : law.normal_damping;
  p.gt = law.by_restitution && !(law.tangential_damping > 0) ? 0 : law.tangential_damping;
  return p;
}

inline ContactDynamics linear_dynamics(const Scene& scene, const ContactCase& c, const ReducedPair& p, double, double) {
  const ContactLaw& law = scene.contact;
  const double e = scene.pair(c.a, c.b).restitution;
  ContactDynamics d;
  d.stiffness = law.normal_stiffness;
  d.normal = law.normal_stiffness / p.m;
  const double omega = std::sqrt(d.normal);
  d.normal_rate = !law.by_restitution ? law.normal_damping
                  : e > 0             ? omega * damping_coefficient(e, DampedSpring::linear, law.clip_tension)
                                      : 0;
  // pi / sqrt(k/m - (g/2)^2); an overdamped contact never rebounds, its undamped time is the scale
  const double z = 0.5 * d.normal_rate / omega;
  d.duration = det::k_pi / (omega * (z < 1 ? std::sqrt(1 - z * z) : 1));
  if (law.friction) {
    d.tangential = law.tangential_stiffness / p.m;
    d.tangential_rate = law.tangential_damping;
  }
  return d;
}

/// delta = v sqrt(m/k), delta = F/k
inline Overlaps linear_overlaps(const Scene& scene, const Material&, double r, double m, double speed, double load) {
  const double k = scene.contact.normal_stiffness;
  return {speed * std::sqrt(m / k) / r, load / k / r};
}

/// Attraction c 2 pi R* delta to first order, against k_n delta.
inline void judge_linear_cohesion(const Scene& scene, int a, int b, double r_max) {
  const double energy = scene.pair(a, b).cohesion_energy, k = scene.contact.normal_stiffness;
  const double most = k / (2 * det::k_pi * r_max);
  if (energy < most) return;
  throw Error(ErrorCode::scene,
              fmt::format("contact.cohesion_energy of {}: {:g} J/m3 attracts more than the spring of {:g} N/m "
                          "repels: grains would fall into each other",
                          pair_name(scene, a, b), energy, k),
              scene.file, fmt::format("less than {:.4g} J/m3, or a stiffer contact", most));
}

inline StoredEnergy linear_stored(const PairParameters& p, double, double overlap) {
  return {0.5 * p.kn * (overlap * overlap), p.kn * overlap, 0};
}

inline constexpr Law k_linear{
    .model = ContactModel::linear,
    .what = "spring and dashpot",
    .force = {.name = "linear", .force = LawForce::linear, .history = 3, .flips = 0b111, .trial = true},
    .balanced = true,
    .weighs_spring = true,
    .parameters = linear_parameters,
    .stored = linear_stored,
    .dynamics = linear_dynamics,
    .overlaps = linear_overlaps,
    .impact_power = 0.5,
    .load_power = 1,
    .judge_cohesion = judge_linear_cohesion,
};

}  // namespace talus::laws
