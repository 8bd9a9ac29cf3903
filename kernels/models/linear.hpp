// Linear spring-dashpot with Coulomb friction and tangential history (Cundall & Strack; LAMMPS gran/hooke/history).
//   F_n = k_n delta - gamma_n m_eff v_n,   F_t = -(k_t xi + gamma_t m_eff v_t),   |F_t| <= L = mu k_n delta
// What the dashpot sees, what the first and last step of a contact count, and how the spring creeps while the contact
// slides is derived in LINEAR.md.
// History: with friction 3 columns, the tangential spring xi [m], oriented i - j; centred and with ends or damped:
// one more, the predicted velocity [m/s].
// Reads kn, kt [N/m], gn, gt [1/s] (or 2 beta [-] with by_restitution), mu.
#pragma once

#include "kernels/models/linear_contacts.hpp"

namespace talus::kernels {

/// What has been set aside. Not inlined: its registers would be taken from the other contacts.
template <class S, bool Friction, bool Multi, bool Energy, bool Trial>
[[gnu::noinline]] double linear_ends(LateContacts& of, const LawArgs& a) {
  const LinearBlock<S, Friction, Multi> in(late_block<S>(of), a);
  LateContacts* none = nullptr;
  for (int k = 0; k < of.n; k += S::W) linear_contacts<S, Friction, Multi, Energy, Trial, true>(in, k, none, 0);
  double back[S::W];
  S::store(back, in.shared.back);
  return back[0];
}

/// Returns 1/(k_t shrink) of one material pair.
template <class S, bool Friction, bool Multi, bool Energy, bool Trial>
double linear_force(const Block& b, const LawArgs& a) {
  const LinearBlock<S, Friction, Multi> in(b, a);
  LateContacts own;  // its columns are written as far as they are read
  own.n = 0;
  const bool leaves = Trial && b.late != nullptr;
  LateContacts* aside = leaves ? b.late : &own;
  const std::int32_t first = leaves ? b.first : 0;
  for (int k = 0; k < in.b.n; k += S::W) linear_contacts<S, Friction, Multi, Energy, Trial, false>(in, k, aside, first);
  if (own.n > 0) {
    linear_ends<S, Friction, Multi, Energy, Trial>(own, a);
    put_back<Friction, Energy, Trial>(own, b, a.recall != 0);
  }
  if constexpr (!Trial) return 0;
  double back[S::W];
  S::store(back, in.shared.back);
  return back[0];
}

template <class S, bool Friction, bool Multi, bool Energy>
void force(Linear, Block& b, const LawArgs& a) {
  linear_force<S, Friction, Multi, Energy, false>(b, a);
}

/// KernelTable::trial: friction, one material pair, no energies.
template <class S>
double linear_trial(Block& b, const LawArgs& a) {
  return linear_force<S, true, false, false, true>(b, a);
}

/// KernelTable::late.
template <class S>
double linear_late(LateContacts& of, const LawArgs& a) {
  return linear_ends<S, true, false, false, true>(of, a);
}

/// KernelTable::scatter_limited.
template <class S>
void scatter_limited(const LimitArgs& args) {
  using B = typename S::B;
  const LimitArgs a = args;
  const B zero = S::set(0.0), one = S::set(1.0), back = S::set(a.back);
  for (int k = 0; k < a.to.n; k += S::W) {
    const B g[3] = {S::load(a.to.r[0] + k), S::load(a.to.r[1] + k), S::load(a.to.r[2] + k)};
    const B n[3] = {S::load(a.to.r[4] + k), S::load(a.to.r[5] + k), S::load(a.to.r[6] + k)};
    const B fn = S::load(a.to.r[7] + k), lever = a.lever != nullptr ? S::load(a.lever + k) : one;
    CoulombLimit<S> coulomb;
    coulomb.set(g, S::load(a.t[0] + k), S::load(a.t[1] + k), S::load(a.t[2] + k), back);
    B r[8], f[3];
    for (int p = 0; p < 3; ++p) {
      const B h = S::load(a.h[p] + k);
      S::store(a.h[p] + k, S::select(coulomb.slides, coulomb.spring * h - coulomb.pull * g[p], h));
      f[p] = g[p] * coulomb.scale;
      r[p] = fn * n[p] + f[p];
    }
    r[3] = S::load(a.to.r[3] + k);
    r[4] = lever * (n[2] * f[1] - n[1] * f[2]);
    r[5] = lever * (n[0] * f[2] - n[2] * f[0]);
    r[6] = lever * (n[1] * f[0] - n[0] * f[1]);
    r[7] = zero;
    scatter_group<S, true>(a.to, k, r);
  }
}

}  // namespace talus::kernels
