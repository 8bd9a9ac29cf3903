// See contact_limits.hpp. det_math is used although nothing here feeds the trajectory, so that a step which is just
// accepted on one machine is not refused on another.
#include "core/rules/contact_limits.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/grains/body.hpp"
#include "core/rules/adhesion.hpp"
#include "core/rules/restitution.hpp"

namespace talus {
namespace {

/// Largest contact radius [m] of a JKR impact at speed v: the energy 1/2 m v^2 and what attaching sets free, pi w a_c^2
/// (s^10/15 - 2/3 s^7 + s^4 + 12/5 4^(1/3)) with a = a_c s^2 (kernels/models/jkr.hpp).
double jkr_radius(double kappa, double e_star, double r, double m, double v) {
  const double a_c = det::cbrt(kappa * r * r), scale = 8 * e_star * kappa * (a_c * a_c);  // pi w = 8 E* kappa
  const double energy = 0.5 * m * (v * v) / scale;
  double low = 1.5874010519681994, high = 1e6;  // s at zero overlap
  for (int k = 0; k < 100; ++k) {
    const double s = 0.5 * (low + high), s3 = s * s * s, s4 = s3 * s;
    const bool above = s4 * (s3 * s3 / 15 - 2 * s3 / 3 + 1) + 2.4 * 1.5874010519681994 > energy;
    (above ? high : low) = s;
  }
  return a_c * high * high;
}

/// Rolling and twisting springs k = 9/4 k_n mu^2 R*^2 (kernels/models/moments.hpp). The dashpot of share eta of the
/// critical one refers to the inertia 7/5 m r^2 (rolling) or 2/5 m r^2 (twisting).
void add_moments(const Scene& scene, const PairCoefficients& k, double stiffness, double r_eff, double spins,
                 ContactDynamics& d) {
  const auto squared = [&](double mu) { return 2.25 * stiffness * (mu * r_eff) * (mu * r_eff) * spins; };
  d.rolling = scene.contact.rolling == Rolling::epsd ? squared(k.rolling_friction) : 0;
  d.rolling_rate = 2 * k.rolling_damping * std::sqrt(3.5 * d.rolling);
  d.twisting = squared(k.twisting_friction);
  d.twisting_rate = 2 * k.twisting_damping * std::sqrt(d.twisting);
}

/// Pairs of two particles, or of one and what does not move.
struct Pair {
  double m, r;   ///< reduced mass [kg] and radius [m]
  double spins;  ///< 1 / reduced moment of inertia [1/(kg m2)]
};

Pair pair_of(const Scene& scene, const ContactCase& c) {
  const Body a{c.r_a, scene.materials[static_cast<std::size_t>(c.a)].density};
  const double m_a = c.weight_a * a.mass(), inertia_a = c.weight_a * a.inertia();
  if (c.wall()) return {m_a, c.r_a, 1 / inertia_a};
  const double r = c.r_a * c.r_b / (c.r_a + c.r_b);
  if (c.fixed_b) return {m_a, r, 1 / inertia_a};
  const Body b{c.r_b, scene.materials[static_cast<std::size_t>(c.b)].density};
  const double m_b = c.weight_b * b.mass();
  return {m_a / (m_a + m_b) * m_b, r, 1 / inertia_a + 1 / (c.weight_b * b.inertia())};
}

ContactDynamics linear_dynamics(const Scene& scene, const PairCoefficients& k, const Pair& p) {
  const ContactLaw& law = scene.contact;
  ContactDynamics d;
  d.normal = law.normal_stiffness / p.m;
  const double omega = std::sqrt(d.normal);
  d.normal_rate = !law.by_restitution ? law.normal_damping
                  : k.restitution > 0
                      ? omega * damping_coefficient(k.restitution, DampedSpring::linear, law.clip_tension)
                      : 0;
  // pi / sqrt(k/m - (g/2)^2); an overdamped contact never rebounds, its undamped time is the scale
  const double z = 0.5 * d.normal_rate / omega;
  d.duration = det::k_pi / (omega * (z < 1 ? std::sqrt(1 - z * z) : 1));
  if (law.friction) {
    d.tangential = law.tangential_stiffness / p.m;
    d.tangential_rate = law.tangential_damping;
  }
  add_moments(scene, k, law.normal_stiffness, p.r, p.spins, d);
  return d;
}

ContactDynamics hertz_dynamics(const Scene& scene, const ContactCase& c, const PairCoefficients& k, const Pair& p,
                               double speed, double pressure) {
  const Material &a = scene.materials[static_cast<std::size_t>(c.a)],
                 &b = scene.materials[static_cast<std::size_t>(c.b)];
  const double e_star = 1 / ((1 - a.poisson * a.poisson) / a.young + (1 - b.poisson * b.poisson) / b.young);
  const double g_star =
      1 / ((2 - a.poisson) * 2 * (1 + a.poisson) / a.young + (2 - b.poisson) * 2 * (1 + b.poisson) / b.young);
  const double v = speed > 0 || pressure > 0 ? fmax2(speed, 1e-9) : 1e-5 * std::sqrt(e_star / a.density);
  // delta_max = (15 m v^2 / (16 E* sqrt(R)))^(2/5), t_c = 2.9433 delta_max / v
  const double delta = det::pow(15 * p.m * (v * v) / (16 * e_star * std::sqrt(p.r)), 0.4);
  // under load a^3 = 3 F R / (4 E*)
  const double width = 2 * (c.wall() ? c.r_a : fmin2(c.r_a, c.r_b)), load = pressure * (width * width);
  double radius = fmax2(std::sqrt(p.r * delta), det::cbrt(3 * load * p.r / (4 * e_star)));
  ContactDynamics d;
  d.duration = 2.9433 * delta / v;
  if (const double kappa = adhesion_length(scene, c.a, c.b); kappa > 0) {
    // adhesion pulls the contact open wider than the impact alone; 4.03 / omega is the same duration for Hertz
    radius = fmax2(radius, jkr_radius(kappa, e_star, p.r, p.m, v));
    d.duration = 2.9433 * std::sqrt(15.0 / 8.0) / std::sqrt(2 * e_star * radius / p.m);
  }
  // tangent stiffness 2 E* a, dashpot alpha sqrt(m 4/3 E* a); tangentially 8 G* a, sqrt(2/3) alpha sqrt(m 8 G* a)
  const double alpha =
      k.restitution > 0 ? damping_coefficient(k.restitution, DampedSpring::hertz, scene.contact.clip_tension) : 0;
  d.normal = 2 * e_star * radius / p.m;
  d.normal_rate = alpha * std::sqrt(2.0 / 3.0 * d.normal);
  if (scene.contact.friction) {
    d.tangential = 8 * g_star * radius / p.m;
    d.tangential_rate = alpha * std::sqrt(2.0 / 3.0 * d.tangential);
  }
  add_moments(scene, k, 2 * e_star * radius, p.r, p.spins, d);
  return d;
}

/// In a motion that changes sign with every step (u, -u, u, ...) the velocity v(n-1/2) is 2 u/dt, so that the dashpot
/// acts like the stiffness 2 gamma/dt on top of the spring's:
///   lagged    omega^2 dt^2 + 2 g,  g = gamma dt
///   pairwise  that / (1 + g/2): the pair's own force is in it
///   centred   (omega^2 dt^2 + 4 g) / (1 + g): the other forces, of the step before, enter with the wrong sign
double normal_term(const Scene& scene, double omega2, double rate, double dt) {
  const double g = rate * dt, spring = omega2 * (dt * dt);
  switch (scene.contact.dashpot) {
    case Dashpot::lagged:
      return spring + 2 * g;
    case Dashpot::pairwise:
      return (spring + 2 * g) / (1 + 0.5 * g);
    case Dashpot::centred:
      break;
  }
  return (spring + 4 * g) / (1 + g);
}

/// The same for the tangential dashpot. The free pair also spins: 7/2 of the compliance in the pairwise denominator.
/// The centred form is judged without one, which is safe for every form in between.
double tangential_term(const Scene& scene, double omega2, double rate, double dt) {
  const double g = rate * dt, spring = omega2 * (dt * dt) + 2 * g;
  return scene.contact.dashpot == Dashpot::pairwise ? spring / (1 + 0.5 * 3.5 * g) : spring;
}

}  // namespace

double rayleigh_time(const Material& m, double r) {
  if (!(m.young > 0)) return k_never;
  const double shear = m.young / (2 * (1 + m.poisson));
  return det::k_pi * r * std::sqrt(m.density / shear) / (0.1631 * m.poisson + 0.8766);
}

std::string describe(const Scene& scene, const ContactCase& c) {
  const std::string& b = scene.materials[static_cast<std::size_t>(c.b)].name;
  const std::string first = fmt::format("{} (r = {:g})", scene.materials[static_cast<std::size_t>(c.a)].name, c.r_a);
  if (c.wall()) return first + " on wall " + b;
  return fmt::format("{} - {}{} (r = {:g})", first, c.fixed_b ? "fixed " : "", b, c.r_b);
}

ContactDynamics dynamics_of(const Scene& scene, const ContactCase& c, double speed, double pressure) {
  const PairCoefficients& k = scene.pair(c.a, c.b);
  const Pair p = pair_of(scene, c);
  return scene.contact.model == ContactModel::linear ? linear_dynamics(scene, k, p)
                                                     : hertz_dynamics(scene, c, k, p, speed, pressure);
}

/// A contact's energy k (n.(u_i - u_j))^2/2 is at most k ((n.u_i)^2 + (n.u_j)^2). Twelve contacts in balance have
/// sum n n = 4, so normal springs alone reach omega^2 = 4 k/m_eff; a fcc crystal does, at the edge of its Brillouin
/// zone. There tangential springs add 4 k_t/m_eff; all grains turning alike reach 8 * 5/2 k_t/m_eff, neighbours turning
/// against each other 8 times the rolling spring over the inertia (and some of the other one). Checked against the
/// dynamical matrix of fcc; other packings have fewer contacts and stay below. A grain that walls enclose from six
/// sides, each at rest: half of that, but that two of the three directions of each add 4 k_t/m.
double packing_mode(const Scene& scene, const ContactDynamics& c, bool wall, double dt) {
  const double n = normal_term(scene, c.normal, c.normal_rate, dt);
  const double t = tangential_term(scene, c.tangential, c.tangential_rate, dt);
  const double turn = 2.5 * t, roll = c.rolling * (dt * dt) + 2 * c.rolling_rate * dt,
               twist = c.twisting * (dt * dt) + 2 * c.twisting_rate * dt;
  const double spins = 8 * fmax2(turn, roll) + 0.8 * fmin2(turn, roll) + 4 * twist;
  const double mode = wall ? fmax2(2 * n + 4 * t, 0.5 * spins) : fmax2(4 * n + 4 * t, spins);
  return mode * (1 + scene.local_damping);  // that brakes, so in the turning points it adds to the force
}

double pair_mode(const Scene& scene, const ContactDynamics& c, double dt) {
  return fmax2(normal_term(scene, c.normal, c.normal_rate, dt),
               3.5 * tangential_term(scene, c.tangential, c.tangential_rate, dt));
}

double effective_stiffness(const Scene& scene, const ContactDynamics& c, double row, double dt) {
  const double plain = row * (dt * dt);
  if (!(c.normal > 0) || !(plain > 0)) return plain;
  ContactDynamics d = c;
  if (scene.contact.model != ContactModel::linear) {
    // of twelve contacts of equal spheres, k/m_eff = 2 k/m: dashpots of Hertz contacts go as the root of the stiffness
    const double scale = row / 6 / c.normal, root = std::sqrt(scale);
    for (double* omega2 : {&d.normal, &d.tangential, &d.rolling, &d.twisting}) *omega2 *= scale;
    for (double* rate : {&d.normal_rate, &d.tangential_rate, &d.rolling_rate, &d.twisting_rate}) *rate *= root;
  }
  return plain * packing_mode(scene, d, false, dt) / (4 * d.normal * (dt * dt));
}

}  // namespace talus
