// Narrow phase of laws whose contacts hold beyond touch (JKR), and the carry-over of history columns that the plain
// narrow phase does not know. Instantiated by isa_*.cpp; called by scheduler/nodes/add_ons.cpp. Invariants: I3, I5 as
// in narrow.hpp. A pair attaches when it touches (d < r_i + r_j); one that was in contact at the previous step (its
// mask bit) stays so while (-delta)^3 <= 27 (pi w / (8 E*))^2 R*, which is -delta <= 3 a_c^2 / R* without a cube root.
#pragma once

#include "kernels/passes/narrow.hpp"

namespace talus::kernels {

/// Whether a pair that does not touch any more still hangs together.
template <class S>
bool neck_holds(const NarrowArgs& a, const AdhesiveArgs& q, std::int32_t i, std::int32_t j) {
  const double *p = a.p + 4L * i, *o = a.p + 4L * j;
  double d2 = 0, t[3];
  for (int c = 0; c < 3; ++c) {
    double x = p[c] - o[c];
    if (a.periodic != 0) x = x > a.half[c] ? x - a.period[c] : (x < -a.half[c] ? x + a.period[c] : x);
    t[c] = x;
  }
  d2 = (t[0] * t[0] + t[1] * t[1]) + t[2] * t[2];
  const double w = p[3] + o[3], gap = __builtin_sqrt(d2) - w;
  if (!(w > 0)) return false;  // a removed row
  const double reff = (p[3] * o[3]) / w;
  const double range = q.range[q.material == nullptr ? 0 : q.material[i] * q.materials + q.material[j]];
  return (gap * gap) * gap <= range * reff;
}

template <class S>
void narrow_adhesive(NarrowArgs& args, const AdhesiveArgs& adhesive) {
  using B = typename S::B;
  const NarrowArgs a = args;
  const MinimumImage<S> image(a.half, a.period);
  std::int64_t contacts = 0, s = 0;
  for (int section = 0; section < 3; ++section) {
    for (; s < a.end[section]; s += 8) {
      unsigned bits = 0;
      for (int k = 0; k < 8; k += S::W) {
        B d[4];
        S::pair_rows4(a.p, a.pi + s + k, a.pj + s + k, d);
        image.apply(d);
        const B d2 = (d[0] * d[0] + d[1] * d[1]) + d[2] * d[2], w2 = d[3] * d[3];
        bits |= S::bits(S::lt(d2, w2)) << k;
      }
      for (unsigned left = a.mask[s >> 3] & ~bits; left != 0; left &= left - 1) {
        const int k = __builtin_ctz(left);
        if (neck_holds<S>(a, adhesive, a.pi[s + k], a.pj[s + k])) bits |= 1U << k;
      }
      for (unsigned m = bits; m != 0; m &= m - 1) {
        const int k = __builtin_ctz(m);
        a.ci[contacts] = a.pi[s + k];
        a.cj[contacts++] = a.pj[s + k];
      }
      a.mask[s >> 3] = static_cast<std::uint8_t>(bits);
    }
    args.contact_end[section] = contacts;
  }
  args.run_count = 0;
}

template <class S>
void carry(const CarryArgs& a) {
  for (int c = 0; c < a.columns; ++c) {
    const double* from = a.from[c];
    double* to = a.to[c];
    for (std::int64_t g = 0; g < a.slots / 8; ++g) {
      const unsigned was = a.before[g], is = a.now[g];
      if (was == is)  // nearly always; whole vectors, what is beyond the group is overwritten by the next
        for (int k = 0; k < 8; k += S::W) S::store(to + k, S::load(from + k));
      else
        carry_changed<S>(was, is, from, to);
      from += __builtin_popcount(was);
      to += __builtin_popcount(is);
    }
  }
}

}  // namespace talus::kernels
