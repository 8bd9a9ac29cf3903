// See restitution.hpp.
#include "core/rules/restitution.hpp"

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/base/types.hpp"

namespace talus {

double clipped_restitution(double c, DampedSpring spring) {
  const double h = 1e-3;  // of the time sqrt(m/k), of which a contact lasts some 3
  const auto force = [&](double x, double v) {
    x = fmax2(x, 0);
    if (spring == DampedSpring::linear) return x + c * v;
    const double root = std::sqrt(x);
    return root * x + c * std::sqrt(root) * v;
  };
  double x = 0, v = 1;  // overlap and its rate
  for (int k = 0; k < 1000000; ++k) {
    // classical Runge-Kutta
    const double v1 = v, a1 = -force(x, v);
    const double v2 = v + 0.5 * h * a1, a2 = -force(x + 0.5 * h * v1, v2);
    const double v3 = v + 0.5 * h * a2, a3 = -force(x + 0.5 * h * v2, v3);
    const double v4 = v + h * a3, a4 = -force(x + h * v3, v4);
    x = x + h / 6 * (v1 + 2 * (v2 + v3) + v4);
    v = v + h / 6 * (a1 + 2 * (a2 + a3) + a4);
    // where the force vanishes the speed is extremal: the rest of the step changes it by O(h^2)
    if (v < 0 && !(force(x, v) > 0)) return -v;
  }
  return 0;
}

double damping_coefficient(double e, DampedSpring spring, bool clipped) {
  if (!clipped) {
    const double l = det::log(e), root = std::sqrt(det::k_pi * det::k_pi + l * l);
    return spring == DampedSpring::linear ? -2 * l / root : -std::sqrt(5.0) * l / root;
  }
  if (e >= 1) return 0;
  double low = 0, high = 1;  // beyond 1024 a restitution is below 2e-6, and the steps above are too long
  while (high < 1024 && clipped_restitution(high, spring) > e) high = 2 * high;
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (low + high);
    (clipped_restitution(middle, spring) > e ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace talus
