// Cohesion "sjkr" (simplified JKR): an attraction proportional to the contact area, added to the force of any law and
// acting while the grains overlap. Instantiated by isa_*.cpp; called by scheduler/nodes/add_ons.cpp for scenes that ask
// for it.
//   F = -c A n,  A = -pi/4 (d - r_i - r_j)(d + r_i - r_j)(d - r_i + r_j)(d + r_i + r_j) / d^2
// (the disc in which two spheres intersect; with a wall A = pi (r^2 - d^2)), c the cohesion energy density [J/m3].
// The force rows and the elastic energy are added to; Coulomb's and the rolling limit keep the law's own normal force,
// that is, they include what cohesion presses the surfaces together with. No history, no range beyond touch.
#pragma once

#include "kernels/models/linear.hpp"

namespace talus::kernels {

template <class S>
void cohesion(Block& b, const CohesionArgs& a) {
  using B = typename S::B;
  const B one = S::set(1.0), third = S::set(1.0 / 3.0);
  for (int k = 0; k < b.n; k += S::W) {
    double density[S::W], unequal[S::W];
    for (int q = 0; q < S::W; ++q) {
      const bool real = k + q < b.n;
      density[q] = a.table == nullptr ? a.one : a.table[real ? b.pair[k + q] : 0];
      unequal[q] = real && a.p != nullptr ? a.p[4L * a.i[k + q] + 3] - a.p[4L * a.j[k + q] + 3] : 0;
    }
    const B c = S::load(density), g = S::load(unequal), w = S::load(b.w + k);
    const B x[3] = {S::load(b.x + k), S::load(b.y + k), S::load(b.z + k)};
    const B d2 = (x[0] * x[0] + x[1] * x[1]) + x[2] * x[2], d = S::sqrt(d2), inv = one / d;
    const B cap = (w - d) * (w + d);
    B area, energy;  // energy: integral of the area from d to w, with the common factor (w - d) taken out
    if (a.p != nullptr) {
      const B quarter_pi = S::set(0.78539816339744830962);
      area = quarter_pi * (cap * ((d2 - g * g) * (inv * inv)));
      energy = quarter_pi * ((w * w + g * g) - third * ((w * w + w * d) + d2) - (w * (g * g)) * inv);
    } else {
      const B pi = S::set(3.14159265358979323846);
      area = pi * cap;
      energy = pi * (w * w - third * ((w * w + w * d) + d2));
    }
    const B pull = (c * area) * inv;
    for (int q = 0; q < 3; ++q) S::store(b.r[q] + k, S::load(b.r[q] + k) - pull * x[q]);
    if (a.energy != 0) S::store(b.e[0] + k, S::load(b.e[0] + k) - c * ((w - d) * energy));
  }
}

}  // namespace talus::kernels
