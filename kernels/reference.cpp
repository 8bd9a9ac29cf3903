// Scalar oracle of the contact laws; see reference.hpp.
#include "kernels/reference.hpp"

#include <algorithm>
#include <cmath>

namespace talus::reference {

namespace {

struct Kinematics {
  Vec3 n, vt;
  double d, delta, vn, meff, lever, turned;  ///< turned: v_t^2 dt/d, by which v_n grows as the normal turns [m/s]
};

Kinematics kinematics(const Pair& p, const LawArgs& a) {
  Kinematics k;
  const Vec3 x = p.xi - p.xj;
  k.d = norm(x);
  k.n = (1 / k.d) * x;
  k.delta = p.ri + p.rj - k.d;
  k.meff = 1 / (1 / p.mi + 1 / p.mj);
  k.lever = a.contact_lever != 0 ? k.d / (p.ri + p.rj) : 1;
  const Vec3 v = p.vi - p.vj;
  k.vn = dot(v, k.n);
  // the normal at n, or the one at mid-step x(n-1/2) = x(n) - v dt/2
  Vec3 n = k.n, c = k.n;
  if (a.synchronised != 0) {
    const Vec3 mid = x - (0.5 * a.dt) * v;
    n = (1 / norm(mid)) * mid;
    c = (1 / k.d) * mid;  // the lever follows the distance at mid-step
  }
  k.turned = a.synchronised != 0 ? a.dt * (dot(v, v) - k.vn * k.vn) / k.d : 0;
  // surface velocities: v_i + w_i x (-l_i n), v_j + w_j x (l_j n) with l = lever * radius
  k.vt = v - dot(v, n) * n - cross((k.lever * p.ri) * p.wi + (k.lever * p.rj) * p.wj, c);
  return k;
}

/// Relative normal velocity at n without the pair's own force. `spring`: elastic normal force.
double dashpot_velocity(const Kinematics& k, const LawArgs& a, double spring, double predicted, double arc = 0) {
  if (a.recall == 0) return k.vn;
  if (predicted == 0) {
    const bool touched_now = k.delta < -k.vn * a.dt + arc;
    return touched_now ? k.vn : k.vn - 0.5 * a.dt * spring / k.meff;
  }
  return k.vn + 0.5 * (k.vn - predicted - k.turned);
}

/// What a step counts of spring and dashpot: 1 and 1 but where the contact touches within it or parts before the next
/// one, then their impulses over the time in contact.
struct Share {
  double spring = 1, dashpot = 1;
  bool touches = false, parts = false;
};

/// Normal force of the linear law with that share; c: dashpot [kg/s], seen: velocity that it sees.
/// arc: what the distance grows by in a step because the pair moves past each other [m].
double normal_force(const Kinematics& k, const LawArgs& a, double kn, double c, double seen, bool predicted, double arc,
                    Share& share) {
  const auto force = [&] {
    return (share.spring * kn * k.delta - share.dashpot * c * seen) /
           (a.centred != 0 ? 1 + 0.5 * a.dt * share.dashpot * c / k.meff : 1);
  };
  double fn = force();
  if (a.centred == 0 || a.onset == 0) return fn;
  const bool memory = a.recall != 0, brief = k.delta < std::abs(k.vn) * a.dt;
  // by the step before, which foresaw the end
  const bool counted = memory && a.start == 0 && !predicted && k.vn > 0 && brief;
  double way = (memory && k.vn > 0 ? k.vn + a.dt * fn / k.meff : std::abs(k.vn)) * a.dt + arc;
  share.touches = k.vn < 0 && k.delta < way && !(memory && predicted);
  share.parts = k.vn > 0 && (counted || k.delta < (memory ? 17.0 / 16 : 1) * way);
  if (counted) {
    share.spring = share.dashpot = 0;
    return 0;
  }
  if (!share.touches && !share.parts) return fn;
  const double u = k.delta / std::max(way, k.delta / 1.5);
  if (memory) share.spring = 0.5 * (0.5 + u) * (0.5 + u) / u;
  share.dashpot = 0.5 + u;
  return force();
}

/// What a contact has slipped before it sticks within its first steps [m]: excess over the limit e0 at the beginning,
/// relaxing with the time c/kt towards a line that falls to e1 at the end of the time slid; the integral of e/c to its
/// zero, with the logarithm as a fraction.
double early_slip(double e0, double e1, double relaxation, double slid, double kt) {
  const double y = e0 / (relaxation * (e0 - e1) / slid);
  return e0 / kt * (1 - (6 + 3 * y) / (6 + 6 * y + y * y));
}

/// Spring force [N] after a step of sliding at the limit, along the unit vector of the trial force:
/// d(spring)/dt = k/c (limit along - spring), L-stable rule of second order. `travel` = k times the time slid;
/// `before`: spring force of the last step; `middle`: the limit in the middle of that time.
Vec3 creep(Vec3 before, Vec3 along, double c, double travel, double limit, double middle) {
  const double whole = c * (c + travel) + 0.5 * travel * travel;
  return (c * c / whole) * before + (travel * (c * middle + 0.5 * travel * limit) / whole) * along;
}

/// Tangential force per length q(s) = a + b s^2 on (0, 1), s = x / contact radius, times that radius [N].
struct Profile {
  Vec3 a, b;
  Vec3 at(double s2) const { return a + s2 * b; }
  Vec3 force() const { return a + (1.0 / 3.0) * b; }
  Vec3 moment() const { return (1.0 / 3.0) * a + 0.2 * b; }
};

Profile of_moments(Vec3 force, Vec3 moment) { return {2.25 * force - 3.75 * moment, 11.25 * moment - 3.75 * force}; }

/// What partial_slip() needs of a step: `grow` = radius over that of the last step, the rest as in hertz_mindlin().
struct SlipStep {
  double grow, travel, ct, kick, limit, middle;
  Vec3 vt;
};

/// Two rings of a Hertz contact, each a spring and a dashpot in series with a slider. Returns the tangential force;
/// `ft` and `second` are the force and 5 times the sum of P2(s) force of the rings.
Vec3 partial_slip(const SlipStep& q, Vec3& ft, Vec3& second) {
  const double root = std::sqrt(1.2), s2[2] = {(3 - 2 * root) / 7, (3 + 2 * root) / 7};
  const double weight[2] = {0.5 + std::sqrt(30.0) / 36, 0.5 - std::sqrt(30.0) / 36};
  Profile old{ft - 0.5 * second, 1.5 * second}, unit{{1, 1, 1}, {}};
  if (q.grow < 1) {
    old = {q.grow * old.a, (q.grow * q.grow * q.grow) * old.b};
  } else {
    const double x = 1 / q.grow;
    old = of_moments(old.force(), (x * x) * old.moment());
    unit = of_moments({1, 1, 1}, ((0.6 - 0.2 * x + 0.6 * x * x) / 3) * Vec3{1, 1, 1});
  }
  Vec3 before[2], stuck[2], g[2], total;
  bool slides[2] = {false, false};
  double stiffness[2], limit[2], damped = 1;
  for (int r = 0; r < 2; ++r) {
    stiffness[r] = weight[r] * unit.at(s2[r]).x;
    limit[r] = 1.5 * weight[r] * (1 - s2[r]);
    before[r] = weight[r] * old.at(s2[r]);
    stuck[r] = before[r] - (stiffness[r] * q.travel) * q.vt;
  }
  for (int pass = 0; pass < 2; ++pass) {
    // the velocity at the end of the step, with the limit where a ring slides
    total = {};
    for (int r = 0; r < 2; ++r) total = total + (slides[r] ? (limit[r] * q.limit / norm(g[r])) * g[r] : stuck[r]);
    const Vec3 u = (1 / (1 + q.kick * q.ct * damped)) * (q.vt + q.kick * total);
    bool sliding[2] = {slides[0], slides[1]};
    for (int r = 0; r < 2; ++r) {
      if (slides[r]) continue;
      g[r] = stuck[r] - (weight[r] * q.ct) * u;
      sliding[r] = norm(g[r]) > limit[r] * q.limit;
    }
    damped = 0;
    for (int r = 0; r < 2; ++r) {
      slides[r] = sliding[r];
      damped += slides[r] ? 0 : weight[r];
    }
    if (!slides[0] && !slides[1]) break;
  }
  ft = second = total = {};
  for (int r = 0; r < 2; ++r) {
    Vec3 spring = stuck[r];
    if (slides[r]) {
      const Vec3 along = (1 / norm(g[r])) * g[r];
      spring =
          creep(before[r], along, weight[r] * q.ct, stiffness[r] * q.travel, limit[r] * q.limit, limit[r] * q.middle);
      g[r] = (limit[r] * q.limit) * along;
    }
    total = total + g[r];
    ft = ft + spring;
    second = second + (2.5 * (3 * s2[r] - 1)) * spring;
  }
  return total;
}

Result assemble(const Pair& p, const Kinematics& k, double fn, Vec3 ft) {
  Result r;
  r.force = fn * k.n + ft;
  r.torque_i = cross((-k.lever * p.ri) * k.n, ft);
  r.torque_j = cross((k.lever * p.rj) * k.n, -ft);
  return r;
}

}  // namespace

Result linear(const Pair& p, const PairParameters& c, const LawArgs& a, bool friction, Vec3& xi, double& predicted) {
  const Kinematics k = kinematics(p, a);
  const double scale = a.by_restitution != 0 ? std::sqrt(c.kn / k.meff) : 1;
  Share share;
  const double arc = a.recall != 0 && a.centred != 0 && a.onset != 0 ? 0.5 * a.dt * k.turned : 0;
  const double seen = dashpot_velocity(k, a, c.kn * k.delta, predicted, arc);
  double fn = normal_force(k, a, c.kn, c.gn * scale * k.meff, seen, predicted != 0, arc, share);
  if (a.clip != 0) fn = std::max(fn, 0.0);
  predicted = share.parts ? 0 : k.vn + a.dt * fn / k.meff;
  if (!friction) return assemble(p, k, fn, {});
  // in the step in which they touch, the spheres have slid past each other only since then
  const bool touched_now = share.touches;
  const double slid = a.start != 0 && !touched_now ? 0
                      : touched_now                ? k.delta / (arc / a.dt - k.vn)
                                                   : a.dt,
               ct = c.gt * k.meff;
  const Vec3 before = xi - dot(xi, k.n) * k.n;
  xi = before + slid * k.vt;
  if (a.balanced != 0 && touched_now && a.start == 0 && c.kt > 0)
    xi = xi - (ct / c.kt) * k.vt;  // there is no limit yet
  const double grow = a.centred != 0 ? 1 + 0.5 * 3.5 * a.dt * c.gt : 1;
  Vec3 ft = (-1 / grow) * (c.kt * xi + ct * k.vt);
  const double limit = c.mu * (a.total != 0 ? std::max(fn, 0.0) : c.kn * k.delta), size = norm(ft);
  const bool early = k.vn < 0 && k.delta < -3 * k.vn * a.dt, series = a.balanced == 0 && a.total == 0;
  if (a.centred != 0 && a.onset != 0 && a.start == 0 && early && series && ct > 0 && size < limit) {
    const Vec3 old = c.kt * before + ct * k.vt;
    const double was = touched_now ? 0 : limit + c.mu * c.kn * k.vn * a.dt;
    const double e0 = norm(old) - was + std::min(grow - 1, 1.0) * was;
    if (e0 > 0 && norm(old) > 0) {
      const Vec3 slip = (early_slip(e0, size - limit, ct / c.kt, slid, c.kt) / norm(old)) * old;
      xi = xi - slip;
      ft = ft + (c.kt / grow) * slip;
    }
  }
  if (size > limit) {
    const Vec3 along = (1 / size) * ft;
    ft = limit * along;
    double middle = a.total != 0 ? limit : limit + 0.5 * c.mu * c.kn * k.vn * a.dt;
    if (touched_now && a.total == 0) middle = 0.5 * limit;
    Vec3 spring;  // nothing to store where it has not moved
    if (a.start == 0)
      spring = a.balanced != 0 ? grow * ft + ct * k.vt : creep((-c.kt) * before, along, ct, c.kt * slid, limit, middle);
    xi = (-1 / c.kt) * spring;
  }
  double weight = a.total != 0 ? 1 : share.spring;
  // a spring that keeps its force until the limit, which falls to zero in the time left, has come down to it
  if (share.parts && share.dashpot > 0 && a.recall != 0 && a.total == 0 && norm(ft) > 0) {
    const double left = share.dashpot - 0.5, held = left * (1 - size / limit);
    if (held > -0.5) weight = size / norm(ft) * (0.5 + 0.5 * (held + left));
  }
  return assemble(p, k, fn, weight * ft);
}

Result hertz_mindlin(const Pair& p, const PairParameters& c, const LawArgs& a, bool friction, Vec3& ft, double& radius,
                     double& predicted, Vec3* second) {
  const Kinematics k = kinematics(p, a);
  const double reff = p.rj > 0 ? p.ri * p.rj / (p.ri + p.rj) : p.ri;
  const double contact = std::sqrt(reff * k.delta), sn = c.kn * contact, st = c.kt * contact, elastic = sn * k.delta;
  double cn = c.gn * std::sqrt(k.meff * sn);
  const double ct = c.gt * std::sqrt(k.meff * st);
  const double u = k.delta / (std::abs(k.vn) * a.dt);
  const bool brief = a.centred != 0 && a.onset != 0 && u < 1, touched = brief && k.vn < 0;
  if (brief) {
    const bool counted = a.recall != 0 && predicted == 0 && k.vn > 0;  // as in the linear law
    const double q = 0.5 + u;
    cn *= counted ? 0 : 0.8 * q * std::sqrt(std::sqrt(q / u));  // q^(5/4) / (5/4 u^(1/4))
  }
  double fn = elastic - cn * dashpot_velocity(k, a, elastic, predicted);
  if (a.centred != 0) fn /= 1 + 0.5 * a.dt * cn / k.meff;
  if (a.clip != 0) fn = std::max(fn, 0.0);
  predicted = brief && k.vn > 0 ? 0 : k.vn + a.dt * fn / k.meff;
  if (!friction) return assemble(p, k, fn, {});
  Vec3 before = ft - dot(ft, k.n) * k.n;
  if (contact < radius && second == nullptr) before = (contact / radius) * before;
  double travel = a.start != 0 ? 0 : c.kt * std::min(contact, 0.5 * (contact + radius)) * a.dt;
  if (touched) travel = c.kt * (2.0 / 3.0 * contact) * (u * a.dt);
  const double grow = contact / radius, kick = a.centred != 0 ? 0.5 * 3.5 * a.dt / k.meff : 0;
  const double limit = c.mu * (a.total != 0 ? std::max(fn, 0.0) : elastic);
  double middle = a.total != 0 ? limit : limit + 0.75 * c.mu * sn * k.vn * a.dt;
  if (touched && a.total == 0) middle = 0.4 * limit;
  radius = contact;
  if (second != nullptr) {
    ft = before;
    *second = *second - dot(*second, k.n) * k.n;
    return assemble(p, k, fn, partial_slip({grow, travel, ct, kick, limit, middle, k.vt}, ft, *second));
  }
  ft = before - travel * k.vt;
  Vec3 total = (1 / (1 + kick * ct)) * (ft - ct * k.vt);
  const double size = norm(total);
  if (size > limit) {
    const Vec3 along = (1 / size) * total;
    total = limit * along;
    ft = creep(before, along, ct, travel, limit, middle);
  }
  return assemble(p, k, fn, total);
}

Vec3 moments(const Pair& p, double press, double stiffness, double slid, const AddOnParameters& c, const MomentArgs& a,
             MomentHistory& h) {
  const Vec3 n = (1 / norm(p.xi - p.xj)) * (p.xi - p.xj), w = p.wi - p.wj;
  const double reff = p.ri * p.rj / (p.ri + p.rj), turn = dot(w, n);
  const Vec3 roll = w - turn * n;
  double shrink = 1, reach = stiffness, onset = 1;
  if (a.rescale != 0) {
    if (stiffness < h.stiffness) shrink = stiffness / h.stiffness;
    reach = h.stiffness > 0 ? std::min(stiffness, 0.5 * (stiffness + h.stiffness)) : 2 * stiffness / 3;
    h.stiffness = stiffness;
  }
  if (a.centred != 0 && slid > 0 && slid < a.dt) {
    const double u = slid / a.dt;
    onset = a.rescale != 0 ? 0.8 * (0.5 + u) * std::sqrt(std::sqrt((0.5 + u) / u)) : 0.5 + u;  // as the normal dashpot
  }
  Vec3 m;
  if (a.rolling == 1 && norm(roll) > 0) {
    const double compliance = 1 / (0.4 * p.mi * p.ri * p.ri) + 1 / (0.4 * p.mj * p.rj * p.rj);
    m = (-std::min(c.rolling * reff * press / norm(roll), 1 / (a.dt * compliance))) * roll;
  }
  if (a.rolling == 2) {
    const double k = 2.25 * stiffness * (c.rolling * reff) * (c.rolling * reff), limit = c.rolling * reff * press;
    h.rolling = shrink * (h.rolling - dot(h.rolling, n) * n) - (k * reach / stiffness * slid) * roll;
    if (norm(h.rolling) > limit) {
      h.rolling = (limit / norm(h.rolling)) * h.rolling;
      m = h.rolling;
    } else {
      const double inertia = 1 / (1 / (1.4 * p.mi * p.ri * p.ri) + 1 / (1.4 * p.mj * p.rj * p.rj));
      double damp = onset * 2 * c.viscous * std::sqrt(inertia * k);
      if (a.centred != 0) damp /= 1 + 0.5 * a.dt * damp / inertia;
      m = h.rolling - damp * roll;
    }
  }
  if (a.twisting != 0) {
    const double k = 2.25 * stiffness * (c.twisting * reff) * (c.twisting * reff), limit = c.twisting * reff * press;
    h.twisting = shrink * h.twisting - k * reach / stiffness * slid * turn;
    double total = 0;
    if (std::abs(h.twisting) > limit) {
      total = h.twisting = std::copysign(limit, h.twisting);
    } else {
      const double inertia = 1 / (1 / (0.4 * p.mi * p.ri * p.ri) + 1 / (0.4 * p.mj * p.rj * p.rj));
      double damp = onset * 2 * c.torsion * std::sqrt(inertia * k);
      if (a.centred != 0) damp /= 1 + 0.5 * a.dt * damp / inertia;
      total = h.twisting - damp * turn;
    }
    m = m + total * n;
  }
  return m;
}

JkrState jkr(double delta, double reff, double e_star, double w) {
  const double pi = 3.14159265358979323846;
  // delta(a) has its minimum at a_c, a_c^3 = pi w R*^2 / (8 E*), and rises beyond it: both by bisection
  const double cube = pi * w * reff * reff / (8 * e_star);
  double low = 0, high = 4 * (reff + cube / (reff * reff));
  for (int k = 0; k < 200; ++k) {
    const double a = 0.5 * (low + high);
    (a * a * a > cube ? high : low) = a;
  }
  high = low + std::sqrt(reff * std::abs(delta)) * 4 + 4 * low;
  for (int k = 0; k < 200; ++k) {
    const double a = 0.5 * (low + high);
    (a * a / reff - std::sqrt(2 * pi * w * a / e_star) > delta ? high : low) = a;
  }
  const double a3 = high * high * high;
  return {4 * e_star * a3 / (3 * reff) - std::sqrt(8 * pi * w * e_star * a3), high};
}

double sjkr(double distance, double ri, double rj, bool wall, double density) {
  const double pi = 3.14159265358979323846;
  const double x = wall ? distance : (distance * distance + ri * ri - rj * rj) / (2 * distance);
  return density * pi * (ri * ri - x * x);
}

}  // namespace talus::reference
