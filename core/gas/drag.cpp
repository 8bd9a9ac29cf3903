// See drag.hpp.
#include "core/gas/drag.hpp"

#include "core/base/det_math.hpp"
#include "core/base/types.hpp"

namespace talus::gas {

namespace {

constexpr double k_ln10 = 2.302585092994045684;

double ergun(double e, double re) { return (150 * (1 - e) + 1.75 * re) / (18 * e * e); }

double single_sphere(double re) { return re < 1000 ? 1 + 0.15 * det::pow(re, 0.687) : 0.44 / 24 * re; }

/// F of a grain alone by that of a sphere: C / K2 at K1 K2 Re, F = C Re / 24.
template <class Sphere>
double alone(const DragShape& s, double re, Sphere sphere) {
  return sphere(s.stokes * s.newton * re) / s.stokes;
}

double wen_yu(double e, double re, const DragShape& s = {}) { return alone(s, re, single_sphere) * det::pow(e, -3.65); }

/// Share of Wen and Yu: 0 below 0.7, 1 above 0.9.
double dilute(double e) {
  const double s = fmax2(0, fmin2(1, (e - 0.7) / 0.2));
  return s * s * (3 - 2 * s);
}

/// C_d Re / 24 of Dallavalle's sphere.
double dallavalle(double re) {
  const double root = 0.63 * __builtin_sqrt(re) + 4.8;
  return root * root / 24;
}

double di_felice(double e, double re, const DragShape& s = {}) {
  const double r = fmax2(re, 1e-9), lg = 1.5 - det::log(r) / k_ln10;
  return alone(s, r, dallavalle) * det::pow(e, -(3.7 - 0.65 * det::exp(-0.5 * lg * lg)));
}

double beetstra(double e, double re) {
  const double s = 1 - e, r = fmax2(re, 1e-9);
  const double viscous = 10 * s / (e * e) + e * e * (1 + 1.5 * __builtin_sqrt(s));
  const double top = 1 / e + 3 * e * s + 8.4 * det::pow(r, -0.343);
  const double bottom = 1 + det::pow(10, 3 * s) * det::pow(r, -0.5 * (1 + 4 * s));
  return viscous + 0.413 * r / (24 * e * e) * top / bottom;
}

}  // namespace

double drag_factor(GasDrag law, double e, double re) noexcept {
  switch (law) {
    case GasDrag::ergun:
      return ergun(e, re);
    case GasDrag::gidaspow: {
      const double w = dilute(e);
      if (w <= 0) return ergun(e, re);
      return w >= 1 ? wen_yu(e, re) : (1 - w) * ergun(e, re) + w * wen_yu(e, re);
    }
    case GasDrag::di_felice:
      return di_felice(e, re);
    case GasDrag::beetstra:
      return beetstra(e, re);
  }
  return 0;
}

double bed_resistance(GasDrag law, double e, double d, double mu, double rho, double slip) noexcept {
  return 18 * mu * (1 - e) * drag_factor(law, e, rho * slip * d / mu) / (e * d * d);
}

DragShape drag_shape(double psi) noexcept {
  const double lg = -det::log(psi) / k_ln10;
  return {psi, __builtin_sqrt(psi), lg > 0 ? det::pow(10, 1.8148 * det::pow(lg, 0.5743)) : 1.0};
}

double grain_drag(GasDrag law, double e, double own, double mean, double mu, double rho, double slip,
                  const DragShape& shape) noexcept {
  const double stokes = 3 * det::k_pi * mu * own * e, y = own / mean;
  const double re_own = rho * slip * own / mu, re_mean = rho * slip * mean / mu;
  switch (law) {
    case GasDrag::ergun:
      return stokes * y * y * ergun(e, re_mean);
    case GasDrag::gidaspow: {
      const double w = dilute(e);
      const double dense = w < 1 ? (1 - w) * y * y * ergun(e, re_mean) : 0;
      return stokes * (dense + (w > 0 ? w * wen_yu(e, re_own, shape) : 0));
    }
    case GasDrag::di_felice:
      return stokes * di_felice(e, re_own, shape);
    case GasDrag::beetstra:
      // van der Hoef et al. (2005): share of a size in the drag of a mixture
      return stokes * ((1 - e) * y * y + e * y) * beetstra(e, re_mean);
  }
  return 0;
}

double nusselt(GasNusselt law, double e, double re, double pr) noexcept {
  const double third = det::cbrt(pr);
  switch (law) {
    case GasNusselt::gunn:
      return (7 - 10 * e + 5 * e * e) * (1 + 0.7 * det::pow(re, 0.2) * third) +
             (1.33 - 2.4 * e + 1.2 * e * e) * det::pow(re, 0.7) * third;
    case GasNusselt::whitaker: {
      const double c = det::cbrt(re);
      return 2 + (0.4 * __builtin_sqrt(re) + 0.06 * c * c) * det::pow(pr, 0.4);
    }
    case GasNusselt::ranz_marshall:
      return 2 + 0.6 * __builtin_sqrt(re) * third;
    case GasNusselt::wakao:
      return 2 + 1.1 * det::pow(re, 0.6) * third;
  }
  return 0;
}

}  // namespace talus::gas
