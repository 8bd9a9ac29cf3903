// See start.hpp.
#include "scheduler/step/start.hpp"

#include <algorithm>
#include <utility>

#include "core/base/error.hpp"
#include "scheduler/team/available_cores.hpp"

namespace talus {

namespace {

constexpr double k_usual_skin = 0.35;  // in radii: of a grain and the wall together, what nearly all lists need

bool acts_later(const Source& s) {
  return s.kind == Source::Kind::stream || (s.kind != Source::Kind::file && s.start > 0);
}

/// Normal forces turn superquadrics, and the gas acts on the centre of a clump by a force and a torque on its first
/// sphere: they have the law with friction, if need be with a friction of zero.
bool rotates(const Scene& scene) {
  return scene.contact.friction || makes_superquadrics(scene) || (scene.gas.on && makes_bodies(scene));
}

/// What the scene needs, but for walls and what is added to the law.
void set_features(Rules& rules, bool any_fixed) {
  const Scene& scene = rules.scene;
  Features& h = rules.has;
  h.superquadrics = makes_superquadrics(scene);
  h.rotation = rotates(scene);
  h.history_columns = (h.rotation ? rules.law.info->history : 0) + (recalls(scene) ? 1 : 0);
  h.history = h.history_columns > 0;
  h.materials = scene.materials.size() > 1;
  h.reff = rules.law.info->wants_reff;
  h.groups = !scene.groups.empty();
  h.energies = scene.output.energies || scene.heat.friction;
  h.fixed_at_walls = scene.heat.on;
  h.planes = !scene.output.flux_planes.empty();
  h.insertion = std::any_of(scene.sources.begin(), scene.sources.end(), acts_later);
  h.events = !scene.events.empty();
  h.bodies = makes_bodies(scene);
  h.fixed = any_fixed;
  for (const Event& e : scene.events)
    h.fixed = h.fixed || e.action == Event::Action::freeze || e.action == Event::Action::drive;
  for (const GroupSpec& g : scene.groups) h.fixed = h.fixed || g.fixed_in_file;
  for (int k = 0; k < 3; ++k) {
    h.periodic = h.periodic || scene.domain.periodic(k);
    for (int s = 0; s < 2; ++s)
      h.removal = h.removal ||
                  scene.domain.boundary[static_cast<std::size_t>(k)][static_cast<std::size_t>(s)] == Boundary::open;
  }
}

/// Bodies move, and pairs of superquadrics are solved, exactly in both precisions.
std::string_view exact_set(const KernelTable& kernels) {
  const std::string_view name = kernels.name;
  return name.substr(0, name.find(' '));
}
PairSolver solver_of(const KernelTable& kernels) { return pair_solver(exact_set(kernels)); }

void set_law(Rules& rules) {
  const Scene& scene = rules.scene;
  const Features& h = rules.has;
  rules.law.variant = law_index(*rules.law.info, h.rotation, h.materials, h.energies);
  rules.law.late = rules.law.info->trial && scene.contact.friction && scene.contact.sliding == Sliding::series &&
                   !h.materials && !h.moments && !h.cohesion && !h.superquadrics;
  rules.law.trial = rules.law.late && !h.energies;  // the order of the sums is the same with and without energies
  if (h.superquadrics) rules.law.solver = solver_of(*rules.kernels);
  rules.law.parameters = pair_parameters(scene);
  rules.law.args.one = rules.law.parameters[0];
  rules.law.args.table = rules.law.parameters.data();
  rules.law.args.dt = scene.dt;
  rules.law.args.by_restitution = scene.contact.by_restitution ? 1 : 0;
  rules.law.args.centred = scene.contact.dashpot != Dashpot::lagged ? 1 : 0;
  rules.law.args.recall = recalls(scene) ? 1 : 0;
  rules.law.args.onset = scene.contact.onset_correction ? 1 : 0;
  rules.law.args.clip = scene.contact.clip_tension ? 1 : 0;
  rules.law.args.balanced = scene.contact.sliding == Sliding::balanced ? 1 : 0;
  rules.law.args.total = scene.contact.friction_limit == FrictionLimit::total || scene.contact.clip_tension ? 1 : 0;
  rules.law.args.synchronised = scene.contact.synchronised ? 1 : 0;
  rules.law.args.contact_lever = scene.contact.lever == Lever::contact ? 1 : 0;
  if (h.superquadrics) rules.law.gaps = pair_gaps(exact_set(*rules.kernels));
}

/// Everything that does not depend on walls.
Rules rules_of(const Scene& scene, const RunOptions& options, const Insertion& insertion, bool any_fixed) {
  Rules rules;
  rules.scene = scene;
  rules.options = options;
  rules.hooks = hooks_of_tests;
  rules.r_min = insertion.smallest_radius();
  rules.r_max = insertion.largest_radius();
  rules.threads = options.threads > 0 ? options.threads : available_cores();
  rules.kernels = &select_kernels(options.isa, &rules.isa_why, scene.precision);
  rules.law.info = &law_info(scene.contact);
  set_features(rules, any_fixed);
  std::stable_sort(rules.scene.events.begin(), rules.scene.events.end(),
                   [](const Event& a, const Event& b) { return a.time < b.time; });
  configure_add_ons(rules);
  rules.stride = rules.has.rotation ? 8 : 4;
  if (rules.has.bodies) rules.mover = body_mover(exact_set(*rules.kernels));
  set_law(rules);
  rules.size = scene.domain.upper - scene.domain.lower;
  // The stiffness matrix has an eigenvalue of at least (row sum) / (3 m): beyond 12 / dt^2 no step can be stable.
  rules.bounds.unstable = scene.allow_unstable_step ? 1e300 : 12.0 / (scene.dt * scene.dt);
  return rules;
}

/// No body may meet its own image.
void check_periods(const Rules& rules, double reach) {
  for (int k = 0; k < 3; ++k)
    if (rules.has.bodies && rules.scene.domain.periodic(k) && !(rules.size[k] > 4 * reach))
      throw Error(ErrorCode::scene, "a periodic side must be longer than twice the widest body", "domain",
                  "side " + std::to_string(rules.size[k]) + ", widest body " + std::to_string(2 * reach));
}

SkinRule skin_of(const Rules& rules) {
  const Scene& scene = rules.scene;
  const SkinRule skin(scene, rules.r_min, rules.r_max);
  for (int k = 0; k < 3; ++k)
    if (scene.domain.periodic(k) && !(rules.size[k] > 4 * (rules.r_max + skin.range(rules.r_max))))
      throw Error(ErrorCode::scene, "a periodic side must be longer than twice the largest diameter", "domain",
                  "side " + std::to_string(rules.size[k]) + ", largest diameter " + std::to_string(2 * rules.r_max));
  return skin;
}

/// Of a radius by warming as far as matter lasts.
double most_growth(const HeatScene& heat) {
  constexpr double k_hot = 5000;  // [K]
  double most = 1;
  for (const MatterHeat& m : heat.matter) most = fmax2(most, 1 + k_hot * m.expansion);
  return most;
}

WallSet walls_of(const Rules& rules, const SkinRule& skin) {
  double reach = 0;
  for (const double r : {rules.r_min, rules.r_max})
    reach = fmax2(reach, r + 2 * skin.range(r) + skin.to_walls(skin(r, 1e30, 0)) + skin.drift_travel);
  if (rules.scene.heat.on)
    reach = fmax2(reach, heat_reach(rules.scene.heat, rules.r_max * most_growth(rules.scene.heat)));
  return WallSet(in_stored_frame(rules.scene), reach + 0.5 * rules.r_min,
                 (1 + k_usual_skin) * rules.r_max + 2 * skin.range(rules.r_max) + skin.drift_travel);
}

/// Refuses a step that is not sure to be stable, or in which a wall or grain passes what it should touch.
void judge_time_step(Rules& rules, const Population& grains, const WallSet& walls) {
  rules.bounds.time_step = time_step_limits(rules.scene, grains, walls);
  rules.bounds.wall_step = rules.scene.monitor.max_travel * grains.smallest_free();
  const double dt2 = rules.scene.dt * rules.scene.dt;
  rules.bounds.warn_row = dt2 * largest_row(rules.scene, rules.bounds.time_step, rules.scene.monitor.warn_stiffness);
}

}  // namespace

Start start_of(const Scene& scene, const RunOptions& options, const bool* checkpoint_fixed) {
  Start s;
  s.insertion = std::make_unique<Insertion>(scene);
  s.rules = rules_of(scene, options, *s.insertion,
                     checkpoint_fixed != nullptr ? *checkpoint_fixed : s.insertion->any_fixed());
  check_periods(s.rules, s.insertion->largest_reach());
  s.skin = skin_of(s.rules);
  s.walls = walls_of(s.rules, s.skin);
  s.rules.has.walls = s.walls.size() > 0;
  s.rules.has.moving_walls = s.rules.has.walls && s.walls.any_moving();
  judge_time_step(s.rules, s.insertion->population(), s.walls);
  return s;
}

}  // namespace talus
