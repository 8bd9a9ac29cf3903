// Newton's method for the overlap of two superquadrics, delta = min over unit n of h_i(n) + h_j(-n) - n . d, for any
// value type of lane.hpp: a lane is a pair, lanes that are done keep their values. Who calls it: pair_contact.cpp (one
// pair, watched by the safe method), kernels/bodies (batches). Invariants: I4; what a lane gets does not depend on its
// neighbours.
//
// Unknown: n on the sphere, in the frame of body i. Residual: the tangential part of x_i - x_j - d, where x_i and x_j
// are the points with the normals n and -n. Matrix: radii of curvature of both bodies less delta. The path: eta falls
// from its start to k_eta, and each step aims at the solution for the next eta (Newton on both, the "drift" below).
#pragma once

#include "core/shapes/support.hpp"

namespace talus::shapes {

/// A pair in the frame of body i: d is the centre of j seen from i [m], rows of turn are the axes of j.
template <class S>
struct PairForm {
  DualForm<S> i, j;
  Triple<S> turn[3];
  Triple<S> d;
  typename S::B size;  ///< length that tolerances are relative to [m]
};

template <class S>
struct PairState {
  Triple<S> n;  ///< unit, from i to j
  typename S::B eta;
  typename S::B delta;           ///< overlap [m]; negative: apart by so much
  Triple<S> xi;                  ///< point of i, made consistent with that of j: xi - xj = delta n [m]
  typename S::B residual, step;  ///< of the last evaluation [size], [rad]
  typename S::B steps;           ///< iterations that the lane used
  typename S::B range;           ///< a lane whose bodies are found farther apart than this is done [m]
  typename S::B care;            ///< in (0, 1]: how near the lane keeps to the path
  typename S::M done;
};

/// Residual [size] and step [rad] below which a lane is done. Near the middle of a flat face the residual cannot be
/// resolved better than this; the overlap depends on its square.
inline constexpr double k_residual = 1e-7, k_step = 1e-9, k_residual_loose = 1e-10;
/// Two ellipsoids have no flat faces: what a last step of this size leaves behind is its square.
inline constexpr double k_step_smooth = 1e-6;

/// Rounding at which a step begins that knows the normal of the last one.
inline constexpr double k_warm_eta = 1e-3;

template <class S>
TALUS_SHAPES_INLINE Triple<S> to_j(const PairForm<S>& p, const Triple<S>& v) {
  return {dot<S>(p.turn[0], v), dot<S>(p.turn[1], v), dot<S>(p.turn[2], v)};
}
template <class S>
TALUS_SHAPES_INLINE Triple<S> from_j(const PairForm<S>& p, const Triple<S>& v) {
  return {(p.turn[0].x * v.x + p.turn[1].x * v.y) + p.turn[2].x * v.z,
          (p.turn[0].y * v.x + p.turn[1].y * v.y) + p.turn[2].y * v.z,
          (p.turn[0].z * v.x + p.turn[1].z * v.y) + p.turn[2].z * v.z};
}
template <class S>
TALUS_SHAPES_INLINE Triple<S> unit(const Triple<S>& v) {
  const auto s = S::set(1) / S::sqrt(dot<S>(v, v));
  return {s * v.x, s * v.y, s * v.z};
}
template <class S>
TALUS_SHAPES_INLINE Triple<S> choose(typename S::M m, const Triple<S>& a, const Triple<S>& b) {
  return {S::select(m, a.x, b.x), S::select(m, a.y, b.y), S::select(m, a.z, b.z)};
}

/// What one evaluation of a pair gives at (n, eta), in the tangents of n.
template <class S>
struct PairPoint {
  typename S::B delta, g1, g2, k11, k12, k22, drift1, drift2;
  typename S::B i11, i12, i22;  ///< the share of body i in the radii
  Triple<S> xi;
  Tangents<S> t;
};

template <class S>
TALUS_SHAPES_INLINE PairPoint<S> evaluate(const PairForm<S>& p, const Triple<S>& n, typename S::B eta) {
  using B = typename S::B;
  const B zero = S::set(0);
  PairPoint<S> e;
  e.t = tangents<S>(n);
  const Triple<S> m = to_j<S>(p, n), mj{zero - m.x, zero - m.y, zero - m.z};
  const Support<S> si = support<S>(p.i, n, eta), sj = support<S>(p.j, mj, eta);
  const Triple<S> xj = from_j<S>(p, sj.point), dj = from_j<S>(p, sj.drift);
  e.delta = (si.h + sj.h) - dot<S>(n, p.d);
  e.xi = si.point;
  const Triple<S> gap{(si.point.x - xj.x) - p.d.x, (si.point.y - xj.y) - p.d.y, (si.point.z - xj.z) - p.d.z};
  const Triple<S> drift{si.drift.x - dj.x, si.drift.y - dj.y, si.drift.z - dj.z};
  e.g1 = dot<S>(gap, e.t.u);
  e.g2 = dot<S>(gap, e.t.v);
  e.drift1 = dot<S>(drift, e.t.u);
  e.drift2 = dot<S>(drift, e.t.v);
  const Triple<S> uj = to_j<S>(p, e.t.u), vj = to_j<S>(p, e.t.v);
  e.i11 = radii<S>(si, e.t.u, e.t.u);
  e.i12 = radii<S>(si, e.t.u, e.t.v);
  e.i22 = radii<S>(si, e.t.v, e.t.v);
  e.k11 = (e.i11 + radii<S>(sj, uj, uj)) - e.delta;
  e.k12 = e.i12 + radii<S>(sj, uj, vj);
  e.k22 = (e.i22 + radii<S>(sj, vj, vj)) - e.delta;
  return e;
}

template <class S>
struct Step {
  typename S::B t1, t2;
};
/// Solves (K + shift) t = -b. The shift makes K positive definite where the overlap is deeper than the bodies are
/// round.
template <class S>
TALUS_SHAPES_INLINE Step<S> newton_step(const PairPoint<S>& e, typename S::B b1, typename S::B b2,
                                        typename S::B least) {
  using B = typename S::B;
  const B half = S::set(0.5), zero = S::set(0);
  const B mean = half * (e.k11 + e.k22), diff = half * (e.k11 - e.k22);
  const B spread = S::sqrt(diff * diff + e.k12 * e.k12);
  const B low = mean - spread;  // the smaller eigenvalue, with an error of some 1e-16 of the larger
  const B shift =
      S::select(S::lt(mean + mean, zero), (least - low),
                S::select(S::lt(e.k11 * e.k22 - e.k12 * e.k12, least * (mean + spread)), S::abs(least - low), zero));
  const B a = e.k11 + shift, c = e.k22 + shift;
  const B det = a * c - e.k12 * e.k12;
  return {(e.k12 * b2 - c * b1) / det, (e.k12 * b1 - a * b2) / det};
}

/// 1 where both bodies are ellipsoids or balls, else 0.
template <class S>
TALUS_SHAPES_INLINE typename S::B smoothness(const PairForm<S>& p) {
  const auto two = S::set(2), one = S::set(1), zero = S::set(0);
  const auto off = (S::abs(p.i.p1 - two) + S::abs(p.i.p2 - two)) + (S::abs(p.j.p1 - two) + S::abs(p.j.p2 - two));
  return S::select(S::gt(off, zero), zero, one);
}

/// How far eta falls in the next step, as a factor: the nearer to the path, the farther; to its end where it has no
/// influence.
template <class S>
TALUS_SHAPES_INLINE typename S::B fall_factor(typename S::B eta, typename S::B residual, typename S::B drift) {
  using B = typename S::B;
  B factor = S::select(S::lt(residual, S::set(0.02)), S::set(0.3), S::set(1));
  factor = S::select(S::lt(residual, S::set(0.01)), S::set(0.2), factor);
  factor = S::select(S::lt(residual, S::set(0.002)), S::set(0.05), factor);
  factor = S::select(S::lt(drift * eta + residual, S::set(0.01)), S::set(0.01), factor);
  return S::select(S::lt(drift * eta + residual, S::set(1e-5)), S::set(0), factor);
}

/// Where a lane last stood on the path, and the way that it took from there.
template <class S>
struct PathPoint {
  Triple<S> n;
  typename S::B eta, residual;
  Step<S> newton, drift;              ///< to the solution at this eta; per unit of eta
  typename S::B factor, share, care;  ///< of eta, of the Newton step
};

/// The direction that the way from q leads to, and its eta.
template <class S>
TALUS_SHAPES_INLINE Triple<S> ahead(const PathPoint<S>& q, typename S::B& eta, typename S::B& length) {
  using B = typename S::B;
  const B end = S::set(k_eta), aim = q.factor * q.eta;
  eta = S::select(S::lt(aim, end), end, aim);
  const B fall = eta - q.eta;
  const B t1 = q.share * q.newton.t1 + fall * q.drift.t1, t2 = q.share * q.newton.t2 + fall * q.drift.t2;
  length = S::sqrt(t1 * t1 + t2 * t2);
  const B cut = S::select(S::gt(length, S::set(0.5)), S::set(0.5) / length, S::set(1));
  const Tangents<S> t = tangents<S>(q.n);
  const B a = cut * t1, b = cut * t2;
  return unit<S>({q.n.x + (a * t.u.x + b * t.v.x), q.n.y + (a * t.u.y + b * t.v.y), q.n.z + (a * t.u.z + b * t.v.z)});
}

template <class S>
TALUS_SHAPES_INLINE PathPoint<S> start_of_path(const PairState<S>& s) {
  PathPoint<S> q;
  q.n = s.n;
  q.eta = s.eta;
  q.residual = S::set(1e300);
  q.newton = q.drift = {S::set(0), S::set(0)};
  q.factor = q.share = S::set(1);
  q.care = s.care;
  return q;
}

/// Takes over what an evaluation found, in the lanes that work.
template <class S>
TALUS_SHAPES_INLINE void take_point(PairState<S>& s, const PairPoint<S>& e, const Step<S>& newton,
                                    typename S::B residual, typename S::B length, typename S::B fine,
                                    typename S::B working) {
  using B = typename S::B;
  const auto work = S::gt(working, S::set(0.5));
  // The point of i moves with the part of the step that its own curvature takes.
  const B m1 = e.i11 * newton.t1 + e.i12 * newton.t2, m2 = e.i12 * newton.t1 + e.i22 * newton.t2;
  const B gain = S::set(0.5) * (e.g1 * newton.t1 + e.g2 * newton.t2);
  const B small = S::select(S::lt(length, fine), gain, S::set(0));
  s.delta = S::select(work, e.delta + small, s.delta);
  s.xi = choose<S>(work,
                   {e.xi.x + (m1 * e.t.u.x + m2 * e.t.v.x), e.xi.y + (m1 * e.t.u.y + m2 * e.t.v.y),
                    e.xi.z + (m1 * e.t.u.z + m2 * e.t.v.z)},
                   s.xi);
  s.residual = S::select(work, residual, s.residual);
  s.step = S::select(work, length, s.step);
  s.steps = s.steps + working;
}

/// Iterates from (s.n, s.eta) until every lane is done or `most` evaluations are spent; lanes of s.done that are set on
/// entry stay as they are. A step after which the residual is too large is taken back and made shorter.
template <class S>
TALUS_SHAPES_INLINE void iterate(const PairForm<S>& p, PairState<S>& s, int most) {
  using B = typename S::B;
  const B one = S::set(1), zero = S::set(0), end = S::set(k_eta);
  PathPoint<S> q = start_of_path<S>(s);
  const auto smooth = S::gt(smoothness<S>(p), S::set(0.5));
  const B fine = S::select(smooth, S::set(k_step_smooth), S::set(k_step)),
          fit = S::select(smooth, one, S::set(k_residual));
  for (int k = 0; k < most; ++k) {
    const PairPoint<S> e = evaluate<S>(p, s.n, s.eta);
    const B residual = S::sqrt(e.g1 * e.g1 + e.g2 * e.g2) / p.size;
    const B drift = S::sqrt(e.drift1 * e.drift1 + e.drift2 * e.drift2) / p.size;
    const B least = S::set(1e-6) * p.size;
    const Step<S> newton = newton_step<S>(e, e.g1, e.g2, least), along = newton_step<S>(e, e.drift1, e.drift2, least);
    const B length = S::sqrt(newton.t1 * newton.t1 + newton.t2 * newton.t2);
    const B working = S::select(s.done, zero, one);
    take_point<S>(s, e, newton, residual, length, fine, working);
    const B near = S::select(S::lt(length, fine), fit, S::set(k_residual_loose));
    const B open = S::select(S::lt(residual, near), S::select(S::lt(length, S::set(10) * fine), zero, one), one);
    // The rounded bodies hold the exact ones: apart along some n, they are apart.
    const auto apart = S::lt(e.delta, zero - s.range);
    const B stays = working * S::select(apart, zero, S::select(S::gt(s.eta, end), one, open));
    // Accept: on the path, or nearer to it than before.
    const B reach = q.care * S::select(S::lt(s.eta, S::set(0.05) * q.eta), S::set(0.03),
                                       S::select(S::gt(s.eta, q.eta), S::set(0.15), S::set(0.05)));
    const B bound = S::select(S::gt(reach, S::set(0.8) * q.residual), reach, S::set(0.8) * q.residual);
    const auto good = S::lt(residual, bound);
    // Otherwise: a smaller fall of eta, then back to a rounder pair and with more care from there.
    const auto turn = S::lt(q.factor, S::set(0.7)), first = S::lt(q.factor, S::set(1.5));
    const B floor = S::select(S::lt(q.factor, end / q.eta), end / q.eta, q.factor);
    const B back = S::select(S::lt(q.eta, S::set(0.5)), S::set(4), S::set(2));
    const B factor =
        S::select(good, fall_factor<S>(s.eta, residual / q.care, drift), S::select(turn, S::sqrt(floor), back));
    const B share = S::select(good, one, S::select(turn, q.share, S::select(first, one, S::set(0.4) * q.share)));
    const B less = S::select(S::gt(q.care, S::set(0.05)), S::set(0.5) * q.care, q.care);
    q.care = S::select(good, q.care, S::select(turn, q.care, S::select(first, less, q.care)));
    q.n = choose<S>(good, s.n, q.n);
    q.eta = S::select(good, s.eta, q.eta);
    q.residual = S::select(good, residual, q.residual);
    q.newton = {S::select(good, newton.t1, q.newton.t1), S::select(good, newton.t2, q.newton.t2)};
    q.drift = {S::select(good, along.t1, q.drift.t1), S::select(good, along.t2, q.drift.t2)};
    q.factor = factor;
    q.share = share;
    B eta, way;
    Triple<S> n = ahead<S>(q, eta, way);
    const auto goes = S::gt(stays, S::set(0.5));
    const auto last = S::gt(working - stays, S::set(0.5));  // a lane that is done takes its last, tiny step
    const Triple<S> close = unit<S>({s.n.x + (newton.t1 * e.t.u.x + newton.t2 * e.t.v.x),
                                     s.n.y + (newton.t1 * e.t.u.y + newton.t2 * e.t.v.y),
                                     s.n.z + (newton.t1 * e.t.u.z + newton.t2 * e.t.v.z)});
    const auto ends = S::lt(S::select(apart, one, one - S::select(last, one, zero)), S::set(0.5));
    s.n = choose<S>(goes, n, choose<S>(ends, close, s.n));
    s.eta = S::select(goes, eta, s.eta);
    s.done = S::lt(stays, S::set(0.5));
    if (!S::any(S::gt(stays, S::set(0.5)))) break;
  }
}

}  // namespace talus::shapes
