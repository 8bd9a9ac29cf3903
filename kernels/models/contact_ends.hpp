// The steps in which a contact of the linear law begins or ends: what they count. They are a few of a hundred, but as
// many operations again: a block's other contacts take none of these.
#pragma once

#include "kernels/models/contact_motion.hpp"

namespace talus::kernels {

/// The step in which a contact begins or ends, see LINEAR.md.
template <class S>
struct ContactEnd {
  typename S::M enters, leaves;  ///< touches within the step; parts before the next one
  typename S::B counted;         ///< 0: the step before has counted the contact to its end
  typename S::B way, u, q;       ///< |v| dt [m]; time in contact on this side of n over dt, and with the half step
  typename S::B inverse;         ///< 1/u

  /// A pair that seems to be just in touch at the next step is taken to part as well: its end is counted now, up to u,
  /// and not in the next step, which gives the same sum. Misjudged the other way round, the end would be lost.
  static constexpr double k_early = 17.0 / 16, k_longest = 1.5;

  TALUS_INLINE void set(typename S::B delta, typename S::B vn, typename S::B step) {
    const auto zero = S::set(0.0);
    enters = S::lt(delta, S::select(S::lt(vn, zero), step, zero));
    leaves = S::lt(delta, S::select(S::gt(vn, zero), step, zero));
    counted = S::set(1.0);
    move(delta, step);
  }
  /// With memory. fresh: lanes without a prediction, which a parting contact leaves behind; ahead: v(n+1/2) dt.
  TALUS_INLINE void set(typename S::B delta, typename S::B vn, typename S::B step, typename S::B ahead,
                        typename S::B arc, typename S::M fresh, int start) {
    set(delta, vn, step);
    const auto zero = S::set(0.0), one = S::set(1.0);
    const auto parting = S::gt(vn, zero);
    // the pair may still touch after the step that has counted its end
    if (start == 0) counted = S::select(fresh, S::select(leaves, zero, one), one);
    enters = S::lt(delta, S::select(fresh, S::select(S::lt(vn, zero), step + arc, zero), zero));
    const auto until = S::select(S::gt(counted, zero), S::set(k_early) * (ahead + arc), step);
    leaves = S::lt(delta, S::select(parting, until, zero));
    move(delta, S::select(parting, ahead, step) + arc);
  }
  TALUS_INLINE void move(typename S::B delta, typename S::B to) {
    const auto least = S::set(1e-9), shortest = S::set(1 / k_longest) * delta;
    way = S::select(S::gt(to, shortest), to, shortest);
    u = delta / way;
    u = S::select(S::gt(u, least), u, least);
    q = S::set(0.5) + u;
    inverse = S::set(1.0) / u;
  }
  /// Where it applies: a, else b.
  TALUS_INLINE typename S::B select(typename S::B a, typename S::B b) const {
    return S::select(enters, a, S::select(leaves, a, b));
  }
};

/// Steps before the end, and after the touch without early_slip(), in which a contact is set aside. More than k_early
/// by what its own spring adds to the speed in that time: from nine steps per contact on no end of a free impact is
/// missed. One that is missed ends as without onset_correction.
inline constexpr double k_near_steps = 1.25;

/// Steps after the touch in which early_slip() looks.
inline constexpr double k_early_steps = 3;

/// A contact with a tangential dashpot begins sliding, for there is no limit yet, and sticks as soon as the limit has
/// outgrown the dashpot, possibly within its first steps. What it slipped by then goes off the spring h and onto the
/// trial force g: the excess e = |g| - L relaxes with gamma_t m_eff/k_t towards a falling line, the slip is the
/// integral of e/(gamma_t m_eff) to its zero. now, before: L at n and at n-1, or at the touch. With e0 the excess at
/// the beginning (velocity and force of that time), e1 < 0 that at the end without slip and a = gamma_t m_eff/k_t (e0 -
/// e1)/slid:  slip = e0/k_t (1 - ln(1 + y)/y), y = e0/a; the logarithm as y (6 + 3 y)/(6 + 6 y + y^2).
template <class S, class Factors>
TALUS_INLINE void early_slip(const Factors& f, typename S::B meff, typename S::M early, typename S::B slid,
                             typename S::B now, typename S::B before, const typename S::B* t, typename S::B kt,
                             typename S::B* h, typename S::B* g) {
  using B = typename S::B;
  const B zero = S::set(0.0), one = S::set(1.0), six = S::set(6.0);
  const B ct = f.gt * meff;
  B old[3];
  for (int p = 0; p < 3; ++p) old[p] = kt * (h[p] - t[p] * slid) + ct * t[p];
  const B was = S::sqrt((old[0] * old[0] + old[1] * old[1]) + old[2] * old[2]);
  const B size = S::sqrt((g[0] * g[0] + g[1] * g[1]) + g[2] * g[2]);
  const B kick = f.grow - one;
  const B e0 = (was - before) + S::select(S::lt(kick, one), kick, one) * before, drop = e0 + (now - size);
  const B a = (ct * f.soft) * (drop / slid);
  const B slip = (f.soft * (e0 * e0)) * ((S::set(3.0) * a + e0) / (six * (a * (a + e0)) + e0 * e0));
  const auto sticks = S::lt(size, S::select(early, now, zero));
  const B off =
      S::select(sticks, S::select(S::gt(e0, zero), S::select(S::gt(ct * was, zero), slip / was, zero), zero), zero);
  const auto slips = S::gt(off, zero);  // the other lanes keep their bits, the sign of a zero too
  for (int p = 0; p < 3; ++p) {
    h[p] = S::select(slips, h[p] - off * old[p], h[p]);
    g[p] = S::select(slips, g[p] + (f.spring_t * off) * old[p], g[p]);
  }
}

/// Copies of contacts that begin or end. A contact is set aside or not by its own numbers, so that its bits depend on
/// no neighbour. Contacts k + q of b where bit q of lanes is set are added to `to`, which goes on in its next where it
/// is full; `first` is added to their place.
template <bool Friction, bool Multi>
TALUS_INLINE void set_aside(LateContacts*& to, const Block& b, int k, unsigned lanes, bool recall, std::int32_t first) {
  constexpr int history = Friction ? 3 : 0;
  for (; lanes != 0; lanes &= lanes - 1) {
    const int from = k + __builtin_ctz(lanes);
    if (from >= b.n) return;
    if (to->n == k_block) to = to->next;
    const int n = to->n++;
    to->at[n] = first + from;
    double* in = to->in[n];
    in[0] = b.x[from];
    in[1] = b.y[from];
    in[2] = b.z[from];
    in[3] = b.w[from];
    for (int c = 0; c < (Friction ? 4 : 3); ++c) in[4 + c] = b.g[c][from];
    for (int c = 0; c < (Friction ? 8 : 4); ++c) in[8 + c] = b.r[c][from];
    for (int c = 0; c < history; ++c) in[16 + c] = b.h_in[c][from];
    if (recall) in[16 + history] = b.h_in[history][from];
    if constexpr (Multi) to->pair[n] = b.pair[from];
  }
}

/// What has been set aside as a block, padded to whole vectors.
template <class S>
TALUS_INLINE Block late_block(LateContacts& of) {
  const auto fill = [&](auto& columns, int from) {
    for (auto& c : columns) {
      for (int q = 0; q < of.n; ++q) c[q] = of.in[q][from];
      S::store(c + of.n, S::set(0.0));
      ++from;
    }
  };
  fill(of.x, 0);
  fill(of.g, 4);
  fill(of.r, 8);
  fill(of.h, 16);
  for (int q = 0; q < S::W; ++q) of.pair[of.n + q] = 0;
  Block s{};
  s.n = of.n;
  s.x = of.x[0];
  s.y = of.x[1];
  s.z = of.x[2];
  s.w = of.x[3];
  s.g = of.g;
  s.r = of.r;
  for (int c = 0; c < 4; ++c) s.h_in[c] = s.h[c] = of.h[c];
  s.pair = of.pair;
  s.e = of.e;
  s.t = of.t;
  s.slid = of.slid;
  return s;
}

/// The finished contacts return to their block; their force rows where the block wants them, see Block::late.
template <bool Friction, bool Energy, bool Trial>
TALUS_INLINE void put_back(const LateContacts& of, const Block& b, bool recall) {
  constexpr int history = Friction ? 3 : 0, rows = Friction ? 8 : 4;
  LateContacts* late = b.late;
  for (int q = 0; q < of.n; ++q) {
    const int to = of.at[q];
    if (late != nullptr) {
      if (late->n == k_block) late = late->next;
      late->at[late->n] = b.first + to;
      for (int c = 0; c < rows; ++c) late->r[c][late->n] = of.r[c][q];
      ++late->n;
    }
    for (int c = 0; c < rows; ++c) b.r[c][to] = late != nullptr ? 0.0 : of.r[c][q];
    for (int c = 0; c < history; ++c) b.h[c][to] = of.h[c][q];
    if (recall) b.h[history][to] = of.h[history][q];
    for (int c = 0; Energy && c < 3; ++c) b.e[c][to] = of.e[c][q];
    for (int c = 0; Trial && c < 3; ++c) b.t[c][to] = of.t[c][q];
    if (Friction && b.slid != nullptr) b.slid[to] = of.slid[q];
  }
}

}  // namespace talus::kernels
