// The body of pair_batch.hpp for one value type. Included by kernels/isa/bodies_*.cpp only.
#pragma once

#include "core/shapes/pair_newton.hpp"
#include "kernels/bodies/lanes.hpp"
#include "kernels/bodies/pair_batch.hpp"

namespace talus::kernels {

/// Reads one column after the other, for S::W pairs.
template <class S>
struct NextColumn {
  const double* in;
  std::int64_t stride;
  typename S::B operator()() {
    const typename S::B v = S::load(in);
    in += stride;
    return v;
  }
  shapes::DualForm<S> form() {
    shapes::DualForm<S> f;
    f.axes2.x = (*this)(), f.axes2.y = (*this)(), f.axes2.z = (*this)();
    f.p1 = (*this)(), f.p2 = (*this)();
    return f;
  }
};

template <class S>
void solve_pairs(const PairColumns& c, int most) {
  using B = typename S::B;
  for (std::int64_t at = 0; at < c.pairs; at += S::W) {
    NextColumn<S> take{c.in + at, c.stride};
    shapes::PairForm<S> p;
    p.i = take.form();
    p.j = take.form();
    for (shapes::Triple<S>& row : p.turn) row.x = take(), row.y = take(), row.z = take();
    p.d.x = take(), p.d.y = take(), p.d.z = take();
    p.size = take();
    shapes::PairState<S> s;
    s.range = take();
    s.n.x = take(), s.n.y = take(), s.n.z = take();
    s.eta = take();
    s.care = take();
    s.delta = s.residual = s.step = s.steps = S::set(0);
    s.xi = {s.delta, s.delta, s.delta};
    s.done = S::lt(S::set(1), S::set(0));
    shapes::iterate<S>(p, s, most);
    double* out = c.out + at;
    for (const B v : {s.n.x, s.n.y, s.n.z, s.delta, s.xi.x, s.xi.y, s.xi.z, s.residual, s.step, s.steps,
                      S::select(s.done, S::set(1), S::set(0))}) {
      S::store(out, v);
      out += c.stride;
    }
  }
}

template <class S>
void find_gaps(const GapColumns& c) {
  using B = typename S::B;
  const B tau = S::set(shapes::k_eta * shapes::k_eta);
  for (std::int64_t at = 0; at < c.pairs; at += S::W) {
    NextColumn<S> take{c.in + at, c.stride};
    B h[2];
    for (B& one : h) {
      const shapes::DualForm<S> f = take.form();
      shapes::Triple<S> m;
      m.x = take(), m.y = take(), m.z = take();
      one = shapes::height<S>(f, m, tau).h;
    }
    S::store(c.out + at, (h[0] + h[1]) - take());
  }
}

}  // namespace talus::kernels
