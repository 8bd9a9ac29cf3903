// Damping coefficient of a contact law for a wanted coefficient of restitution. Who calls it: core/rules/laws
// (coefficients and limits). Invariant: I4 (own log, + - * / sqrt: set-up is
// trajectory code).
#pragma once

namespace talus {

enum class DampedSpring { linear, hertz };

/// Coefficient c of the dashpot [-] for restitution e in (0, 1], in the scaled equation of an impact
///   linear  x'' = -x - c x'                  c = 2 beta, damping rate c sqrt(k/m)
///   hertz   x'' = -x^(3/2) - c x^(1/4) x'    c = alpha
/// where contact lasts until x = 0: c / 2 = -ln e / sqrt(pi^2 + ln^2 e), times sqrt(5) (Antypov & Elliott 2011).
/// `clipped`: the force never pulls, so it ends where x + c x' = 0 (Schwager & Poeschel 2007): found by bisection over
/// impacts integrated numerically, e met within 2e-6.
double damping_coefficient(double e, DampedSpring spring, bool clipped);

/// Restitution of the clipped impact with coefficient c.
double clipped_restitution(double c, DampedSpring spring);

}  // namespace talus
