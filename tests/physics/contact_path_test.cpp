// Contacts driven along prescribed paths: closed shear-unload-shear loops never create energy, and a rigid motion of a
// touching pair creates no force (objectivity, VERIFICATION 3.7).
#include <gtest/gtest.h>

#include <cmath>

#include "kernel_contact.hpp"
#include "physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_radius = 0.01;

enum class Law { linear, hertz, partial_slip };
constexpr Law k_laws[] = {Law::linear, Law::hertz, Law::partial_slip};

std::string name_of(Law law) { return law == Law::linear ? "linear" : law == Law::hertz ? "hertz" : "partial slip"; }

/// e, or the damping rates of the linear law [1/s].
void set_law(Scene& s, Law law, double mu, double e, double rate) {
  if (law == Law::linear)
    linear_law(s, 1e5, rate, 8e4, rate, mu);
  else
    hertz_law(s, e, mu);
  s.contact.partial_slip = law == Law::partial_slip;
}

Scene law_scene(Law law, double mu, double dt) {
  Scene s = open_scene({0, 0, 0}, {1, 1, 1}, dt);
  s.materials[0].young = 1e8;
  s.materials[0].poisson = 0.25;
  set_law(s, law, mu, 1, 0);
  s.contact.friction = true;
  return s;
}

/// Corner of a path: overlap and shear displacement, as shares of the unit overlap.
struct Corner {
  double overlap, shear;
};

struct Ledger {
  double work = 0;        ///< done on the contact over the whole path [J]
  double lowest = 0;      ///< least running total of work [J]
  double scale = 0;       ///< largest stored energy [J]
  double worst = 0;       ///< largest |work - stored - lost| [J]
  double least_loss = 0;  ///< least friction loss of one step [J]
};

/// Drives the contact through the corners in straight lines of `steps` steps; starts from zero overlap.
Ledger drive(Law law, double mu, const std::vector<Corner>& corners, int steps) {
  const double unit = 1e-3 * k_radius;
  const Scene s = law_scene(law, mu, 1e-6);
  KernelContact contact(s, k_radius, k_radius, 2 / sphere_mass(2500, k_radius));
  Ledger out;
  Vec3 x{0, 0, 2 * k_radius}, force;
  Corner at{0, 0};
  double lost = 0;
  for (const Corner& to : corners) {
    for (int k = 1; k <= steps; ++k) {
      const double q = static_cast<double>(k) / steps;
      const double overlap = unit * (at.overlap + q * (to.overlap - at.overlap));
      const double shear = unit * (at.shear + q * (to.shear - at.shear));
      // the normal stays along z but for the shear's angle of 1e-3
      const double d = 2 * k_radius - overlap;
      const Vec3 now{shear, 0, std::sqrt(d * d - shear * shear)};
      const auto r = contact.step(now, (1 / s.dt) * (now - x), {0, 0, 0});
      out.work -= dot(0.5 * (force + r.force), now - x);  // the driver's work: against the force on i
      lost += r.friction;
      out.least_loss = std::min(out.least_loss, r.friction);
      out.lowest = std::min(out.lowest, out.work);
      out.scale = std::max(out.scale, r.elastic);
      out.worst = std::max(out.worst, std::fabs(out.work - r.elastic - lost));
      force = r.force;
      x = now;
    }
    at = to;
  }
  return out;
}

/// Load, shear, unload, shear back, and so on; the second is the first with the shears swapped, the third runs
/// backwards.
const std::vector<std::pair<const char*, std::vector<Corner>>> k_loops = {
    {"shear at high load, back at low load",
     {{2, 0}, {2, 0.5}, {0.5, 0.5}, {0.5, 0}, {2, 0}, {2, 0.5}, {0.5, 0.5}, {0.5, 0}, {2, 0}}},
    {"mirrored: shear at low load, back at high load",
     {{0.5, 0}, {0.5, 0.5}, {2, 0.5}, {2, 0}, {0.5, 0}, {0.5, 0.5}, {2, 0.5}, {2, 0}, {0.5, 0}}},
    {"both signs",
     {{2, 0}, {2, 0.4}, {0.5, 0.4}, {0.5, -0.4}, {2, -0.4}, {2, 0.4}, {0.5, 0.4}, {0.5, -0.4}, {2, -0.4}, {2, 0}}},
    {"unload to nothing", {{2, 0}, {2, 0.5}, {1e-6, 0.5}, {1e-6, 0}, {2, 0}, {1e-6, 0}}}};

void check_loops(Law which, double mu) {
  const std::string law = name_of(which) + " mu " + std::to_string(mu).substr(0, 4);
  for (const auto& [name, corners] : k_loops) {
    const Ledger l = drive(which, mu, corners, 20000);
    figure(law + ", " + name + ": work of the loops / stored energy", l.work / l.scale);
    figure(law + ", " + name + ": ledger error / stored energy", l.worst / l.scale);
    // The trapezoidal work of the path and the law's ledger follow the same rule: the linear law closes to rounding,
    // the changing contact radius of Hertz leaves a second-order rest at 20000 steps per side.
    EXPECT_GT(l.lowest, -1e-9 * l.scale) << name;
    EXPECT_GT(l.least_loss, -1e-12 * l.scale) << name;
    EXPECT_LT(l.worst, 1e-7 * l.scale) << name;
  }
}

TEST(PhysicsContactPath, HertzLoopsNeverCreateEnergyWithoutSliding) { check_loops(Law::hertz, 100); }
TEST(PhysicsContactPath, HertzLoopsNeverCreateEnergyWithSliding) { check_loops(Law::hertz, 0.2); }
TEST(PhysicsContactPath, PartialSlipLoopsNeverCreateEnergyWithoutSliding) { check_loops(Law::partial_slip, 100); }
TEST(PhysicsContactPath, PartialSlipLoopsNeverCreateEnergyWithSliding) { check_loops(Law::partial_slip, 0.2); }
TEST(PhysicsContactPath, LinearLoopsNeverCreateEnergyWithoutSliding) { check_loops(Law::linear, 100); }
TEST(PhysicsContactPath, LinearLoopsNeverCreateEnergyWithSliding) { check_loops(Law::linear, 0.2); }

TEST(PhysicsContactPath, RandomClosedLoopsNeverCreateEnergy) {
  // From a virgin contact the driver's total can never fall below zero, whatever the path.
  double lowest = 0;
  for (int seed = 0; seed < 200; ++seed) {
    std::vector<Corner> corners;
    for (int k = 0; k < 12; ++k)
      corners.push_back({0.05 + 2 * uniform(7 + seed, 2 * k), 2 * uniform(7 + seed, 2 * k + 1) - 1});
    corners.push_back({0.01, 0});
    const Ledger l = drive(k_laws[std::min(seed % 4, 2)], seed % 3 == 0 ? 100 : 0.3, corners, 1000);
    lowest = std::min(lowest, l.lowest / l.scale);
  }
  figure("200 random loops: least work / stored energy", lowest);
  EXPECT_GT(lowest, -1e-6);  // 1000 steps per side
}

TEST(PhysicsContactPath, SlidingHeatsTheSliderAndNotTheDashpot) {
  // Spins drive a contact of fixed overlap steadily: after the first steps all work is friction, |F_t| times the way.
  for (const Law which : k_laws) {
    Scene s = law_scene(which, 0.3, 1e-6);
    set_law(s, which, 0.3, 0.5, 800);
    KernelContact contact(s, k_radius, k_radius, 2 / sphere_mass(2500, k_radius));
    const double d = 2 * k_radius * (1 - 5e-4), spin = 0.5;
    double work = 0, friction = 0, damping = 0;
    for (int k = 0; k < 4000; ++k) {
      const auto r = contact.step({0, 0, d}, {0, 0, 0}, {0, spin, 0});
      if (k < 2000) continue;
      work += std::fabs(r.force.x) * (d / (2 * k_radius)) * spin * s.dt;
      friction += r.friction;
      damping += r.damping;
    }
    const std::string law = name_of(which);
    figure(law + ", steady sliding: friction loss / work - 1", friction / work - 1);
    figure(law + ", steady sliding: damping loss / work", damping / work);
    EXPECT_GT(work, 0);
    EXPECT_NEAR(friction / work, 1, 1e-6);
    EXPECT_LT(std::fabs(damping), 1e-6 * work);
  }
}

/// Losses of a grain that starts to slide on a plane at `speed`, over m v^2/7: what sliding takes until it rolls,
/// whatever the friction.
struct Stopped {
  double friction, damping;
};

Stopped slide_to_rolling(Law law, double speed) {
  const double r = k_radius, g = 9.81, mu = 0.3;
  Scene s = law_scene(law, mu, 2e-6);
  set_law(s, law, mu, 0.5, 800);
  s.contact.friction = true;
  s.gravity = {0, 0, -g};
  s.output.energies = s.allow_initial_overlap = true;
  s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
  const double m = sphere_mass(2500, r);
  const double e_star = 0.5 * 1e8 / (1 - 0.0625);
  const double rest =
      law != Law::linear ? std::pow(m * g / (4.0 / 3.0 * e_star * std::sqrt(r)), 2.0 / 3.0) : m * g / 1e5;
  add_grains(s, {{{0.1, 0.5, r - rest}, {speed, 0, 0}, r}});
  Simulation sim(s, options());
  // v - w r falls at 7/2 mu g: rolls after 2/7 v/(mu g)
  sim.run(std::llround(1.5 * (2.0 / 7.0) * speed / (mu * g) / s.dt));
  const Energies e = sim.energies();
  const double sliding = m * speed * speed / 7;
  return {e.dissipated_friction / sliding, e.dissipated_damping / sliding};
}

TEST(PhysicsContactPath, SlidingToRollingIsBookedAsFriction) {
  for (const Law which : k_laws) {
    const Stopped b = slide_to_rolling(which, 0.5);
    const std::string law = name_of(which);
    figure(law + ", from sliding to rolling: friction loss / (m v^2/7)", b.friction);
    figure(law + ", from sliding to rolling: damping loss / (m v^2/7)", b.damping);
    EXPECT_NEAR(b.friction, 1, 1e-2);
    EXPECT_LT(std::fabs(b.damping), 1e-2);
  }
}

/// Rigid rotation of a touching pair about an axis through its centre, with spins: largest tangential force over one
/// turn relative to k_t times the arc that the contact point travels.
double rigid_rotation(Law law, bool synchronised, Vec3 axis, int steps) {
  const double dt = 1e-6, angle = 2 * k_pi / steps, overlap = 1e-3 * k_radius, d = 2 * k_radius - overlap;
  Scene s = law_scene(law, 100, dt);
  s.contact.synchronised = synchronised;
  KernelContact contact(s, k_radius, k_radius, 2 / sphere_mass(2500, k_radius));
  const Vec3 n0{1, 0, 0}, n1 = cross(axis, n0);
  const double along = dot(axis, n0);
  const auto position = [&](double turn) {  // Rodrigues
    return d * (std::cos(turn) * n0 + std::sin(turn) * n1 + ((1 - std::cos(turn)) * along) * axis);
  };
  const Vec3 spin = (2 * k_radius * angle / dt) * axis;
  const auto at_rest = contact.step(position(0), {0, 0, 0}, {0, 0, 0});
  const double normal = norm(at_rest.force);
  double worst = 0;
  Vec3 old = position(0);
  for (int k = 1; k <= steps; ++k) {
    const Vec3 x = position(k * angle);
    const auto r = contact.step(x, (1 / dt) * (x - old), spin);
    worst = std::max(worst, norm(r.force - (normal / norm(x)) * x));
    old = x;
  }
  return worst / normal;
}

TEST(PhysicsContactPath, RigidRotationCreatesNoForce) {
  const Vec3 axes[] = {{0, 0, 1}, {0, 0.6, 0.8}, {0.48, 0.6, 0.64}};
  for (const Law which : k_laws) {
    const std::string law = name_of(which);
    for (const Vec3& axis : axes) {
      const double coarse = rigid_rotation(which, true, axis, 10000), fine = rigid_rotation(which, true, axis, 20000);
      figure(law + ": force of one rigid turn in 1e4 steps / normal force", coarse);
      figure(law + ": ratio for half the step", coarse / fine);
      EXPECT_LT(coarse, 1e-3);
      // the chord and the arc differ by (angle)^2/24 per step, summed over a turn: second order
      EXPECT_GT(coarse / fine, 1.9);
    }
    const double plain = rigid_rotation(which, false, {0, 0, 1}, 10000);
    figure(law + ", not synchronised: force of one rigid turn in 1e4 steps / normal force", plain);
    EXPECT_GT(plain, 1.5 * rigid_rotation(which, true, {0, 0, 1}, 10000));  // the control: the form matters
  }
}

TEST(PhysicsContactPath, RigidTranslationCreatesNoForce) {
  const Scene s = law_scene(Law::hertz, 100, 1e-6);
  KernelContact contact(s, k_radius, k_radius, 2 / sphere_mass(2500, k_radius));
  const Vec3 x{1.2 * k_radius, 0, 1.598 * k_radius};
  const Vec3 first = contact.step(x, {0, 0, 0}, {0, 0, 0}).force;
  for (int k = 0; k < 1000; ++k) {
    const Vec3 f = contact.step(x, {0, 0, 0}, {0, 0, 0}).force;
    EXPECT_EQ(f.x, first.x);
    EXPECT_EQ(f.z, first.z);
  }
}

}  // namespace
}  // namespace talus::physics
