// Scalar oracle of the contact laws; see reference.hpp.
#include "kernels/reference.hpp"

#include <algorithm>
#include <cmath>

namespace talus::reference {

namespace {

struct Kinematics {
  Vec3 n, vt;
  double d, delta, vn, meff, lever;
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
  // surface velocities: v_i + w_i x (-l_i n), v_j + w_j x (l_j n) with l = lever * radius
  k.vt = v - dot(v, n) * n - cross((k.lever * p.ri) * p.wi + (k.lever * p.rj) * p.wj, c);
  return k;
}

/// Relative normal velocity at n without the pair's own force. `spring`: elastic normal force.
double dashpot_velocity(const Pair& p, const Kinematics& k, const LawArgs& a, double spring, double predicted) {
  if (a.recall == 0) return k.vn;
  if (predicted == 0) {
    const bool touched_now = k.delta < -k.vn * a.dt;
    return touched_now ? k.vn : k.vn - 0.5 * a.dt * spring / k.meff;
  }
  const Vec3 v = p.vi - p.vj;
  const double turned = a.synchronised != 0 ? a.dt * (dot(v, v) - k.vn * k.vn) / k.d : 0;
  return k.vn + 0.5 * (k.vn - predicted - turned);
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
  const double gamma_t = c.gt;
  double gamma_n = c.gn * scale;
  const bool brief = a.centred != 0 && a.onset != 0 && k.delta < std::abs(k.vn) * a.dt;
  if (brief) {
    const bool counted = a.recall != 0 && predicted == 0 && k.vn > 0;  // by the step before, which foresaw the end
    gamma_n *= counted ? 0 : 0.5 + k.delta / (std::abs(k.vn) * a.dt);
  }
  double fn = c.kn * k.delta - gamma_n * k.meff * dashpot_velocity(p, k, a, c.kn * k.delta, predicted);
  if (a.centred != 0) fn /= 1 + 0.5 * a.dt * gamma_n;
  if (a.clip != 0) fn = std::max(fn, 0.0);
  predicted = brief && k.vn > 0 ? 0 : k.vn + a.dt * fn / k.meff;
  if (!friction) return assemble(p, k, fn, {});
  // in the step in which they touch, the spheres have slid past each other only since then
  const bool touched_now = a.centred != 0 && a.onset != 0 && k.vn < 0 && k.delta < -k.vn * a.dt;
  xi = xi - dot(xi, k.n) * k.n + (touched_now ? k.delta / -k.vn : a.dt) * k.vt;
  const double shrink = a.centred != 0 ? 1 / (1 + 0.5 * 3.5 * a.dt * gamma_t) : 1;
  Vec3 ft = -shrink * (c.kt * xi + (gamma_t * k.meff) * k.vt);
  const double limit = c.mu * std::max(fn, 0.0), size = norm(ft);
  if (size > limit) {
    const Vec3 along = (1 / size) * ft;
    const double spring = std::max(0.0, limit + (shrink * gamma_t * k.meff) * dot(k.vt, along));
    ft = limit * along;
    if (a.balanced != 0)
      xi = (-1 / (c.kt * shrink)) * (ft + (shrink * gamma_t * k.meff) * k.vt);
    else
      xi = (-spring / (c.kt * shrink)) * along;
  }
  return assemble(p, k, fn, ft);
}

Result hertz_mindlin(const Pair& p, const PairParameters& c, const LawArgs& a, bool friction, Vec3& ft, double& radius,
                     double& predicted) {
  const Kinematics k = kinematics(p, a);
  const double reff = p.rj > 0 ? p.ri * p.rj / (p.ri + p.rj) : p.ri;
  const double contact = std::sqrt(reff * k.delta), sn = c.kn * contact, st = c.kt * contact;
  const double cn = c.gn * std::sqrt(k.meff * sn), ct = c.gt * std::sqrt(k.meff * st);
  double fn = sn * k.delta - cn * dashpot_velocity(p, k, a, sn * k.delta, predicted);
  if (a.centred != 0) fn /= 1 + 0.5 * a.dt * cn / k.meff;
  if (a.clip != 0) fn = std::max(fn, 0.0);
  predicted = k.vn + a.dt * fn / k.meff;
  if (!friction) return assemble(p, k, fn, {});
  ft = ft - dot(ft, k.n) * k.n;
  if (contact < radius) ft = (contact / radius) * ft;
  ft = ft - (c.kt * std::min(contact, 0.5 * (contact + radius)) * a.dt) * k.vt;
  radius = contact;
  const double shrink = a.centred != 0 ? 1 / (1 + 0.5 * 3.5 * a.dt * ct / k.meff) : 1;
  Vec3 total = shrink * (ft - ct * k.vt);
  const double limit = c.mu * std::max(fn, 0.0), size = norm(total);
  if (size > limit) {
    const Vec3 along = (1 / size) * total;
    total = limit * along;
    ft = std::max(0.0, limit / shrink + ct * dot(k.vt, along)) * along;
  }
  return assemble(p, k, fn, total);
}

Vec3 moments(const Pair& p, Vec3 force, double stiffness, const AddOnParameters& c, const MomentArgs& a,
             MomentHistory& h) {
  const Vec3 n = (1 / norm(p.xi - p.xj)) * (p.xi - p.xj), w = p.wi - p.wj;
  const double reff = p.ri * p.rj / (p.ri + p.rj), turn = dot(w, n);
  const Vec3 roll = w - turn * n;
  const double press = std::max(dot(force, n) + c.press * reff, 0.0);
  double shrink = 1;
  if (a.rescale != 0) {
    if (stiffness < h.stiffness) shrink = stiffness / h.stiffness;
    h.stiffness = stiffness;
  }
  Vec3 m;
  if (a.rolling == 1 && norm(roll) > 0) {
    const double compliance = 1 / (0.4 * p.mi * p.ri * p.ri) + 1 / (0.4 * p.mj * p.rj * p.rj);
    m = (-std::min(c.rolling * reff * press / norm(roll), 1 / (a.dt * compliance))) * roll;
  }
  if (a.rolling == 2) {
    const double k = 2.25 * stiffness * (c.rolling * reff) * (c.rolling * reff), limit = c.rolling * reff * press;
    h.rolling = shrink * (h.rolling - dot(h.rolling, n) * n) - (k * a.dt) * roll;
    if (norm(h.rolling) > limit) {
      h.rolling = (limit / norm(h.rolling)) * h.rolling;
      m = h.rolling;
    } else {
      const double inertia = 1 / (1 / (1.4 * p.mi * p.ri * p.ri) + 1 / (1.4 * p.mj * p.rj * p.rj));
      double damp = 2 * c.viscous * std::sqrt(inertia * k);
      if (a.centred != 0) damp /= 1 + 0.5 * a.dt * damp / inertia;
      m = h.rolling - damp * roll;
    }
  }
  if (a.twisting != 0) {
    const double k = 2.25 * stiffness * (c.twisting * reff) * (c.twisting * reff), limit = c.twisting * reff * press;
    h.twisting = shrink * h.twisting - k * a.dt * turn;
    double total = 0;
    if (std::abs(h.twisting) > limit) {
      total = h.twisting = std::copysign(limit, h.twisting);
    } else {
      const double inertia = 1 / (1 / (0.4 * p.mi * p.ri * p.ri) + 1 / (0.4 * p.mj * p.rj * p.rj));
      double damp = 2 * c.torsion * std::sqrt(inertia * k);
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
