// Simulation: set-up from a scene or a checkpoint, and the public calls.
#include "scheduler/simulation.hpp"

#include <fmt/format.h>

#include <utility>

#include "core/base/error.hpp"
#include "scheduler/nodes/events.hpp"
#include "scheduler/state/hash.hpp"
#include "scheduler/step/access.hpp"
#include "scheduler/step/checkpoint.hpp"
#include "scheduler/step/step.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/view/observe.hpp"

namespace talus {

struct Simulation::Impl {
  explicit Impl(Start start) : w(std::move(start)) {
    for (const NodeSpec& n : step_table(w)) {
      auto& names = w.team.times.names;
      const auto id = static_cast<std::size_t>(n.id);
      if (names.size() <= id) names.resize(id + 1);
      names[id] = n.name;
    }
  }
  void check_part_limits() const {
    for (const auto& p : w.parts.all)
      if (const double most = p->step_limit(view_of(w)); w.rules.scene.dt > most)
        throw Error(ErrorCode::scene, "time.step is too long for part '" + p->name() + "'", w.rules.scene.file,
                    "at most " + at_most(most) + " s, or fewer steps between two of the part's own");
  }
  World w;
};

namespace {

/// A part whose own steps are farther apart than the run is long does nothing: that is rarely meant.
void warn_of_idle_parts(const Rules& rules, const Clock& clock, const Parts& parts, Monitor& monitor) {
  const auto warn = [&](const Part& p, const std::string& why, double value) {
    monitor.warnings.push_back(
        {"part", fmt::format("part '{}' {}: it never acts", p.name(), why), clock.step, 1, value, 0});
  };
  for (const auto& p : parts.all) {
    if (const std::string why = p->idle(rules); !why.empty()) warn(*p, why, 0);
    for (const PartNode& n : p->nodes())
      if (n.every > rules.scene.steps) {
        warn(*p, fmt::format("acts every {} steps, and the run has {}", n.every, rules.scene.steps),
             static_cast<double>(n.every));
        break;
      }
  }
}

}  // namespace

Simulation::Simulation(const Scene& scene, const RunOptions& options)
    : impl_(std::make_unique<Impl>(start_of(scene, options, nullptr))) {
  World& w = impl_->w;
  const NewParticles grains = w.insertion->initial(&w.walls);
  append_particles(w.rules, w.clock, w.rows, grains, nullptr);
  w.parts.appended(w.rows, 0, grains);
  impl_->check_part_limits();
  warn_of_extent(w.rules, w.clock, w.monitor);
  for (const std::string& note : w.insertion->notes())
    w.monitor.warnings.push_back({"particle_file", note, 0, 1, 0, 0});
  warn_of_sources(w.rules, w.clock, w.walls, w.monitor);
  warn_of_meshes(w.rules, w.clock, w.walls, w.monitor);
  warn_of_idle_parts(w.rules, w.clock, w.parts, w.monitor);
  cut_into_chunks(w);
}

void Simulation::check_continuable(const CheckpointReader& in) {
  if (in.has("failed"))
    throw Error(ErrorCode::io,
                "is the state of a failed step, to be looked at: its contacts have moved on, its particles have not",
                in.path(), "resume from a checkpoint before it, or start again with the cure that the failure named");
  if (in.has("flux"))
    throw Error(ErrorCode::io, "was written by an older version, which counted planes at output times only", in.path(),
                "start the run again");
}

std::int64_t Simulation::step_of(const CheckpointReader& checkpoint) { return step_of_checkpoint(checkpoint); }

namespace {

Start start_from(const Scene& scene, const RunOptions& options, const CheckpointReader& in) {
  const bool fixed = in.has("fixed");
  return start_of(scene, options, &fixed);
}

}  // namespace

Simulation::Simulation(const Scene& scene, const RunOptions& options, const CheckpointReader& in,
                       const std::vector<int>& walls)
    : impl_(std::make_unique<Impl>(start_from(scene, options, in))) {
  restore_state(impl_->w, in, walls);
  impl_->check_part_limits();
}

Simulation::~Simulation() = default;

void Simulation::run(std::int64_t steps) {
  World& w = impl_->w;
  if (w.team.failure.any())
    throw Error(ErrorCode::physics, "this run has failed and cannot go on", "step " + std::to_string(w.clock.step));
  if (steps <= 0) return;
  const std::int64_t target = w.clock.step + steps;
  // The balance starts with the first step of the motion proper: a relaxation takes energy out that nothing counts.
  const std::int64_t first = w.rules.scene.relax.steps;
  if (w.rules.has.energies && !w.ledger.start_known && w.clock.step <= first && target > first) {
    run_graph(w, first + 1);
    const Energies e = energies_of(w);
    w.ledger.start = e.kinetic_translation + e.kinetic_rotation + e.potential + e.elastic + e.dissipated_damping +
                     e.dissipated_friction + e.dissipated_background - e.wall_work - e.inserted - e.sizes;
    w.ledger.start_known = true;
  }
  if (w.clock.step < target) run_graph(w, target);
}

const Scene& Simulation::scene() const noexcept { return impl_->w.rules.scene; }
std::int64_t Simulation::step() const noexcept { return impl_->w.clock.step; }
double Simulation::time() const noexcept { return static_cast<double>(impl_->w.clock.step) * impl_->w.rules.scene.dt; }
std::int64_t Simulation::particles() const noexcept { return impl_->w.rows.grains(); }
std::uint64_t Simulation::state_hash() const {
  std::uint64_t sum = talus::state_hash(impl_->w.rules, impl_->w.clock, impl_->w.rows, impl_->w.contacts,
                                        *impl_->w.insertion, impl_->w.team.failure.any());
  for (const auto& p : impl_->w.parts.all) sum += p->hash();
  return sum;
}
Energies Simulation::energies() const { return energies_of(impl_->w); }
double Simulation::kinetic_energy() const { return kinetic_energy_of(impl_->w.rules, impl_->w.rows); }
Frame Simulation::frame(const FrameRequest& request) const { return frame_of(impl_->w, request); }
const std::vector<PlaneTotal>& Simulation::planes() const noexcept { return impl_->w.planes.totals(); }
std::vector<std::pair<std::string, std::string>> Simulation::part_advice() const {
  std::vector<std::pair<std::string, std::string>> all;
  for (const auto& p : impl_->w.parts.all)
    for (std::string& line : p->advice(view_of(impl_->w))) all.emplace_back(p->name(), std::move(line));
  return all;
}

std::vector<PartValue> Simulation::part_values() const {
  std::vector<PartValue> all;
  for (const auto& p : impl_->w.parts.all)
    for (PartValue& v : p->values(view_of(impl_->w))) all.push_back(std::move(v));
  return all;
}
std::vector<std::pair<std::string, GridData>> Simulation::part_grids() const {
  std::vector<std::pair<std::string, GridData>> all;
  for (const auto& p : impl_->w.parts.all)
    if (auto grid = p->grid(view_of(impl_->w))) all.emplace_back(p->name(), std::move(*grid));
  return all;
}
std::uint64_t Simulation::planes_hash() const { return impl_->w.planes.hash(); }
const TimeStepReport& Simulation::time_step() const noexcept { return impl_->w.rules.bounds.time_step; }
Softening Simulation::softening(double speed) const {
  return talus::softening(impl_->w.rules.scene, impl_->w.insertion->population(),
                          fmax2(speed, impl_->w.rules.bounds.time_step.speeds.closing));
}
Plan Simulation::plan() const { return plan_of(impl_->w); }
std::vector<std::pair<std::string, MeshReport>> Simulation::meshes() const { return impl_->w.walls.meshes(); }
const std::vector<Warning>& Simulation::warnings() const noexcept { return impl_->w.monitor.warnings; }
const std::vector<ParticleId>& Simulation::culprits() const noexcept { return impl_->w.monitor.culprits; }
World& EngineAccess::world(Simulation& simulation) noexcept { return simulation.impl_->w; }
std::size_t Simulation::bytes() const { return bytes_of(impl_->w); }

Counters Simulation::counters() const {
  const World& w = impl_->w;
  Counters c = w.counters;
  std::int64_t both = 0, border = 0;
  for (const auto& k : w.contacts.chunks) {
    both += k->contacts.end[1] - k->contacts.end[0] - k->contacts.apart[0];
    border += k->contacts.end[0] + (k->contacts.end[2] - k->contacts.end[1]) - k->contacts.apart[1];
    c.wall_contacts += static_cast<std::int64_t>(k->wall.state.size());
  }
  c.contacts = both + border / 2;
  c.border_contact_share = c.contacts > 0 ? 0.5 * static_cast<double>(border) / static_cast<double>(c.contacts) : 0;
  return c;
}

const std::vector<ListRecord>& Simulation::list_series() const noexcept { return impl_->w.lists.series.records; }
Profile Simulation::profile() const { return impl_->w.team.times.report(); }
void Simulation::restart_profile() { impl_->w.team.times.restart(); }
void Simulation::start_trace(std::int64_t first_step, std::int64_t steps) {
  impl_->w.team.times.trace(first_step, steps);
}

void Simulation::write_trace(const std::string& path) const {
  const World& w = impl_->w;
  w.team.times.write(path, {{"particles", std::to_string(w.rows.alive)},
                            {"threads", std::to_string(w.rules.threads)},
                            {"chunk", std::to_string(w.contacts.chunk_size)},
                            {"chunks", std::to_string(w.contacts.chunks.size())},
                            {"bytes", std::to_string(bytes_of(w))},
                            {"sort_every", std::to_string(w.rules.scene.sort_every)},
                            {"isa", std::string("\"") + w.rules.kernels->name + "\""}});
}

void Simulation::save(CheckpointWriter& out) const { save_state(impl_->w, out); }

}  // namespace talus
