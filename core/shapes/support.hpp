// Support function of a superquadric and what Newton's method needs of it: the point, the matrix of radii of curvature.
// Who calls it: pair_newton.hpp, walls. Invariants: I4; every sum of squares below is free of cancellation.
//
// The body |x/a|^n2 + |y/b|^n2 to the power n1/n2, plus |z/c|^n1 <= 1 has, along a unit vector m of its frame,
//   h = ((X^(p2/2) + Y^(p2/2))^(p1/p2) + Z^(p1/2))^(1/p1),  X = (a m_x)^2 ...,  p = n / (n - 1)
// (SHAPES: dual norms). For n > 2 its second derivative is infinite where a component of m vanishes: a face is flat.
// So X = a^2 (m_x^2 + eta^2): a convex body that touches the exact one from outside to about eta^p, whose faces have a
// radius of curvature of at most about eta^(p-2). eta = k_eta hides below 1e-9 of the size, and keeps the place of
// contact on a face a function of the normal that doubles resolve; large eta rounds the body, down to a ball: a path
// along which Newton's method finds its way from the line of centres.
#pragma once

#include "core/shapes/power.hpp"

namespace talus::shapes {

/// Rounding of the bodies in contact, relative to their size.
inline constexpr double k_eta = 1e-9;

template <class S>
struct Triple {
  typename S::B x, y, z;
};
template <class S>
TALUS_SHAPES_INLINE typename S::B dot(const Triple<S>& a, const Triple<S>& b) {
  return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

/// Semi-axes [m] squared and dual exponents of a body. p = n / (n - 1), in (1, 2].
template <class S>
struct DualForm {
  Triple<S> axes2;
  typename S::B p1, p2;
};

template <class S>
struct Support {
  typename S::B h;  ///< [m]
  Triple<S> point;  ///< surface point with outer normal m, body frame [m]
  Triple<S> drift;  ///< derivative of the point by eta at a fixed normal, but for its part along m [m]
  // Radii of curvature, a symmetric matrix on the tangents: sums of squares of these forms.
  Triple<S> ratio;          ///< m_k / (m_k^2 + eta^2)
  Triple<S> flat;           ///< weight of v_k^2: part of the rounding
  typename S::B ring, rim;  ///< factors of the two squared differences
  typename S::B alpha;      ///< share of x in the pair (x, y)
  typename S::B round;      ///< weight of v . v
};

/// The support function, and the terms that it is made of.
template <class S>
struct Height {
  typename S::B h;  ///< [m]
  Triple<S> size;   ///< m_k^2 + eta^2
  typename S::B pa, pb, inner, q, c, sum;
};
template <class S>
TALUS_SHAPES_INLINE Height<S> height(const DualForm<S>& body, const Triple<S>& m, typename S::B tau) {
  const auto half = S::set(0.5);
  Height<S> t;
  t.size = {m.x * m.x + tau, m.y * m.y + tau, m.z * m.z + tau};
  t.pa = power<S>(body.axes2.x * t.size.x, half * body.p2);
  t.pb = power<S>(body.axes2.y * t.size.y, half * body.p2);
  t.inner = t.pa + t.pb;
  t.q = power<S>(t.inner, body.p1 / body.p2);
  t.c = power<S>(body.axes2.z * t.size.z, half * body.p1);
  t.sum = t.q + t.c;
  t.h = power<S>(t.sum, S::set(1) / body.p1);
  return t;
}

/// m: unit vector in the body frame; eta > 0.
template <class S>
TALUS_SHAPES_INLINE Support<S> support(const DualForm<S>& body, const Triple<S>& m, typename S::B eta) {
  using B = typename S::B;
  const B one = S::set(1), half = S::set(0.5), tau = eta * eta;
  const auto [h, size, pa, pb, inner, q, c, sum] = height<S>(body, m, tau);
  const B alpha = pa / inner, beta = pb / inner, sigma = q / sum, wz = c / sum;
  const B wx = sigma * alpha, wy = sigma * beta;
  const Triple<S> inverse{one / size.x, one / size.y, one / size.z};
  const Triple<S> share{wx * inverse.x, wy * inverse.y, wz * inverse.z};
  const B g = (share.x + share.y) + share.z;
  Support<S> s;
  s.h = h;
  s.point = {h * (m.x * (share.x + tau * g)), h * (m.y * (share.y + tau * g)), h * (m.z * (share.z + tau * g))};
  s.ratio = {m.x * inverse.x, m.y * inverse.y, m.z * inverse.z};
  s.flat = {h * tau * share.x * inverse.x, h * tau * share.y * inverse.y, h * tau * share.z * inverse.z};
  s.round = h * tau * g;
  s.ring = h * (body.p1 - one) * sigma * wz;
  s.rim = h * (body.p2 - one) * sigma * alpha * beta;
  s.alpha = alpha;
  // d(share)/d(tau), through the logarithmic derivatives of the weights
  const B along = (alpha * inverse.x + beta * inverse.y) - inverse.z, across = inverse.x - inverse.y;
  const B ring = half * body.p1 * sigma * wz * along, rim = half * body.p2 * sigma * alpha * beta * across;
  const B two_eta_h = S::set(2) * eta * h, mean = half * g;
  s.drift = {two_eta_h * s.ratio.x * ((wx * mean - share.x) + (ring * alpha + rim)),
             two_eta_h * s.ratio.y * ((wy * mean - share.y) + (ring * beta - rim)),
             two_eta_h * s.ratio.z * ((wz * mean - share.z) - ring)};
  return s;
}

/// Radii of curvature as a bilinear form of the tangents u and v [m]: the second derivative of h along them.
template <class S>
TALUS_SHAPES_INLINE typename S::B radii(const Support<S>& s, const Triple<S>& u, const Triple<S>& v) {
  using B = typename S::B;
  const B beta = S::set(1) - s.alpha;
  const Triple<S> zu{s.ratio.x * u.x, s.ratio.y * u.y, s.ratio.z * u.z};
  const Triple<S> zv{s.ratio.x * v.x, s.ratio.y * v.y, s.ratio.z * v.z};
  const B ring_u = (s.alpha * zu.x + beta * zu.y) - zu.z, ring_v = (s.alpha * zv.x + beta * zv.y) - zv.z;
  const B flat = (s.flat.x * (u.x * v.x) + s.flat.y * (u.y * v.y)) + s.flat.z * (u.z * v.z);
  return ((s.ring * (ring_u * ring_v)) + s.rim * ((zu.x - zu.y) * (zv.x - zv.y))) + (flat + s.round * dot<S>(u, v));
}

/// Two unit vectors at right angles to n and to each other, without a branch (Duff et al. 2017).
template <class S>
struct Tangents {
  Triple<S> u, v;
};
template <class S>
TALUS_SHAPES_INLINE Tangents<S> tangents(const Triple<S>& n) {
  using B = typename S::B;
  const B s = S::copysign(S::set(1), n.z), a = S::set(-1) / (s + n.z), b = (n.x * n.y) * a;
  return {{S::set(1) + (s * n.x) * (n.x * a), s * b, S::set(0) - s * n.x}, {b, s + n.y * (n.y * a), S::set(0) - n.y}};
}

}  // namespace talus::shapes
