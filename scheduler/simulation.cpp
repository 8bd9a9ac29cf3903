// Simulation: set-up from a scene or a checkpoint, and the public calls.
#include "scheduler/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/count.hpp"
#include "core/base/error.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/team/available_cores.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

struct Simulation::Impl {
  World w;
};

namespace {

constexpr double k_usual_skin = 0.35;  // in radii: of a grain and the wall together, what nearly all lists need

bool acts_later(const Source& s) {
  return s.kind == Source::Kind::stream || (s.kind != Source::Kind::file && s.start > 0);
}

/// Everything that does not depend on the particles' present state.
void configure(World& w, const Scene& scene, const RunOptions& options, bool any_fixed) {
  w.scene = scene;
  w.options = options;
  w.threads = options.threads > 0 ? options.threads : available_cores();
  w.lane_choice.prepare(w.threads);
  w.times.prepare(w.threads);
  w.scratch.prepare(w.threads);
  w.serial.index = -1;
  w.kernels = &select_kernels(options.isa, &w.isa_why, scene.precision);
  w.law = &law_info(scene.contact);
  Features& h = w.has;
  h.rotation = scene.contact.friction;
  const bool recall = recalls(scene);
  h.history_columns = (scene.contact.friction ? w.law->history : 0) + (recall ? 1 : 0);
  h.history = h.history_columns > 0;
  h.materials = scene.materials.size() > 1;
  h.reff = w.law->wants_reff;
  h.groups = !scene.groups.empty();
  h.energies = scene.output.energies;
  h.planes = !scene.output.flux_planes.empty();
  w.planes = PlaneCounts(scene);
  h.insertion = std::any_of(scene.sources.begin(), scene.sources.end(), acts_later);
  h.events = !scene.events.empty();
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
  std::stable_sort(w.scene.events.begin(), w.scene.events.end(),
                   [](const Event& a, const Event& b) { return a.time < b.time; });
  configure_add_ons(w);
  w.stride = h.rotation ? 8 : 4;
  w.law_variant = law_index(*w.law, scene.contact.friction, h.materials, h.energies);
  w.trial = scene.contact.model == ContactModel::linear && scene.contact.friction &&
            scene.contact.sliding == Sliding::series && !h.materials && !h.energies && !h.moments && !h.cohesion;
  w.parameters = pair_parameters(scene);
  w.law_args.one = w.parameters[0];
  w.law_args.table = w.parameters.data();
  w.law_args.dt = scene.dt;
  w.law_args.by_restitution = scene.contact.by_restitution ? 1 : 0;
  w.law_args.centred = scene.contact.dashpot != Dashpot::lagged ? 1 : 0;
  w.law_args.recall = recall ? 1 : 0;
  w.law_args.onset = scene.contact.onset_correction ? 1 : 0;
  w.law_args.clip = scene.contact.clip_tension ? 1 : 0;
  w.law_args.balanced = scene.contact.sliding == Sliding::balanced ? 1 : 0;
  w.law_args.total = scene.contact.friction_limit == FrictionLimit::total || scene.contact.clip_tension ? 1 : 0;
  w.law_args.synchronised = scene.contact.synchronised ? 1 : 0;
  w.law_args.contact_lever = scene.contact.lever == Lever::contact ? 1 : 0;
  w.size = scene.domain.upper - scene.domain.lower;
  w.gravity = scene.gravity;
  // The stiffness matrix has an eigenvalue of at least (row sum) / (3 m): beyond 12 / dt^2 no step can be stable.
  w.unstable_limit = scene.allow_unstable_step ? 1e300 : 12.0 / (scene.dt * scene.dt);
  w.skin = SkinRule(scene, w.r_min, w.r_max);
  for (int k = 0; k < 3; ++k)
    if (scene.domain.periodic(k) && !(w.size[k] > 4 * (w.r_max + w.skin.range(w.r_max))))
      throw Error(ErrorCode::scene, "a periodic side must be longer than twice the largest diameter", "domain",
                  "side " + std::to_string(w.size[k]) + ", largest diameter " + std::to_string(2 * w.r_max));
  w.tuner.prepare(w);
  double reach = 0;
  for (const double r : {w.r_min, w.r_max})
    reach = fmax2(reach, r + 2 * w.skin.range(r) + w.skin.to_walls(w.skin(r, 1e30, 0)) + w.skin.drift_travel);
  w.walls = WallSet(in_stored_frame(w.scene), reach + 0.5 * w.r_min,
                    (1 + k_usual_skin) * w.r_max + 2 * w.skin.range(w.r_max) + w.skin.drift_travel);
  h.walls = w.walls.size() > 0;
  h.moving_walls = h.walls && w.walls.any_moving();
}

/// Refuses a step that is not sure to be stable, or in which a wall or grain passes what it should touch.
void judge_time_step(World& w) {
  const Population grains = w.insertion->population();
  w.time_step = time_step_limits(w.scene, grains, w.walls);
  w.wall_step = w.scene.monitor.max_travel * grains.smallest_free();
  const double dt2 = w.scene.dt * w.scene.dt;
  w.warn_row = dt2 * largest_row(w.scene, w.time_step, w.scene.monitor.warn_stiffness);
}

void choose_chunk(World& w) {
  if (w.options.chunk > 0) {
    w.chunk_size = w.options.chunk;
    return;
  }
  // Results do not depend on it (I8). One thread: 16384 rows where all rows stay near, else 8192. Pairs across borders
  // are computed twice, 11.1 % of the contacts of settle32 and 11.7 % of settle128 with 4096 rows, 6.6 and 9.2 with
  // 8192, 2.7 and 6.9 with 16384. That the rows of a larger chunk leave L2 between narrow phase and integration costs
  // less (AMD Zen 5, 1 MiB of L2; ns per grain and step with 4096, 8192, 16384: settle32 22.2, 21.7, 21.2; settle128
  // 27.9, 27.4, 27.9; settle512 28.4, 27.9, 28.2; flow128 17.8, 17.3, 17.5; radii5 25.7, 26.1, 26.1).
  // More threads: every thread gets the same whole number of equal chunks, of at most 3072 rows (4096 on two threads),
  // but none below 1024: there pairs across borders cost more than idle threads (perf/schedule.py: 125k particles on 28
  // threads, predicted efficiency 87 % with 1528 rows, 79 % with 1024, 55 % with 4096, which leaves 4 of the 28 with
  // two chunks). At least 3, and 6 where that leaves them 1300 rows, so that stealing can balance them: 128k grains on
  // 16 threads ran 235, 221, 269 M particle-steps/s with 6 chunks per thread, 208, 194, 214 with 3; 8 or 12 on 8
  // threads brought nothing more. Two threads, Zen 5: 32k and 128k grains alike within 3 % with 2667 to 8000 rows.
  const std::int64_t threads = w.threads, most = threads <= 2 ? 4096 : 3072;
  if (threads == 1) {
    w.chunk_size = rows_stay_near(w) ? 16384 : 8192;
    return;
  }
  const std::int64_t least = std::clamp<std::int64_t>(w.n / (1300 * threads), 3, 6);
  const std::int64_t each = std::max<std::int64_t>(least, (w.n + most * threads - 1) / (most * threads));
  const std::int64_t rows = (w.n + each * threads - 1) / (each * threads);
  w.chunk_size = static_cast<int>(std::clamp<std::int64_t>((rows + 7) / 8 * 8, 1024, 4096));
}

struct Meta {
  std::int64_t step, next_event, next_id, n, stride, history, materials, inserted, removed;
  double removed_mass, gravity[3], losses[3], wall_work, drive_power, gravity_work, inserted_energy, start_energy,
      start_known, dt;
};

/// Counts and sums of a state that some run can have had, and the number of rows that the file holds.
void check_meta(const Meta& m, const Scene& scene, const CheckpointReader& in) {
  const std::size_t bytes = in.section("position").size();
  bool good = m.n >= 0 && m.n <= (std::int64_t{1} << 30) && bytes == 32 * static_cast<std::size_t>(m.n);
  for (const std::int64_t count : {m.step, m.next_id, m.inserted, m.removed})
    good = good && count >= 0 && count <= k_most_count;
  good = good && m.next_event >= 0 && m.next_event <= static_cast<std::int64_t>(scene.events.size());
  const double* first = &m.removed_mass;
  for (const double* x = first; x <= &m.dt; ++x) good = good && std::isfinite(*x);
  if (!good) throw Error(ErrorCode::io, "section 'meta': no run can have had such counts or sums", in.path());
}

/// A wall contact as checkpoints hold it, beside its history of rolling and twisting.
struct WallRecord {
  Row row;
  std::int32_t unused;  ///< no padding: the bytes are a function of the state
  std::int32_t wall, element;
  Vec3 normal;
  double distance;
  Vec3 velocity;
  double h[k_usual_history];  ///< the rest is in wall_history
};

/// Contacts without the columns that the scene does not have: pairs of rows, then the columns of each contact.
void write_contacts(const World& w, CheckpointWriter& out) {
  std::size_t most = 0;
  for (const auto& c : w.chunks) most += static_cast<std::size_t>(c->contact_end[2]);
  std::vector<std::uint8_t> rows, history;
  rows.reserve(most * 2 * sizeof(Row));
  history.reserve(most * static_cast<std::size_t>(w.has.history_columns) * sizeof(double));
  const auto append = [](std::vector<std::uint8_t>& to, const void* data, std::size_t bytes) {
    const auto* from = static_cast<const std::uint8_t*>(data);
    to.insert(to.end(), from, from + bytes);
  };
  for (const auto& c : w.chunks)
    for (const ContactEntry& e : contacts_of(w, *c)) {
      append(rows, &e.a, sizeof e.a);
      append(rows, &e.b, sizeof e.b);
      append(history, e.h, static_cast<std::size_t>(w.has.history_columns) * sizeof(double));
    }
  out.add("contacts", std::move(rows));
  out.add("contact_history", std::move(history));
  const auto walls = collect_wall_states(w);
  std::vector<WallRecord> records(walls.size());
  std::vector<Vec3> centres;
  std::vector<double> moments, more;
  for (std::size_t k = 0; k < walls.size(); ++k) {
    const WallContact& t = walls[k].contact;
    records[k] = {walls[k].row, 0, t.wall, t.element, t.normal, t.distance, t.velocity, {}};
    std::copy_n(walls[k].h, k_usual_history, records[k].h);
    for (int q = k_usual_history; q < w.has.law_columns; ++q) more.push_back(walls[k].h[q]);
    centres.push_back(t.centre);
    moments.insert(moments.end(), walls[k].m, walls[k].m + w.has.moment_columns);
  }
  out.add_array("wall_contacts", records.data(), records.size());
  if (w.walls.has_images()) out.add_array("wall_centres", centres.data(), centres.size());
  if (w.has.moments) out.add_array("wall_moments", moments.data(), moments.size());
  if (w.has.law_columns > k_usual_history) out.add_array("wall_history", more.data(), more.size());
}

std::vector<ContactEntry> read_contacts(const World& w, const CheckpointReader& in) {
  std::vector<Row> rows;
  std::vector<double> history;
  in.read_array<Row>("contacts", rows);
  in.read_array<double>("contact_history", history);
  const auto columns = static_cast<std::size_t>(w.has.history_columns);
  if (rows.size() % 2 != 0 || history.size() != rows.size() / 2 * columns)
    throw Error(ErrorCode::io, "contacts and their history do not fit together", in.path());
  std::vector<ContactEntry> out(rows.size() / 2);
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k].a = rows[2 * k];
    out[k].b = rows[2 * k + 1];
    std::copy_n(history.begin() + static_cast<std::ptrdiff_t>(k * columns), columns, out[k].h);
  }
  return out;
}

/// `numbers`: what each wall of the checkpoint is now, -1: gone; empty: the same walls.
std::vector<WallEntry> read_walls(const World& w, const CheckpointReader& in, const std::vector<int>& numbers) {
  std::vector<WallRecord> records;
  std::vector<Vec3> centres;
  std::vector<double> moments, more;
  in.read_array<WallRecord>("wall_contacts", records);
  // Walls that are new at a resume may be the first with images; a grain in touch then has no former image to keep.
  const bool images = w.walls.has_images() && in.has("wall_centres");
  if (images) in.read_array<Vec3>("wall_centres", centres);
  if (w.has.moments) in.read_array<double>("wall_moments", moments);
  const auto columns = static_cast<std::size_t>(w.has.moment_columns);
  const auto beyond = static_cast<std::size_t>(std::max(w.has.law_columns - k_usual_history, 0));
  if (beyond > 0) in.read_array<double>("wall_history", more);
  if (moments.size() != records.size() * columns || more.size() != records.size() * beyond ||
      (images && centres.size() != records.size()))
    throw Error(ErrorCode::io, "wall contacts and their history do not fit together", in.path());
  std::vector<WallEntry> out;
  for (std::size_t k = 0; k < records.size(); ++k) {
    const WallRecord& r = records[k];
    WallEntry e;
    e.row = r.row;
    e.contact = {r.wall, r.element, r.normal, r.distance, r.velocity, centres.empty() ? Vec3{} : centres[k]};
    std::copy_n(r.h, k_usual_history, e.h);
    std::copy_n(more.begin() + static_cast<std::ptrdiff_t>(k * beyond), beyond, e.h + k_usual_history);
    std::copy_n(moments.begin() + static_cast<std::ptrdiff_t>(k * columns), columns, e.m);
    if (!numbers.empty()) {
      const auto before = static_cast<std::size_t>(r.wall);
      e.contact.wall = before < numbers.size() ? numbers[before] : -1;
      e.contact.element = -1;  // elements are numbered through all walls: the history passes on by the normal
    }
    if (numbers.empty() || e.contact.wall >= 0) out.push_back(e);
  }
  return out;
}

}  // namespace

Simulation::Simulation(const Scene& scene, const RunOptions& options) : impl_(std::make_unique<Impl>()) {
  World& w = impl_->w;
  w.insertion = std::make_unique<Insertion>(scene);
  w.r_min = w.insertion->smallest_radius();
  w.r_max = w.insertion->largest_radius();
  configure(w, scene, options, w.insertion->any_fixed());
  judge_time_step(w);
  append_particles(w, w.insertion->initial(&w.walls), true);
  warn_of_extent(w);
  for (const std::string& note : w.insertion->notes())
    w.monitor.warnings.push_back({"particle_file", note, 0, 1, 0, 0});
  warn_of_sources(w);
  warn_of_meshes(w);
  choose_chunk(w);
  w.chunk_of = ChunkMap(w.chunk_size);
  make_chunks(w);
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

std::int64_t Simulation::step_of(const CheckpointReader& checkpoint) {
  return checkpoint.read_value<Meta>("meta").step;
}

Simulation::Simulation(const Scene& scene, const RunOptions& options, const CheckpointReader& in,
                       const std::vector<int>& walls)
    : impl_(std::make_unique<Impl>()) {
  World& w = impl_->w;
  w.insertion = std::make_unique<Insertion>(scene);
  w.r_min = w.insertion->smallest_radius();
  w.r_max = w.insertion->largest_radius();
  w.failed = in.has("failed") || in.has("flux");  // may be looked at, but does not go on
  const auto m = in.read_value<Meta>("meta");
  configure(w, scene, options, in.has("fixed"));
  judge_time_step(w);
  if (m.stride != w.stride || m.history != w.has.history_columns ||
      m.materials != static_cast<std::int64_t>(scene.materials.size()) || m.dt != scene.dt)
    throw Error(ErrorCode::io, "the checkpoint belongs to another scene (contact law, materials or time step differ)",
                in.path());
  check_meta(m, scene, in);
  set_particle_capacity(w, static_cast<Row>(m.n));
  const auto get = [&](const char* name, void* to, std::size_t bytes) {
    const auto s = in.section(name);
    if (s.size() != bytes)
      throw Error(ErrorCode::io, std::string("section '") + name + "' has a wrong size", in.path());
    if (bytes != 0) std::memcpy(to, s.data(), bytes);
  };
  const auto n = static_cast<std::size_t>(m.n);
  get("position", w.p.data(), 32 * n);
  get("velocity", w.v.data(), 8 * n * static_cast<std::size_t>(w.stride));
  get("id", w.id.data(), 8 * n);
  if (w.has.materials) get("material", w.material.data(), n);
  if (in.has("fixed")) get("fixed", w.fixed.data(), n);  // an event that is new at a resume may be the first to need it
  if (w.has.groups) get("group", w.group.data(), 2 * n);
  w.p2 = w.p;
  w.v2 = w.v;
  w.step = m.step;
  w.next_event = static_cast<std::size_t>(m.next_event);
  w.next_id = m.next_id;
  w.gravity = {m.gravity[0], m.gravity[1], m.gravity[2]};
  w.counters.inserted = m.inserted;
  w.counters.removed = m.removed;
  w.counters.removed_mass = m.removed_mass;
  w.work.damping = m.losses[0];
  w.work.friction = m.losses[1];
  w.work.background = m.losses[2];
  w.work.wall = m.wall_work;
  w.work.drive = m.drive_power;
  w.work.gravity = m.gravity_work;
  w.inserted_energy = m.inserted_energy;
  w.start_energy = m.start_energy;
  w.start_energy_known = m.start_known != 0;
  if (w.has.energies && in.has("energies")) w.resumed = in.read_value<Energies>("energies");
  w.work_before = w.work;
  if (in.has("planes")) w.planes.load(in.section("planes"), in.path());
  w.insertion->load(in.section("insertion"));
  check_restored_rows(w, in.path());
  w.alive = 0;
  for (Row i = 0; i < w.n; ++i) {
    if (w.is_alive(i)) {
      ++w.alive;
    } else {
      w.x0[4L * i] = w.x0[4L * i + 1] = w.x0[4L * i + 2] = k_gone;
      w.x0[4L * i + 3] = 1e300;
    }
  }
  warn_of_meshes(w);
  choose_chunk(w);
  w.chunk_of = ChunkMap(w.chunk_size);
  make_chunks(w);
  std::vector<ContactEntry> contacts = read_contacts(w, in);
  std::vector<WallEntry> wall_entries = read_walls(w, in, walls);
  check_restored_contacts(w, contacts, wall_entries, in.path());
  if (w.has.walls) w.walls.set_step(w.step, w.scene.dt);
  with_threads(w, [&] {
    distribute_contacts(w, contacts, wall_entries);
    rebuild_tuned(w, false);
  });
  w.lists_valid = true;
  w.last_rebuild_step = w.step;
  ++w.counters.rebuilds_forced;
}

Simulation::~Simulation() = default;

void Simulation::run(std::int64_t steps) {
  World& w = impl_->w;
  if (w.failed.load())
    throw Error(ErrorCode::physics, "this run has failed and cannot go on", "step " + std::to_string(w.step));
  if (steps <= 0) return;
  const std::int64_t target = w.step + steps;
  // The balance starts with the first step of the motion proper: a relaxation takes energy out that nothing counts.
  const std::int64_t first = w.scene.relax.steps;
  if (w.has.energies && !w.start_energy_known && w.step <= first && target > first) {
    run_graph(w, first + 1);
    const Energies e = energies_of(w);
    w.start_energy = e.kinetic_translation + e.kinetic_rotation + e.potential + e.elastic + e.dissipated_damping +
                     e.dissipated_friction + e.dissipated_background - e.wall_work - e.inserted;
    w.start_energy_known = true;
  }
  if (w.step < target) run_graph(w, target);
}

const Scene& Simulation::scene() const noexcept { return impl_->w.scene; }
std::int64_t Simulation::step() const noexcept { return impl_->w.step; }
double Simulation::time() const noexcept { return static_cast<double>(impl_->w.step) * impl_->w.scene.dt; }
std::int64_t Simulation::particles() const noexcept { return impl_->w.alive; }
std::uint64_t Simulation::state_hash() const { return talus::state_hash(impl_->w); }
Energies Simulation::energies() const { return energies_of(impl_->w); }
double Simulation::kinetic_energy() const { return kinetic_energy_of(impl_->w); }
Frame Simulation::frame(const FrameRequest& request) const { return frame_of(impl_->w, request); }
const std::vector<PlaneTotal>& Simulation::planes() const noexcept { return impl_->w.planes.totals(); }
std::uint64_t Simulation::planes_hash() const { return impl_->w.planes.hash(); }
const TimeStepReport& Simulation::time_step() const noexcept { return impl_->w.time_step; }
Softening Simulation::softening(double speed) const {
  return talus::softening(impl_->w.scene, impl_->w.insertion->population(),
                          fmax2(speed, impl_->w.time_step.speeds.closing));
}
Plan Simulation::plan() const { return plan_of(impl_->w); }
std::vector<std::pair<std::string, MeshReport>> Simulation::meshes() const { return impl_->w.walls.meshes(); }
const std::vector<Warning>& Simulation::warnings() const noexcept { return impl_->w.monitor.warnings; }
const std::vector<ParticleId>& Simulation::culprits() const noexcept { return impl_->w.culprits; }
World& Simulation::world() noexcept { return impl_->w; }
std::size_t Simulation::bytes() const { return bytes_of(impl_->w); }

Counters Simulation::counters() const {
  const World& w = impl_->w;
  Counters c = w.counters;
  std::int64_t both = 0, border = 0;
  for (const auto& k : w.chunks) {
    both += k->contact_end[1] - k->contact_end[0];
    border += k->contact_end[0] + (k->contact_end[2] - k->contact_end[1]);
    c.wall_contacts += static_cast<std::int64_t>(k->wall_state.size());
  }
  c.contacts = both + border / 2;
  c.border_contact_share = c.contacts > 0 ? 0.5 * static_cast<double>(border) / static_cast<double>(c.contacts) : 0;
  return c;
}

const std::vector<ListRecord>& Simulation::list_series() const noexcept { return impl_->w.list_series.records; }
Profile Simulation::profile() const { return impl_->w.times.report(); }
void Simulation::restart_profile() { impl_->w.times.restart(); }
void Simulation::start_trace(std::int64_t first_step, std::int64_t steps) { impl_->w.times.trace(first_step, steps); }

void Simulation::write_trace(const std::string& path) const {
  const World& w = impl_->w;
  w.times.write(path, {{"particles", std::to_string(w.alive)},
                       {"threads", std::to_string(w.threads)},
                       {"chunk", std::to_string(w.chunk_size)},
                       {"chunks", std::to_string(w.chunks.size())},
                       {"bytes", std::to_string(bytes_of(w))},
                       {"sort_every", std::to_string(w.scene.sort_every)},
                       {"isa", std::string("\"") + w.kernels->name + "\""}});
}

void Simulation::save(CheckpointWriter& out) const {
  const World& w = impl_->w;
  Meta m{};
  m.step = w.step;
  m.next_event = static_cast<std::int64_t>(w.next_event);
  m.next_id = w.next_id;
  m.n = w.n;
  m.stride = w.stride;
  m.history = w.has.history_columns;
  m.materials = static_cast<std::int64_t>(w.scene.materials.size());
  m.inserted = w.counters.inserted;
  m.removed = w.counters.removed;
  m.removed_mass = w.counters.removed_mass;
  for (int k = 0; k < 3; ++k) m.gravity[k] = w.gravity[k];
  m.losses[0] = w.work.damping;
  m.losses[1] = w.work.friction;
  m.losses[2] = w.work.background;
  m.wall_work = w.work.wall;
  m.drive_power = w.work.drive;
  m.gravity_work = w.work.gravity;
  m.inserted_energy = w.inserted_energy;
  m.start_energy = w.start_energy;
  m.start_known = w.start_energy_known ? 1 : 0;
  m.dt = w.scene.dt;
  out.add_value("meta", m);
  if (w.failed.load()) out.add_value("failed", m.step);
  const auto n = static_cast<std::size_t>(w.n);
  out.add_view("position", w.p.data(), 4 * n);
  out.add_view("velocity", w.v.data(), static_cast<std::size_t>(w.stride) * n);
  out.add_view("id", w.id.data(), n);
  if (w.has.materials) out.add_view("material", w.material.data(), n);
  if (w.has.fixed) out.add_view("fixed", w.fixed.data(), n);
  if (w.has.groups) out.add_view("group", w.group.data(), n);
  write_contacts(w, out);
  if (w.has.energies) out.add_value("energies", energies_of(w));
  out.add("insertion", w.insertion->save());
  if (w.has.planes) out.add("planes", w.planes.save());
  // Not the K that a run has chosen: it follows measured times, and these bytes are the same however a run is done.
}

}  // namespace talus
