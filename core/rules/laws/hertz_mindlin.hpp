// Law "hertz_mindlin" (kernels/models/hertz_mindlin.hpp), damped so that the restitution is exact.
#pragma once

#include "core/rules/laws/hertz.hpp"

namespace talus::laws {

inline constexpr Law k_hertz_mindlin{
    .model = ContactModel::hertz_mindlin,
    .what = "restitution exact",
    .force =
        {.name = "hertz_mindlin", .force = LawForce::hertz_mindlin, .history = 4, .flips = 0b0111, .wants_reff = true},
    .partial_slip = k_partial_slip,
    .by_modulus = true,
    .parameters = [](const Scene& scene, int a,
                     int b) { return hertz_parameters(scene, a, b, hertz_damping(scene, a, b)); },
    .stored = hertz_stored,
    .dynamics = hertz_dynamics,
    .overlaps = hertz_overlaps,
    .impact_power = 0.4,
    .load_power = 2.0 / 3.0,
    .judge_cohesion = judge_hertz_cohesion,
};

}  // namespace talus::laws
