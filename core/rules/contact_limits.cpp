// See contact_limits.hpp. det_math is used although nothing here feeds the trajectory, so that a step which is just
// accepted on one machine is not refused on another.
#include "core/rules/contact_limits.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/base/det_math.hpp"
#include "core/grains/body.hpp"
#include "core/rules/laws/law.hpp"

namespace talus {
namespace {

/// Rolling and twisting springs k = 9/4 k_n mu^2 R*^2 (kernels/models/moments.hpp). The dashpot of share eta of the
/// critical one refers to the inertia 7/5 m r^2 (rolling) or 2/5 m r^2 (twisting).
void add_moments(const Scene& scene, const PairCoefficients& k, const ReducedPair& p, ContactDynamics& d) {
  const auto squared = [&](double mu) { return 2.25 * d.stiffness * (mu * p.r) * (mu * p.r) * p.spins; };
  d.rolling = scene.contact.rolling == Rolling::epsd ? squared(k.rolling_friction) : 0;
  d.rolling_rate = 2 * k.rolling_damping * std::sqrt(3.5 * d.rolling);
  d.twisting = squared(k.twisting_friction);
  d.twisting_rate = 2 * k.twisting_damping * std::sqrt(d.twisting);
}

ReducedPair pair_of(const Scene& scene, const ContactCase& c) {
  const Body a{c.r_a, scene.materials[static_cast<std::size_t>(c.a)].density};
  const double m_a = c.weight_a * a.mass(), inertia_a = c.weight_a * a.inertia();
  if (c.wall()) return {m_a, c.r_a, 1 / inertia_a};
  const double r = c.r_a * c.r_b / (c.r_a + c.r_b);
  if (c.fixed_b) return {m_a, r, 1 / inertia_a};
  const Body b{c.r_b, scene.materials[static_cast<std::size_t>(c.b)].density};
  const double m_b = c.weight_b * b.mass();
  return {m_a / (m_a + m_b) * m_b, r, 1 / inertia_a + 1 / (c.weight_b * b.inertia())};
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
  const auto name = [&](int material) { return scene.materials[static_cast<std::size_t>(material)].name; };
  const auto grain = [&](int material, double r, double weight) {
    return weight == 1 ? fmt::format("{} (r = {:g})", name(material), r)
                       : fmt::format("{} (body, radius of curvature {:g})", name(material), r);
  };
  const std::string first = grain(c.a, c.r_a, c.weight_a);
  if (c.wall()) return first + " on wall " + name(c.b);
  return fmt::format("{} - {}{}", first, c.fixed_b ? "fixed " : "", grain(c.b, c.r_b, c.weight_b));
}

ContactDynamics dynamics_of(const Scene& scene, const ContactCase& c, double speed, double pressure) {
  const ReducedPair p = pair_of(scene, c);
  ContactDynamics d = law_of(scene).dynamics(scene, c, p, speed, pressure);
  add_moments(scene, scene.pair(c.a, c.b), p, d);
  return d;
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
  if (law_of(scene).by_modulus) {
    // of twelve contacts of equal spheres, k/m_eff = 2 k/m: dashpots of Hertz contacts go as the root of the stiffness
    const double scale = row / 6 / c.normal, root = std::sqrt(scale);
    for (double* omega2 : {&d.normal, &d.tangential, &d.rolling, &d.twisting}) *omega2 *= scale;
    for (double* rate : {&d.normal_rate, &d.tangential_rate, &d.rolling_rate, &d.twisting_rate}) *rate *= root;
  }
  return plain * packing_mode(scene, d, false, dt) / (4 * d.normal * (dt * dt));
}

}  // namespace talus
