// Helpers of the verification ladder: reporting, impacts of spheres on planes and on each other, packs of grains that
// have just been let fall. Who calls it: tests/verification. Invariants: every measured figure appears in a line that
// starts with "figure:"; the longer variants run only with TALUS_FULL=1.
#pragma once

#include <string>
#include <vector>

#include "tests/physics/physics_support.hpp"

namespace talus::verification {

using physics::add_grains;
using physics::Grain;
using physics::hertz_law;
using physics::k_pi;
using physics::linear_law;
using physics::linear_restitution;
using physics::log_slope;
using physics::open_scene;
using physics::options;
using physics::plane;
using physics::quantile;
using physics::sphere_mass;
using physics::uniform;

/// Prints "figure: name value note" and records the value in the test's XML.
void figure(const std::string& name, double value, const std::string& note = {});
/// TALUS_FULL is set: run the long variant.
bool full();

/// Slope and intercept of the least-squares line, and the standard error of the slope (independent residuals).
struct Line {
  double slope = 0, intercept = 0, error = 0;
};
Line fit_line(const std::vector<double>& x, const std::vector<double>& y);

/// Density that gives a sphere of radius r the mass m.
double density_of(double mass, double r);
/// Damping ratio of the linear law for restitution e.
double damping_ratio(double e);
/// Normally distributed number of draw k (Box-Muller; test only, platform bits do not matter).
double gauss(std::uint64_t seed, std::uint64_t k);

/// Elastic constants of a Hertz contact.
struct Hertz {
  double k = 0;                    ///< 4/3 E* sqrt(R*) [N/m^1.5]
  double alpha = 0;                ///< damping of Antypov & Elliott (2011) [-]
  double m = 0;                    ///< effective mass [kg]
  double depth(double v) const;    ///< largest overlap of an elastic impact [m]
  double contact(double v) const;  ///< duration of an elastic impact [s]
};
/// Sphere of `a` on a rigid wall (r_b = 0) or on a sphere of `b`.
Hertz hertz_contact(const Material& a, double r_a, const Material& b, double r_b, double e);

/// What friction_limit = "total" makes of a damped normal impact: impulse of the repulsive part over the whole one,
/// m (1 + e) v. The dashpot's tail pulls, friction is cut there, so that gross sliding takes mu times this share.
/// Independent of the speed for both laws. Linear: closed form. Hertz: integrated here with graded steps.
double repulsive_share_linear(double e);
double repulsive_share_hertz(double e);

}  // namespace talus::verification
