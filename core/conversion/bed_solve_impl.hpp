// Second half of bed_step.hpp: conduction, one tridiagonal system for all shells.
#pragma once

namespace talus::conversion::bed {

template <class S>
void Step<S>::solve() {
  const B one = S::set(1), zero = S::set(0), boiling = S::set(m.boiling);
  const double* debt = cell(place_.debt);
  B upper = zero, right = zero, below = zero;
  for (int i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    const B above = last ? loss_ : ld(w_.conductance, i + 1), own = ld(w_.capacity, i) - ld(w_.slope, i);
    B lower = below;
    if (m.convects != 0 && i > 0) lower = lower + ld(w_.flow, i - 1);
    if (last) put(k_out_capacity, own + above + below * (one - upper));
    B diagonal = own + lower + above, next = last ? zero : above;
    B known = own * ld(T_, i) + ld(debt, i) + ld(w_.heat, i);
    if (last) known = known + gain_;
    if (boils_) {
      const auto stays = S::gt(ld(w_.plateau, i), zero);
      known = S::select(stays, boiling, known - ld(w_.sink, i));
      diagonal = S::select(stays, one, diagonal);
      lower = S::select(stays, zero, lower);
      next = S::select(stays, zero, next);
    }
    const B per = one / (diagonal - lower * upper);
    right = (known + lower * right) * per;
    upper = next * per;
    st(w_.next, i, right);
    st(w_.upper, i, upper);
    below = above;
  }
  B above = right;
  for (int i = n - 1; i-- > 0;) {
    above = ld(w_.next, i) + ld(w_.upper, i) * above;
    st(w_.next, i, above);
  }
  heat_in_ = gain_ - loss_ * right;
  put(k_out_heat_in, heat_in_);
  const B s = surface_gain_ + surface_slope_ * right;
  surface_ = most<S>(s, one);
  put(k_out_contact, dt_ * (in(k_in_contact_heat) + in(k_in_flow)-in(k_in_contact)*s));
  put(k_out_outside, most<S>((around_gain_ + inner_ * right) / around_loss_, one));
}

}  // namespace talus::conversion::bed
