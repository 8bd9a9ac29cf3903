// See oblique_reference.hpp.
#include "oblique_reference.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace talus::verification {
namespace {

/// What is integrated: separation, velocities, spins, tangential spring (linear: its length, Hertz: its force on a;
/// partial slip: force and second Legendre part of its distribution), rolling and twisting moment.
struct State {
  Vec3 x, va, vb, wa, wb, spring, second, roll;
  double twist = 0;
};

/// Rings of partial slip: Gauss points s^2 = (3 -+ 2 sqrt(6/5))/7 of the contact radius.
struct Ring {
  double weight, p2, limit;
};
std::array<Ring, 2> rings() {
  std::array<Ring, 2> out;
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? -1 : 1, s2 = (3 + sign * 2 * std::sqrt(1.2)) / 7;
    const double weight = 0.5 - sign * std::sqrt(30.0) / 36;
    out[static_cast<std::size_t>(k)] = {weight, (3 * s2 - 1) / 2, 1.5 * weight * (1 - s2)};
  }
  return out;
}

State plus(const State& a, double h, const State& d) {
  return {a.x + h * d.x,           a.va + h * d.va,         a.vb + h * d.vb,     a.wa + h * d.wa,      a.wb + h * d.wb,
          a.spring + h * d.spring, a.second + h * d.second, a.roll + h * d.roll, a.twist + h * d.twist};
}

struct Impact {
  ObliqueLaw law;
  Body a, b;
  double reff = 0, meff = 0;

  double overlap(const State& s) const { return a.r + b.r - norm(s.x); }

  /// Laws that hold at an instant, and the two rules that are not differential equations where a dashpot is missing.
  struct Contact {
    Vec3 n, vt;
    double delta, vn, elastic, kt, ct, limit;
  };
  Contact contact(const State& s) const {
    Contact c;
    const double d = norm(s.x);
    c.delta = std::max(a.r + b.r - d, 0.0);
    c.n = (1 / d) * s.x;
    const Vec3 v = s.va - s.vb;
    c.vn = dot(v, c.n);
    const double lever = d / (a.r + b.r);
    c.vt = v - c.vn * c.n - cross((lever * a.r) * s.wa + (lever * b.r) * s.wb, c.n);
    if (law.hertz) {
      const double radius = std::sqrt(reff * c.delta);
      c.elastic = law.kn * radius * c.delta;
      c.kt = law.kt * radius;
      c.ct = law.gt * std::sqrt(meff * c.kt);
    } else {
      c.elastic = law.kn * c.delta;
      c.kt = law.kt;
      c.ct = law.gt * meff;
    }
    c.limit = law.mu * c.elastic;
    return c;
  }

  /// Rates of both parts of a distribution in rings; returns the tangential force. `grown`: a'/a. While the contact
  /// grows the stored force spreads at constant force and second moment, while it shrinks it is cut off.
  Vec3 ring_rates(const State& s, const Contact& c, double grown, State& d) const {
    if (grown > 0) {
      d.second = (-2 * grown) * s.second - (5 * grown) * s.spring;
    } else {
      d.spring = grown * (s.spring + s.second);
      d.second = (3 * grown) * s.second;
    }
    Vec3 total;
    for (const Ring& r : rings()) {
      const Vec3 pull = r.weight * (s.spring + r.p2 * s.second);
      Vec3 ft = pull - (r.weight * c.ct) * c.vt, creep = c.vt;
      if (norm(ft) > r.limit * c.limit) {
        ft = (r.limit * c.limit / norm(ft)) * ft;
        if (c.ct > 0) creep = (1 / (r.weight * c.ct)) * (pull - ft);
      }
      total = total + ft;
      d.spring = d.spring - (r.weight * c.kt) * creep;
      d.second = d.second - (5 * r.p2 * r.weight * c.kt) * creep;
    }
    return total;
  }

  State rate(const State& s) const {
    const Contact c = contact(s);
    const double stiff = law.hertz ? 1.5 * law.kn * std::sqrt(reff * c.delta) : law.kn;
    const double cn = law.hertz ? law.gn * std::sqrt(meff * law.kn * std::sqrt(reff * c.delta)) : law.gn * meff;
    const double fn = c.elastic - cn * c.vn;
    const Vec3 pull = law.hertz ? s.spring : (-c.kt) * s.spring;  // of the spring, on a
    Vec3 ft = pull - c.ct * c.vt, creep = c.vt;
    if (norm(ft) > c.limit) {
      ft = (c.limit / norm(ft)) * ft;
      if (c.ct > 0) creep = (1 / c.ct) * (pull - ft);
    }
    State d;
    // the contact point of a plane follows the sphere: its normal does not turn
    d.x = b.r > 0 ? s.va - s.vb : c.vn * c.n;
    const Vec3 turn = (1 / norm(s.x)) * (d.x - c.vn * c.n);
    const double grown = c.delta > 0 ? -0.5 * c.vn / c.delta : 0;  // a'/a
    if (law.partial_slip) {
      ft = ring_rates(s, c, grown, d);
      d.second = d.second - dot(s.second, turn) * c.n;
    } else {
      d.spring = (law.hertz ? -c.kt : 1.0) * creep;
      if (law.hertz && grown < 0) d.spring = d.spring + grown * s.spring;
    }
    d.spring = d.spring - dot(s.spring, turn) * c.n;
    const Vec3 w = s.wa - s.wb;
    const double spin = dot(w, c.n);
    const Vec3 rolling = w - spin * c.n;
    const double inv = 1 / (a.m * a.r * a.r) + (b.r > 0 ? 1 / (b.m * b.r * b.r) : 0.0);
    const double kr = 2.25 * stiff * std::pow(law.rolling * reff, 2),
                 kw = 2.25 * stiff * std::pow(law.twisting * reff, 2);
    d.roll = (-kr) * rolling - dot(s.roll, turn) * c.n;
    d.twist = -kw * spin;
    if (law.hertz && c.vn > 0 && c.delta > 0) {
      d.roll = d.roll - (0.5 * c.vn / c.delta) * s.roll;
      d.twist -= 0.5 * c.vn / c.delta * s.twist;
    }
    Vec3 moment = s.roll + s.twist * c.n;
    if (norm(s.roll) < law.rolling * reff * c.elastic * (1 - 1e-9))
      moment = moment - (2 * law.viscous * std::sqrt(kr * 1.4 / inv)) * rolling;
    if (std::fabs(s.twist) < law.twisting * reff * c.elastic * (1 - 1e-9))
      moment = moment - (2 * law.torsion * std::sqrt(kw * 0.4 / inv) * spin) * c.n;
    const double lever = norm(s.x) / (a.r + b.r);
    const Vec3 force = fn * c.n + ft;
    d.va = (1 / a.m) * force;
    d.wa = (2.5 / (a.m * a.r * a.r)) * (cross((-lever * a.r) * c.n, ft) + moment);
    if (b.r > 0) {
      d.vb = (-1 / b.m) * force;
      d.wb = (2.5 / (b.m * b.r * b.r)) * (cross((-lever * b.r) * c.n, ft) - moment);
    }
    return d;
  }

  /// Springs without a dashpot follow a falling limit at once; rolling and twisting springs always do.
  void limit(State& s) const {
    const Contact c = contact(s);
    s.spring = s.spring - dot(s.spring, c.n) * c.n;
    s.second = s.second - dot(s.second, c.n) * c.n;
    s.roll = s.roll - dot(s.roll, c.n) * c.n;
    const double most = law.hertz ? c.limit : c.limit / c.kt;
    if (law.partial_slip && c.ct == 0) {
      Vec3 whole, second;
      for (const Ring& r : rings()) {
        Vec3 pull = r.weight * (s.spring + r.p2 * s.second);
        if (norm(pull) > r.limit * most) pull = (r.limit * most / norm(pull)) * pull;
        whole = whole + pull;
        second = second + (5 * r.p2) * pull;
      }
      s.spring = whole;
      s.second = second;
    } else if (c.ct == 0 && norm(s.spring) > most) {
      s.spring = (most / norm(s.spring)) * s.spring;
    }
    const double bend = law.rolling * reff * c.elastic, twist = law.twisting * reff * c.elastic;
    if (norm(s.roll) > bend) s.roll = (bend / norm(s.roll)) * s.roll;
    s.twist = std::clamp(s.twist, -twist, twist);
  }

  State step(const State& s, double h) const {
    const State k1 = rate(s), k2 = rate(plus(s, 0.5 * h, k1)), k3 = rate(plus(s, 0.5 * h, k2)),
                k4 = rate(plus(s, h, k3));
    State out = plus(plus(plus(plus(s, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
    limit(out);
    return out;
  }
};

}  // namespace

ObliqueResult oblique_reference(const ObliqueLaw& law, const Body& a, const Body& b, Vec3 n, double contact,
                                int steps) {
  Impact q{law, a, b};
  q.reff = b.r > 0 ? a.r * b.r / (a.r + b.r) : a.r;
  q.meff = b.r > 0 ? a.m * b.m / (a.m + b.m) : a.m;
  State s;
  s.x = (a.r + b.r) * n;
  s.va = a.v;
  s.vb = b.v;
  s.wa = a.w;
  s.wb = b.w;
  // the first instants before any force: the springs are empty, the overlap must be positive for the Hertz terms
  const double h0 = contact / steps, speed = -dot(a.v - b.v, n);
  s.x = s.x - (1e-9 * h0 * speed) * n;
  for (int k = 0; k < 100 * steps; ++k) {
    // Hertz: the rates start and end as roots of the overlap, so steps shrink with it
    const double share = std::max(q.overlap(s), 0.0) / (0.3 * speed * contact);
    const double h = h0 * std::clamp(std::sqrt(share), 1e-3, 1.0);
    const State next = q.step(s, h);
    const double before = q.overlap(s), after = q.overlap(next);
    if (after <= 0) {
      s = q.step(s, h * before / (before - after));
      break;
    }
    s = next;
  }
  return {s.va, s.wa, s.vb, s.wb};
}

}  // namespace talus::verification
