// Summary of a run; see summary_of.hpp.
#include "scheduler/run/summary_of.hpp"

#include "core/grains/body_shape.hpp"
#include "scheduler/lists/policies/policy.hpp"

namespace talus {
namespace {

void add_planes(const Simulation& simulation, Summary& s) {
  for (std::size_t q = 0; q < simulation.planes().size(); ++q) {
    const PlaneTotal& t = simulation.planes()[q];
    s.planes.push_back({simulation.scene().output.flux_planes[q].name, t.particles(), t.forward, t.backward, t.mass});
  }
  s.planes_hash = simulation.planes_hash();
}

void add_counts(const Simulation& simulation, const RunFacts& facts, Summary& s) {
  const Scene& scene = simulation.scene();
  const Counters c = simulation.counters();
  s.rebuilds = c.rebuilds;
  if (policy_of(scene.list.policy).cuts) s.cuts = c.cuts;
  s.rebuilds_skin = c.rebuilds_skin;
  s.rebuilds_forced = c.rebuilds_forced;
  s.shortest_interval = c.shortest_interval;
  s.mean_interval = c.rebuilds > 0 ? static_cast<double>(s.steps) / static_cast<double>(c.rebuilds) : 0;
  s.rebuild_steps = c.interval_steps;
  s.sort_epochs = c.sort_epochs;
  s.candidate_pairs = c.pairs;
  s.contacts = c.contacts;
  s.wall_contacts = c.wall_contacts;
  if (makes_superquadrics(scene)) s.solved_pairs = c.solved_pairs, s.safe_pairs = c.safe_pairs;
  if (facts.audited) s.missed_contacts = c.missed_contacts;
  s.inserted = c.inserted;
  s.removed = c.removed;
  s.removed_mass = c.removed_mass;
}

void add_means(const Simulation& simulation, Summary& s) {
  const Scene& scene = simulation.scene();
  const Plan plan = simulation.plan();
  s.bytes_per_particle = plan.bytes_per_particle;
  s.peak_rss_bytes = peak_rss_bytes();
  for (const ListRecord& r : simulation.list_series())
    s.list_series.push_back({r.step, r.interval, r.k, r.floor, r.skin, r.pairs, r.contacts});
  s.verlet_k = scene.list.verlet_k;
  s.verlet_k_automatic = scene.list.automatic;
  if (scene.list.automatic && !s.list_series.empty()) s.verlet_k = s.list_series.back().k;
  s.guarantee = plan.guarantee;
  s.policy = plan.policy;
  s.law = plan.law;
  s.isa = plan.isa;
  s.threads = plan.threads;
  s.chunk = plan.chunk;
  s.seed = scene.seed;
}

}  // namespace

Summary summary_of(const Simulation& simulation, const RunFacts& facts) {
  const Scene& scene = simulation.scene();
  Summary s;
  s.title = scene.title;
  s.scene_file = scene.file;
  s.version = facts.version;
  if (facts.signal != 0) s.status = "interrupted";
  if (!facts.failure.empty()) s.status = "failed: " + facts.failure;
  s.particles = simulation.particles();
  s.first_step = facts.first_step;
  s.last_step = simulation.step();
  s.steps = s.last_step - s.first_step;
  s.dt = scene.dt;
  s.simulated_time = simulation.time();
  s.wall_s = facts.wall_s;
  s.particle_steps_per_s = facts.wall_s > 0 ? facts.particle_steps / facts.wall_s : 0;
  for (const NodeTime& n : simulation.profile().nodes) s.nodes.push_back({n.node, n.calls, n.seconds});
  add_counts(simulation, facts, s);
  if (!scene.output.flux_planes.empty()) add_planes(simulation, s);
  for (const PartValue& v : simulation.part_values()) s.parts.emplace_back(v.name, v.value);
  add_means(simulation, s);
  s.kinetic_energy = simulation.kinetic_energy();
  if (scene.output.energies) {
    const Energies e = simulation.energies();
    s.kinetic_rotation = e.kinetic_rotation;
    s.potential_energy = e.potential;
    s.elastic_energy = e.elastic;
    s.dissipated_energy = e.dissipated_damping + e.dissipated_friction + e.dissipated_background;
  }
  for (const Warning& w : simulation.warnings())
    s.warnings.push_back({w.kind, w.text, w.first_step, w.count, w.worst, w.level});
  s.meshes = simulation.meshes();
  s.state_hash = simulation.state_hash();
  return s;
}

}  // namespace talus
