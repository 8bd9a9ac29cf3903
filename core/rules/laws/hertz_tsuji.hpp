// Law "hertz_tsuji": hertz_mindlin with the damping polynomial of Tsuji et al. in place of the exact restitution.
#pragma once

#include "core/rules/laws/hertz.hpp"

namespace talus::laws {

inline PairParameters tsuji_parameters(const Scene& scene, int a, int b) {
  const double e = scene.pair(a, b).restitution;
  return hertz_parameters(
      scene, a, b, 1.2728 + e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218))))));
}

inline constexpr Law k_hertz_tsuji{
    .model = ContactModel::hertz_tsuji,
    .what = "Tsuji's damping polynomial, for comparison: restitution comes out higher than asked (0.70 for 0.6)",
    .force =
        {.name = "hertz_tsuji", .force = LawForce::hertz_mindlin, .history = 4, .flips = 0b0111, .wants_reff = true},
    .partial_slip = k_partial_slip,
    .by_modulus = true,
    .never_clips = "Tsuji's polynomial holds for contacts that end with their overlap: use model = hertz_mindlin",
    .parameters = tsuji_parameters,
    .stored = hertz_stored,
    .dynamics = hertz_dynamics,
    .overlaps = hertz_overlaps,
    .impact_power = 0.4,
    .load_power = 2.0 / 3.0,
    .judge_cohesion = judge_hertz_cohesion,
};

}  // namespace talus::laws
