// Time scales of one contact at the largest overlap that a scene lets expect: its duration, its frequencies and damping
// rates, and what they add up to in a packing at a given step. Who calls it: core/rules/timestep.cpp. Nothing here
// feeds the trajectory. Formulae are stated next to the code.
#pragma once

#include <string>

#include "core/scene/scene.hpp"

namespace talus {

/// Two particles, or a particle and a wall (r_b = infinity: infinite mass, flat). A fixed particle has infinite mass.
struct ContactCase {
  int a = 0, b = 0;         ///< materials
  double r_a = 0, r_b = 0;  ///< [m]
  bool fixed_b = false;
  double weight_a = 1, weight_b = 1;  ///< mass that answers a force / that of a sphere (GrainKind)
  bool wall() const noexcept { return r_b == k_never; }
};

std::string describe(const Scene& scene, const ContactCase& c);

/// Two particles as one against a point at rest.
struct ReducedPair {
  double m, r;   ///< mass [kg] and radius [m]
  double spins;  ///< 1 / moment of inertia [1/(kg m2)]
};

/// Squared frequencies [1/s2] of the free pair, that is stiffness over reduced mass, for rolling and twisting over the
/// reduced moment of inertia; damping rates [1/s] likewise.
struct ContactDynamics {
  double duration = 0;   ///< of an impact [s]
  double stiffness = 0;  ///< normal [N/m]
  double normal = 0, tangential = 0, rolling = 0, twisting = 0;
  double normal_rate = 0, tangential_rate = 0, rolling_rate = 0, twisting_rate = 0;
};

/// At an impact with `speed` [m/s] or under a load of `pressure` [Pa] times the smaller particle's (2 r)^2, whatever
/// strains a Hertz contact more; without both at a strain of about 1e-4.
ContactDynamics dynamics_of(const Scene& scene, const ContactCase& c, double speed, double pressure);

/// Largest omega^2 dt^2 of a packing all of whose contacts are such ones; with 4 the motion that alternates from step
/// to step grows, which it does before any other.
double packing_mode(const Scene& scene, const ContactDynamics& c, bool wall, double dt);

/// The same of one contact by itself: its own directions, 7/2 of the compliance tangentially.
double pair_mode(const Scene& scene, const ContactDynamics& c, double dt);

/// Sum of the contact stiffnesses of a particle over its mass, times dt^2, with what dashpots and tangential springs of
/// contacts like `c` add: up to 2 any arrangement of contacts is stable (sum k (n.u)^2 <= sum k u^2). `row` [1/s2].
double effective_stiffness(const Scene& scene, const ContactDynamics& c, double row, double dt);

/// pi r sqrt(rho / G) / (0.1631 nu + 0.8766) [s]; infinite without Young's modulus.
double rayleigh_time(const Material& m, double r);

}  // namespace talus
