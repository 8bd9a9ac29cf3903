// Limits of the time step. Nothing here feeds the trajectory; det_math is used all the same, so that a step which is
// just accepted on one machine is not refused on another.
#include "core/rules/timestep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/grains/body.hpp"
#include "core/rules/contact_limits.hpp"
#include "core/rules/laws/law.hpp"
#include "core/scene/duration.hpp"

namespace talus {
namespace {

constexpr double k_warning_share = 0.2;
/// Where nothing takes energy out, a bed is heated by the phase errors of contacts that begin and end: by 1 % in 10^5
/// steps of 1/8 of the contact time, without bound at three steps per contact. A restitution of 0.99 suffices.
constexpr double k_undamped_share = 1.0 / 8;
constexpr double k_enough_neighbours = 8;  ///< grains from which on packings are full; see packing_of

/// Materials of walls, those of the domain's sides included.
std::vector<char> wall_materials(const Scene& scene) {
  std::vector<char> used(scene.materials.size());
  for (const WallSpec& w : scene.walls)
    if (w.appear < end_of(scene)) used[static_cast<std::size_t>(w.material)] = 1;
  for (const auto& axis : scene.domain.boundary)
    for (const Boundary side : axis)
      if (side == Boundary::wall) used[static_cast<std::size_t>(scene.domain.wall_material)] = 1;
  return used;
}

/// Pairs of grains of two kinds, or of one: the extremes of what can meet.
void add_pairs(const GrainKind& a, const GrainKind& b, std::vector<ContactCase>& out) {
  if (&a == &b) {
    if (a.fixed || a.count < 2) return;
    for (const auto& [r, s] :
         {std::pair{a.smallest[0], a.smallest[1]}, {a.smallest[0], a.largest[0]}, {a.largest[0], a.largest[1]}})
      out.push_back({a.material, a.material, r, s, false, a.weight, a.weight});
    return;
  }
  if (a.fixed && b.fixed) return;
  const GrainKind &free = a.fixed ? b : a, &other = a.fixed ? a : b;
  for (const double r : {free.smallest[0], free.largest[0]})
    for (const double s : {other.smallest[0], other.largest[0]})
      out.push_back({free.material, other.material, r, s, other.fixed, free.weight, other.weight});
}

std::vector<ContactCase> contacts_of(const Scene& scene, const Population& grains) {
  std::vector<ContactCase> all;
  const std::vector<char> walls = wall_materials(scene);
  for (std::size_t a = 0; a < grains.kinds.size(); ++a) {
    const GrainKind& k = grains.kinds[a];
    for (std::size_t b = a; b < grains.kinds.size(); ++b) add_pairs(k, grains.kinds[b], all);
    for (std::size_t m = 0; m < walls.size() && !k.fixed; ++m)
      for (const double r : {k.smallest[0], k.largest[0]})
        if (walls[m] != 0) all.push_back({k.material, static_cast<int>(m), r, k_never, false, k.weight});
  }
  return all;
}

/// A contact in the hardest impact by itself, in a bed that takes it, and under a bed's weight. The stiffness of linear
/// contacts is the same in all.
struct Judged {
  ContactCase contact;
  ContactDynamics impact, shared, rest;
};

/// Contacts per grain that are as stiff as impacts make them, over twelve: in motion a packing is isostatic, with four
/// contacts per grain, without friction six. Energy m v^2/2 per grain is that of a pair's impact, m v^2/4, for each of
/// four, 2/3 of it for each of six.
constexpr double k_moving = 1.0 / 3, k_moving_smooth = 1.0 / 2, k_smooth_energy = 2.0 / 3;

/// omega^2 dt^2 of a packing of such contacts. A Hertz contact is as stiff as its load. At rest a bed has about six
/// contacts per grain; those of a regular packing, twelve, do not all bear a bed as high as the domain.
double mode_of(const Scene& scene, const Judged& c, double dt) {
  const bool wall = c.contact.wall();
  if (!law_of(scene).by_modulus) return packing_mode(scene, c.impact, wall, dt);
  const double moving = scene.contact.friction ? k_moving : k_moving_smooth;
  return fmax2(0.5 * packing_mode(scene, c.rest, wall, dt), moving * packing_mode(scene, c.shared, wall, dt));
}

/// rho g H, of chains that bear more than their share, in a bed that fills the domain [Pa].
double bed_pressure(const Scene& scene, double density) {
  double height = 0;
  for (int k = 0; k < 3; ++k) height += std::fabs(scene.gravity[k]) * (scene.domain.upper[k] - scene.domain.lower[k]);
  return 0.6 * density * height;
}

/// Largest omega^2 dt^2 of the scene's packings, and the contact that rules it. Few grains cannot surround one: N of
/// them make a mode of at most N/2 pairs; what then is left of the surroundings are walls.
struct Mode {
  double value = 0;
  const Judged* ruler = nullptr;
};
Mode packing_of(const Scene& scene, const std::vector<Judged>& contacts, std::int64_t grains, double dt) {
  Mode of_grains, of_walls, of_pairs;
  const auto keep = [](Mode& m, double value, const Judged& c) {
    if (value > m.value) m = {value, &c};
  };
  for (const Judged& c : contacts) {
    keep(c.contact.wall() ? of_walls : of_grains, mode_of(scene, c, dt), c);
    keep(of_pairs, pair_mode(scene, c.impact, dt), c);
  }
  const double share = fmin2(1, static_cast<double>(grains) / k_enough_neighbours);
  const double both = share * of_grains.value + (1 - share) * of_walls.value;
  if (of_pairs.value >= fmax2(both, of_walls.value)) return of_pairs;
  if (of_walls.value >= of_grains.value) return of_walls;
  return {both, share * of_grains.value >= (1 - share) * of_walls.value ? of_grains.ruler : of_walls.ruler};
}

/// Largest argument below `high` that `holds`, where it holds for all smaller ones: dashpots leave no closed forms.
template <class F>
double bisect(double high, F holds) {
  double low = 0;
  for (int k = 0; k < 100; ++k) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

/// The step at which that mode turns unstable.
void set_packing_limit(const Scene& scene, const std::vector<Judged>& contacts, std::int64_t grains,
                       TimeStepReport& report) {
  const auto stable = [&](double dt) {
    // drag on velocities of n-1/2 brakes the alternating motion too late
    return packing_of(scene, contacts, grains, dt).value < 4 - 2 * scene.viscous_damping * dt;
  };
  double fastest = scene.viscous_damping * scene.viscous_damping;
  for (const Judged& c : contacts) fastest = fmax2(fastest, c.impact.normal);
  if (!(fastest > 0)) return;
  report.packing.seconds = bisect(64 / std::sqrt(fastest), stable);
  const Judged* ruler = packing_of(scene, contacts, grains, report.packing.seconds).ruler;
  report.packing.pair = ruler != nullptr ? describe(scene, ruler->contact) : "background damping";
  if (ruler != nullptr) report.ruler = ruler->impact;
  if (!scene.contact.friction && scene.viscous_damping == 0 && scene.local_damping == 0)
    for (const Judged& c : contacts)
      if (const double limit = k_undamped_share * c.impact.duration;
          c.impact.normal_rate == 0 && limit < report.packing.seconds)
        report.packing = {limit, describe(scene, c.contact) + " without damping"};
}

std::string line(const char* name, double dt, const TimeStepLimit& limit) {
  if (limit.seconds == k_never) return fmt::format("{:<20} none", name);
  return fmt::format("{:<20} {:.4g} s, step is {:.3g} of it; {}", name, limit.seconds, dt / limit.seconds, limit.pair);
}

/// A wall or a grain that moves by more than a radius per step could pass a grain unseen. Refuses what is sure to;
/// returns a warning or nothing.
std::string judge_travel(const Scene& scene, const Population& grains, const WallSet& walls) {
  std::string warning;
  const MonitorSettings& m = scene.monitor;
  const auto judge = [&](const std::string& name, const std::string& place, double least, double most,
                         const char* radius, double speed) {
    if (!(most > m.warn_travel)) return;
    const std::string what =
        fmt::format("{} moves {}{:.3g} of {} in one step ({}{:.4g} m/s)", name, least < most ? "by up to " : "", most,
                    radius, place.empty() ? "" : place + "; ", speed);
    if (least > m.max_travel)
      throw Error(ErrorCode::scene, what + ": it could pass particles or walls unseen", scene.file,
                  fmt::format("a time.step of at most {} s, or a larger checks.max_travel",
                              at_most(scene.dt * m.warn_travel / most)));
    if (warning.empty()) warning = what;
  };
  const double r = grains.smallest_free();
  for (int k = 0; k < walls.size() && r > 0; ++k) {
    const double travel = walls.fastest_point(k) * scene.dt / r;
    judge(fmt::format("wall '{}'", walls.name(k)), "", travel, travel, "the smallest radius", walls.fastest_point(k));
  }
  for (const Mover& g : grains.movers)
    judge(g.name, g.place, g.slowest * scene.dt / g.largest, g.fastest * scene.dt / g.smallest, "its radius",
          g.fastest);
  return warning;
}

/// Refuses a step above the packing limit, or says why it is uncomfortable.
std::string judge_step_size(const Scene& scene, const TimeStepReport& report) {
  if (scene.dt > report.packing.seconds) {
    const std::string what = fmt::format("time.step: {:g}: above the packing limit {:.4g} s of {}", scene.dt,
                                         report.packing.seconds, report.packing.pair);
    if (!scene.allow_unstable_step)
      throw Error(
          ErrorCode::scene, what, scene.file,
          fmt::format("at most {} s is allowed, or set checks.allow_unstable_step", at_most(report.packing.seconds)));
    return what;
  }
  if (!(report.share > k_warning_share)) return {};
  const bool by_rayleigh = report.rayleigh.seconds < report.contact.seconds;
  const TimeStepLimit& shortest = by_rayleigh ? report.rayleigh : report.contact;
  return fmt::format("time.step: {:g}: {:.0f} % of the {} time {:.4g} s of {}; 20 % or less is advised", scene.dt,
                     100 * report.share, by_rayleigh ? "Rayleigh" : "contact", shortest.seconds, shortest.pair);
}

TimeStepReport limits_at(const Scene& scene, const Population& grains, const WallSet& walls, double least_speed) {
  TimeStepReport report;
  report.dt = scene.dt;
  if (!(scene.dt > 0) || !std::isfinite(scene.dt))
    throw Error(ErrorCode::scene, fmt::format("time.step: {}: must be a number > 0 [s]", scene.dt), scene.file);
  if (!(grains.smallest_free() > 0)) return report;  // no particle can ever move
  report.speeds = speeds_of(scene, grains, walls);
  if (law_of(scene).by_modulus) report.velocity = fmax2(least_speed, report.speeds.closing);
  const auto keep = [&](TimeStepLimit& limit, double seconds, const ContactCase& c) {
    if (seconds < limit.seconds) limit = {seconds, describe(scene, c)};
  };
  std::vector<Judged> contacts;
  const double shared = scene.contact.friction ? 1 : std::sqrt(k_smooth_energy);
  for (const ContactCase& c : contacts_of(scene, grains)) {
    const double v = report.velocity,
                 pressure = bed_pressure(scene, scene.materials[static_cast<std::size_t>(c.a)].density);
    contacts.push_back({c, dynamics_of(scene, c, v, 0), dynamics_of(scene, c, v * shared, 0),
                        dynamics_of(scene, c, v > 0 && !(pressure > 0) ? 1e-9 : 0, pressure)});
    keep(report.contact, contacts.back().impact.duration, c);
    keep(report.isolated_pair, 2 / std::sqrt(contacts.back().impact.normal), c);
  }
  std::int64_t count = 0;
  for (const GrainKind& k : grains.kinds) {
    count += k.count;
    if (k.fixed) continue;
    const Material& m = scene.materials[static_cast<std::size_t>(k.material)];
    if (const double t = rayleigh_time(m, k.smallest[0]); t < report.rayleigh.seconds)
      report.rayleigh = {t, fmt::format("{} (r = {:g})", m.name, k.smallest[0])};
  }
  set_packing_limit(scene, contacts, count, report);
  report.share = scene.dt / fmin2(report.rayleigh.seconds, report.contact.seconds);
  report.lines = {line("Rayleigh time", scene.dt, report.rayleigh), line("contact time", scene.dt, report.contact),
                  line("isolated pair limit", scene.dt, report.isolated_pair),
                  line("packing limit", scene.dt, report.packing)};
  if (report.speeds.grain > 0)
    report.lines.push_back(fmt::format("{:<20} {:.4g} m/s", "fastest grain", report.speeds.grain));
  if (report.speeds.wall > 0)
    report.lines.push_back(
        fmt::format("{:<20} {:.4g} m/s ('{}')", "fastest wall point", report.speeds.wall, report.speeds.wall_name));
  if (report.velocity > 0) report.lines.push_back(fmt::format("{:<20} {:.4g} m/s", "judged at speed", report.velocity));
  return report;
}

}  // namespace

double largest_row(const Scene& scene, const TimeStepReport& report, double level) {
  const double dt = report.dt;
  return bisect(level / (dt * dt) * (1 + 1e-12),
                [&](double row) { return effective_stiffness(scene, report.ruler, row, dt) <= level; });
}

double step_for_row(const Scene& scene, const TimeStepReport& report, double row, double level) {
  return bisect(std::sqrt(level / row) * (1 + 1e-12),
                [&](double dt) { return effective_stiffness(scene, report.ruler, row, dt) <= level; });
}

std::string at_most(double seconds) { return fmt::format("{:.4g}", seconds * (1 - 5e-4)); }

Speeds speeds_of(const Scene& scene, const Population& grains, const WallSet& walls) {
  Speeds s;
  s.grain = grains.fastest();
  for (int k = 0; k < walls.size(); ++k)
    if (walls.fastest_point(k) > s.wall) {
      s.wall = walls.fastest_point(k);
      s.wall_name = walls.name(k);
    }
  double fall2 = 0;  // 2 g H; along periodic axes, where it never ends, one period
  const auto falls = [&](Vec3 g) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += 2 * std::fabs(g[k]) * (scene.domain.upper[k] - scene.domain.lower[k]);
    fall2 = fmax2(fall2, sum);
  };
  falls(scene.gravity);
  for (const Event& e : scene.events)
    if (e.action == Event::Action::gravity && e.time < end_of(scene)) falls(e.vector);
  s.fall = std::sqrt(fall2);
  const double stated = grains.spread() + s.wall;
  s.closing = std::sqrt(stated * stated + fall2);
  return s;
}

TimeStepReport time_step_limits(const Scene& scene, const Population& grains, const WallSet& walls) {
  TimeStepReport report = limits_at(scene, grains, walls, 0);
  report.warning = judge_step_size(scene, report);
  const std::string travel = judge_travel(scene, grains, walls);
  if (report.warning.empty()) report.warning = travel;
  return report;
}

TimeStepReport time_step_limits(const Scene& scene, double r_min, double r_max, double speed) {
  const Population grains = population_of(scene, r_min, r_max);
  const WallSet walls(scene, r_max);
  TimeStepReport report = limits_at(scene, grains, walls, speed);
  report.warning = judge_step_size(scene, report);
  const std::string travel = judge_travel(scene, grains, walls);
  if (report.warning.empty()) report.warning = travel;
  return report;
}

Softening softening(const Scene& scene, const Population& grains, double speed) {
  Softening s;
  s.speed = speed;
  constexpr double target = 0.01;  // overlap / radius
  const Law& law = law_of(scene);
  double impact = 0, pressed = 0;  // overlaps / radius
  for (const GrainKind& kind : grains.kinds) {
    if (kind.fixed) continue;
    const Material& material = scene.materials[static_cast<std::size_t>(kind.material)];
    // of bodies r is that of the roundest contact: what is as heavy is smaller, and overlaps count by the thinnest
    // place
    const double r = kind.largest[0], m = kind.whole * Body{r, material.density}.mass();
    const double wide = r * det::pow(kind.whole, 1.0 / 3.0);
    const double load = bed_pressure(scene, material.density) * (4 * wide * wide);
    s.load = fmax2(s.load, load);
    const Overlaps o = law.overlaps(scene, material, r, m, s.speed, load);
    impact = fmax2(impact, o.impact / kind.thinnest);
    pressed = fmax2(pressed, o.pressed / kind.thinnest);
  }
  // the contact time goes as the overlap of an impact
  s.factor = fmax2(det::pow(impact / target, 1 / law.impact_power), det::pow(pressed / target, 1 / law.load_power));
  s.step_factor = s.factor > 0 ? det::pow(s.factor, -law.impact_power) : 0;
  s.by_impact = impact >= pressed;
  s.overlap = fmax2(impact, pressed);
  return s;
}

Softening softening(const Scene& scene, double r_max, double speed) {
  const Population grains = population_of(scene, r_max, r_max);
  return softening(scene, grains, fmax2(speed, speeds_of(scene, grains, WallSet(scene, r_max)).closing));
}

StepAdvice step_advice(const TimeStepReport& report) {
  StepAdvice a;
  a.limit = report.packing.seconds;
  a.accurate = fmin2(a.limit, fmin2(0.2 * report.rayleigh.seconds, report.contact.seconds / 20));
  const double largest = fmin2(a.limit, fmin2(0.2 * report.rayleigh.seconds, report.contact.seconds / 10));
  a.advised = report.dt >= a.accurate && report.dt <= largest ? report.dt : a.accurate;
  return a;
}

}  // namespace talus
