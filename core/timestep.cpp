// Limits of the time step. Nothing here feeds the trajectory; det_math is used all the same, so that a step which is
// just accepted on one machine is not refused on another.
#include "core/timestep.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/adhesion.hpp"
#include "core/det_math.hpp"
#include "core/error.hpp"
#include "core/restitution.hpp"

namespace talus {
namespace {

constexpr double k_packing_share = 0.4;  ///< an fcc packing is stable up to 0.42 of the pair limit with k_t = 2/7 k_n
constexpr double k_warning_share = 0.2;

/// Which materials particles and walls have. A file may name any material.
struct Roles {
  std::vector<char> particle, wall;
};

Roles roles_of(const Scene& scene) {
  const std::size_t n = scene.materials.size();
  Roles roles{std::vector<char>(n), std::vector<char>(n)};
  bool any = scene.sources.empty();
  for (const Source& s : scene.sources) {
    any = any || s.kind == Source::Kind::file;
    roles.particle[static_cast<std::size_t>(s.material)] = 1;
  }
  if (any) roles.particle.assign(n, 1);
  for (const WallSpec& w : scene.walls) roles.wall[static_cast<std::size_t>(w.material)] = 1;
  for (const auto& axis : scene.domain.boundary) {
    for (Boundary side : axis) {
      if (side == Boundary::wall) roles.wall[static_cast<std::size_t>(scene.domain.wall_material)] = 1;
    }
  }
  return roles;
}

/// Largest speed that the scene itself states: sources, walls, driven groups, and the fall through the domain's height.
double scene_speed(const Scene& scene) {
  double v = 0;
  for (const Source& s : scene.sources) v = fmax2(v, std::sqrt(norm2(s.velocity)) + std::sqrt(3.0) * s.velocity_jitter);
  for (const WallSpec& w : scene.walls) {
    const WallMotion& m = w.motion;
    v = fmax2(v, std::sqrt(norm2(m.velocity)) + 2 * det::k_pi * m.frequency * std::sqrt(norm2(m.amplitude)));
  }
  double fall = 0;
  const auto gravity = [&](Vec3 g) {
    for (int k = 0; k < 3; ++k) fall = fmax2(fall, std::fabs(g[k]) * (scene.domain.upper[k] - scene.domain.lower[k]));
  };
  gravity(scene.gravity);
  for (const Event& e : scene.events) {
    if (e.action == Event::Action::gravity)
      gravity(e.vector);
    else
      v = fmax2(v, std::sqrt(norm2(e.vector)));
  }
  return fmax2(v, std::sqrt(fall));
}

/// Two particles, or a particle and a wall (r_b = infinity: infinite mass, flat).
struct Contact {
  std::size_t a, b;
  double r_a, r_b;
};

std::string describe(const Scene& scene, const Contact& c) {
  const std::string first = fmt::format("{} (r = {:g})", scene.materials[c.a].name, c.r_a);
  if (c.r_b == k_never) return first + " on wall " + scene.materials[c.b].name;
  return fmt::format("{} - {} (r = {:g})", first, scene.materials[c.b].name, c.r_b);
}

double mass(double density, double r) { return density * (4.0 / 3.0 * det::k_pi) * (r * r * r); }

/// Limits of one contact: duration, 2 / sqrt(k / m_eff), and the share of the latter that a packing tolerates.
struct Limits {
  double contact, pair, packing_share;
};

/// What the packing limit loses. Tangential springs: the stiffest mode of an fcc packing has omega^2 = (7.9 + 12.5
/// k_t/k_n) k/m, from the measured limits 0.71 and 0.59 sqrt(m/k) without and with k_t = 2/7 k_n. Damping: an explicit
/// dashpot of damping ratio z lowers the limit by sqrt(1 + z^2) - z; the ratio of that mode is sqrt(omega^2 /
/// omega_pair^2) = 2.4 times the pair's. The centred dashpot takes the forces of other contacts from the last step.
/// With L = 2.4^2 times the pair's stiffness the mode u' = u + L f, f (1 + g/2) = -(kappa x + g u + g/2 (L - 1)
/// f_last), g = gamma dt, turns unstable (z = -1) at omega^2 dt^2/4 + g (L - 1) = 1: as an explicit dashpot of ratio 2
/// (1 - 1/L) z.
double packing_share(double stiffness_ratio, double damping_ratio, Dashpot dashpot) {
  const double stiff =
      stiffness_ratio > 2.0 / 7.0 ? std::sqrt((7.9 + 12.5 * 2.0 / 7.0) / (7.9 + 12.5 * stiffness_ratio)) : 1;
  const double z = (dashpot == Dashpot::centred ? 2 * (2.4 - 1 / 2.4) : 2.4) * damping_ratio;
  return k_packing_share * stiff * (std::sqrt(1 + z * z) - z);
}

/// Rolling and twisting springs k = 9/4 k_n mu^2 R*^2 on free spins 2/5 m r^2 (kernels/models/moments.hpp), as limit of
/// an isolated pair; infinite without them. An explicit dashpot of ratio z costs sqrt(1 + z^2) - z, and eta_r refers to
/// 7/5 m r^2: z = sqrt(7/2) eta_r on the free spin.
double spin_limit(const Scene& scene, const PairCoefficients& k, double stiffness, double r_eff, double compliance) {
  const double mu = scene.contact.rolling == Rolling::epsd ? k.rolling_friction : 0;
  const double z = std::sqrt(3.5) * k.rolling_damping;
  const auto limit = [&](double coefficient, double share) {
    const double omega2 = 2.25 * stiffness * (coefficient * r_eff) * (coefficient * r_eff) * compliance;
    return omega2 > 0 ? share * 2 / std::sqrt(omega2) : k_never;
  };
  const double y = k.twisting_damping;
  return fmin2(limit(mu, std::sqrt(1 + z * z) - z), limit(k.twisting_friction, std::sqrt(1 + y * y) - y));
}

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

Limits limits_of(const Scene& scene, const Contact& c, double velocity) {
  const bool wall = c.r_b == k_never;
  const Material &a = scene.materials[c.a], &b = scene.materials[c.b];
  const PairCoefficients& k = scene.pair(static_cast<int>(c.a), static_cast<int>(c.b));
  const double m_a = mass(a.density, c.r_a);
  const double m = wall ? m_a : m_a / (m_a + mass(b.density, c.r_b)) * mass(b.density, c.r_b);
  const double pi = det::k_pi;
  const double r = wall ? c.r_a : c.r_a * c.r_b / (c.r_a + c.r_b);
  const double spins = 2.5 / (m_a * c.r_a * c.r_a) + (wall ? 0 : 2.5 / (mass(b.density, c.r_b) * c.r_b * c.r_b));
  const auto coefficient = [&](DampedSpring spring) {
    return k.restitution > 0 ? damping_coefficient(k.restitution, spring, scene.contact.clip_tension) : 0;
  };
  if (scene.contact.model == ContactModel::linear) {
    const double stiffness = scene.contact.normal_stiffness;
    const double omega = std::sqrt(stiffness / m);
    const double z = scene.contact.by_restitution ? 0.5 * coefficient(DampedSpring::linear)
                                                  : 0.5 * scene.contact.normal_damping / omega;
    // t_c = pi / sqrt(k/m - (g/2)^2); an overdamped contact never rebounds, its undamped time is the scale
    const double contact = pi / (omega * (z < 1 ? std::sqrt(1 - z * z) : 1));
    const double kt = scene.contact.friction ? scene.contact.tangential_stiffness / stiffness : 0;
    return {contact, fmin2(2 / omega, spin_limit(scene, k, stiffness, r, spins)),
            packing_share(kt, z, scene.contact.dashpot)};
  }
  const double e_star = 1 / ((1 - a.poisson * a.poisson) / a.young + (1 - b.poisson * b.poisson) / b.young);
  const double g_star =
      1 / ((2 - a.poisson) * 2 * (1 + a.poisson) / a.young + (2 - b.poisson) * 2 * (1 + b.poisson) / b.young);
  // A scene at rest without gravity states no speed: take the one that strains a contact by about 1e-4.
  const double v = velocity > 0 ? velocity : 1e-5 * std::sqrt(e_star / a.density);
  // delta_max = (15 m v^2 / (16 E* sqrt(R)))^(2/5), t_c = 2.9433 delta_max / v; tangent stiffness 2 E* sqrt(R
  // delta_max)
  const double delta = det::pow(15 * m * (v * v) / (16 * e_star * std::sqrt(r)), 0.4);
  double radius = std::sqrt(r * delta);
  double contact = 2.9433 * delta / v;
  if (const double kappa = adhesion_length(scene, static_cast<int>(c.a), static_cast<int>(c.b)); kappa > 0) {
    // adhesion pulls the contact open wider than the impact alone; 4.03 / omega is the same duration for Hertz
    radius = jkr_radius(kappa, e_star, r, m, v);
    contact = 2.9433 * std::sqrt(15.0 / 8.0) / std::sqrt(2 * e_star * radius / m);
  }
  const double omega = std::sqrt(2 * e_star * radius / m);
  // alpha sqrt(m k) delta^(1/4) with k = 4/3 E* sqrt(R): ratio alpha / sqrt(6) of the tangent stiffness 3/2 k
  // sqrt(delta)
  const double z = coefficient(DampedSpring::hertz) / std::sqrt(6.0);
  return {contact, fmin2(2 / omega, spin_limit(scene, k, 2 * e_star * radius, r, spins)),
          packing_share(scene.contact.friction ? 4 * g_star / e_star : 0, z, scene.contact.dashpot)};
}

double rayleigh(const Material& m, double r) {
  if (!(m.young > 0)) return k_never;
  const double shear = m.young / (2 * (1 + m.poisson));
  return det::k_pi * r * std::sqrt(m.density / shear) / (0.1631 * m.poisson + 0.8766);
}

void keep_smaller(TimeStepLimit& limit, double seconds, const Scene& scene, const Contact& c) {
  if (seconds < limit.seconds) limit = {seconds, describe(scene, c)};
}

std::string line(const char* name, double dt, const TimeStepLimit& limit) {
  if (limit.seconds == k_never) return fmt::format("{:<20} none", name);
  return fmt::format("{:<20} {:.4g} s, step is {:.3g} of it; {}", name, limit.seconds, dt / limit.seconds, limit.pair);
}

/// A wall that moves by more than a radius per step could pass a grain unseen. Returns a warning or nothing.
std::string judge_walls(const Scene& scene, double r_min) {
  std::string warning;
  for (const WallSpec& w : scene.walls) {
    const WallMotion& m = w.motion;
    const double speed = std::sqrt(norm2(m.velocity)) + 2 * det::k_pi * m.frequency * std::sqrt(norm2(m.amplitude));
    const double travel = speed * scene.dt / r_min;
    if (!(travel > scene.monitor.warn_travel)) continue;
    const std::string what = fmt::format(
        "wall '{}' moves by up to {:.3g} of the smallest radius in one step ({:.4g} m/s)", w.name, travel, speed);
    if (travel > scene.monitor.max_travel)
      throw Error(ErrorCode::scene, what + ": it could pass particles unseen", scene.file,
                  fmt::format("a time.step of at most {:.3g} s, or a larger checks.max_travel",
                              scene.dt * scene.monitor.warn_travel / travel));
    if (warning.empty()) warning = what;
  }
  return warning;
}

}  // namespace

TimeStepReport time_step_limits(const Scene& scene, double r_min, double r_max, double speed,
                                std::span<const char> materials) {
  TimeStepReport report;
  report.dt = scene.dt;
  if (!(scene.dt > 0) || !std::isfinite(scene.dt))
    throw Error(ErrorCode::scene, fmt::format("time.step: {}: must be a number > 0 [s]", scene.dt), scene.file);
  if (!(r_min > 0)) return report;  // no particle can ever appear
  if (scene.contact.model != ContactModel::linear) report.velocity = fmax2(speed, scene_speed(scene));
  Roles roles = roles_of(scene);
  if (!materials.empty()) roles.particle.assign(materials.begin(), materials.end());
  const std::size_t n = scene.materials.size();
  for (std::size_t a = 0; a < n; ++a) {
    if (!roles.particle[a]) continue;
    const auto consider = [&](const Contact& c) {
      const Limits l = limits_of(scene, c, report.velocity);
      keep_smaller(report.contact, l.contact, scene, c);
      keep_smaller(report.isolated_pair, l.pair, scene, c);
      keep_smaller(report.packing, l.packing_share * l.pair, scene, c);
    };
    for (double r_a : {r_min, r_max}) {
      if (const double t = rayleigh(scene.materials[a], r_a); t < report.rayleigh.seconds)
        report.rayleigh = {t, fmt::format("{} (r = {:g})", scene.materials[a].name, r_a)};
      for (std::size_t b = 0; b < n; ++b) {
        if (roles.particle[b] && b >= a) {
          for (double r_b : {r_min, r_max}) consider({a, b, r_a, r_b});
        }
        if (roles.wall[b]) consider({a, b, r_a, k_never});
      }
    }
  }
  const double shortest = fmin2(report.rayleigh.seconds, report.contact.seconds);
  report.share = scene.dt / shortest;
  report.lines = {line("Rayleigh time", scene.dt, report.rayleigh), line("contact time", scene.dt, report.contact),
                  line("isolated pair limit", scene.dt, report.isolated_pair),
                  line("packing limit", scene.dt, report.packing)};
  if (report.velocity > 0) report.lines.push_back(fmt::format("{:<20} {:.4g} m/s", "judged at speed", report.velocity));

  if (scene.dt > report.packing.seconds) {
    const std::string what = fmt::format("time.step: {:g}: above the packing limit {:.4g} s of {}", scene.dt,
                                         report.packing.seconds, report.packing.pair);
    if (!scene.allow_unstable_step)
      throw Error(
          ErrorCode::scene, what, scene.file,
          fmt::format("at most {:.4g} s is allowed, or set checks.allow_unstable_step", report.packing.seconds));
    report.warning = what;
  } else if (report.share > k_warning_share) {
    const bool by_rayleigh = report.rayleigh.seconds < report.contact.seconds;
    report.warning = fmt::format("time.step: {:g}: {:.0f} % of the {} time {:.4g} s of {}; 20 % or less is advised",
                                 scene.dt, 100 * report.share, by_rayleigh ? "Rayleigh" : "contact", shortest,
                                 (by_rayleigh ? report.rayleigh : report.contact).pair);
  }
  const std::string walls = judge_walls(scene, r_min);
  if (report.warning.empty()) report.warning = walls;
  return report;
}

Softening softening(const Scene& scene, double r_max, double speed) {
  Softening s;
  s.speed = fmax2(speed, scene_speed(scene));
  if (!(r_max > 0)) return s;
  constexpr double target = 0.01;  // overlap / radius
  const Roles roles = roles_of(scene);
  double heaviest = 0, compliance = 0;  // of the materials that particles can have
  for (std::size_t a = 0; a < scene.materials.size(); ++a) {
    const Material& m = scene.materials[a];
    if (!roles.particle[a]) continue;
    heaviest = fmax2(heaviest, m.density);
    if (m.young > 0) compliance = fmax2(compliance, 2 * (1 - m.poisson * m.poisson) / m.young);
  }
  const double m = mass(heaviest, r_max);
  double weight = 0;  // g H along the axes
  for (int k = 0; k < 3; ++k) weight += std::fabs(scene.gravity[k]) * (scene.domain.upper[k] - scene.domain.lower[k]);
  s.load = 0.6 * heaviest * weight * (4 * r_max * r_max);
  double impact = 0, pressed = 0;  // overlaps / radius
  if (scene.contact.model == ContactModel::linear) {
    const double k = scene.contact.normal_stiffness;
    impact = s.speed * std::sqrt(m / k) / r_max;
    pressed = s.load / k / r_max;
    // stiffness for the target: impact ~ k^-1/2, weight ~ k^-1
    s.factor = fmax2((impact / target) * (impact / target), pressed / target);
    s.step_factor = s.factor > 0 ? 1 / std::sqrt(s.factor) : 0;
  } else {
    const double e_star = 1 / compliance;
    impact = det::pow(15 * m * (s.speed * s.speed) / (16 * e_star * std::sqrt(r_max)), 0.4) / r_max;
    pressed = det::pow(3 * s.load / (4 * e_star * std::sqrt(0.5 * r_max)), 2.0 / 3.0) / r_max;
    // impact ~ E^-2/5, weight ~ E^-2/3; the contact time goes as E^-2/5
    s.factor = fmax2(det::pow(impact / target, 2.5), det::pow(pressed / target, 1.5));
    s.step_factor = s.factor > 0 ? det::pow(s.factor, -0.4) : 0;
  }
  s.by_impact = impact >= pressed;
  s.overlap = fmax2(impact, pressed);
  return s;
}

StepAdvice step_advice(const TimeStepReport& report) {
  StepAdvice a;
  a.accurate = fmin2(report.packing.seconds, fmin2(0.2 * report.rayleigh.seconds, report.contact.seconds / 20));
  // the pair limit of equal spheres is sqrt(2 m / k)
  a.row_sum = report.isolated_pair.seconds / std::sqrt(12.0);
  return a;
}

}  // namespace talus
