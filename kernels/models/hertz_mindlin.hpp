// Hertz-Mindlin with the exact restitution damping (Antypov & Elliott 2011; VERIFICATION 3.1).
//   S_n = 4/3 E* a, S_t = 8 G* a, a = sqrt(R* delta)
//   F_n = S_n delta - alpha sqrt(m_eff S_n) v_n,  alpha = -sqrt(5) ln e / sqrt(pi^2 + ln^2 e)
//   F_t: stored force, dF = -S_t v_t dt, rescaled by a/a_prev when the contact radius shrinks (no energy from closed
//   loops); S_t is that of the mean of a_prev and a while the radius grows, which makes the integral second order, and
//   that of a while it shrinks (of the mean, rescaled from there to a: the same); dashpot gamma_t v_t, gamma_t =
//   sqrt(2/3) alpha sqrt(m_eff S_t); |F_t| <= mu S_n delta (JKR: F + 3 pi w R* in place of S_n delta). Coulomb's limit
//   and sliding ("series") as in the linear law (linear.hpp), with gamma_t m_eff -> gamma_t and k_t -> S_t; the dashpot
//   of this law is a total derivative of the overlap, too.
// Onset correction: with delta = u |v_n| dt in the first step and in the last, the dashpot, which starts as
// delta^(1/4), has the weight (1/2 + u)^(5/4)/(5/4 u^(1/4)): its impulse between the touch and n+1/2. hertz_tsuji
// differs only in alpha (the polynomial of Tsuji et al.), chosen at set-up. History: with friction 4 columns, the
// elastic tangential force on i [N] and the last contact radius [m]; with partial slip three more, see
// partial_slip.hpp; centred and damped: one more, see dashpot_velocity() of the linear law. Reads kn = 4/3 E* [Pa],
// kt = 8 G* [Pa], gn = alpha [-], gt = sqrt(2/3) alpha [-], mu; wants R*.
#pragma once

#include "kernels/models/hertz_tangential.hpp"

namespace talus::kernels {

struct HertzMindlin {
  static constexpr const char* name = "hertz_mindlin";
  static constexpr int history = 4;
  static constexpr bool wants_reff = true;
};

struct PartialSlip {
  static constexpr const char* name = "partial_slip";
  static constexpr int history = 7;
  static constexpr bool wants_reff = true;
};

/// S::W contacts from k on.
template <class S, class Form>
TALUS_INLINE void hertz_contacts(const Block& b, const LawArgs& a, const Coefficients<S, Form::multi>& c, int k) {
  using B = typename S::B;
  HertzContact<S, Form> q(b, a, c, k);
  q.load();
  q.spring();
  q.find_edges();
  q.damp();
  B f[3] = {q.fn * q.n[0], q.fn * q.n[1], q.fn * q.n[2]};
  B mid = q.one;  // dashpot at n-1/2 over that at n
  if constexpr (Form::energy) {
    if constexpr (Form::adhesive)
      mid = q.adhesive_ledger();
    else
      mid = q.normal_ledger();
    S::store(b.e[2] + k, q.zero);
  }
  if constexpr (Form::friction) {
    if (b.slid != nullptr) S::store(b.slid + k, q.turned);
    q.load_history();
    q.find_limit();
    if constexpr (Form::slip)
      q.move_rings(mid);
    else
      q.move_spring(mid);
    for (int p = 0; p < 3; ++p) f[p] = f[p] + q.g[p];
    q.store_tangential();
  }
  for (int p = 0; p < 3; ++p) S::store(b.r[p] + k, f[p]);
  S::store(b.r[3] + k, S::set(1.5) * q.sn);
}

template <class S, bool Friction, bool Multi, bool Energy, bool Adhesive, bool Slip = false>
void hertz_force(Block& block, const LawArgs& args) {
  const LawArgs a = args;  // local copies: the stores cannot alias them
  const Block b = block;
  Coefficients<S, Multi> c;
  if constexpr (!Multi) c.load(b, a, 0);
  for (int k = 0; k < b.n; k += S::W) {
    if constexpr (Multi) c.load(b, a, k);
    hertz_contacts<S, HertzForm<Friction, Multi, Energy, Adhesive, Slip>>(b, a, c, k);
  }
}

template <class S, bool Friction, bool Multi, bool Energy>
void force(HertzMindlin, Block& b, const LawArgs& a) {
  hertz_force<S, Friction, Multi, Energy, false>(b, a);
}

template <class S, bool Friction, bool Multi, bool Energy>
void force(PartialSlip, Block& b, const LawArgs& a) {
  hertz_force<S, Friction, Multi, Energy, false, true>(b, a);
}

struct Jkr {
  static constexpr const char* name = "jkr";
  static constexpr int history = 4;
  static constexpr bool wants_reff = true;
};

template <class S, bool Friction, bool Multi, bool Energy>
void force(Jkr, Block& b, const LawArgs& a) {
  hertz_force<S, Friction, Multi, Energy, true>(b, a);
}

}  // namespace talus::kernels
