// See checkpoint.hpp. Columns save and load themselves (Columns); here is what is no column.
#include "scheduler/step/checkpoint.hpp"

#include <cmath>
#include <cstring>

#include "core/base/count.hpp"
#include "core/base/error.hpp"
#include "scheduler/lists/rebuild.hpp"
#include "scheduler/state/contact_records.hpp"
#include "scheduler/state/restored_state.hpp"
#include "scheduler/step/step.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/view/observe.hpp"

namespace talus {

namespace {

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

Meta meta_of(const World& w) {
  Meta m{};
  m.step = w.clock.step;
  m.next_event = static_cast<std::int64_t>(w.clock.next_event);
  m.next_id = w.rows.next_id;
  m.n = w.rows.n;
  m.stride = w.rules.stride;
  m.history = w.rules.has.history_columns;
  m.materials = static_cast<std::int64_t>(w.rules.scene.materials.size());
  m.inserted = w.counters.inserted;
  m.removed = w.counters.removed;
  m.removed_mass = w.counters.removed_mass;
  for (int k = 0; k < 3; ++k) m.gravity[k] = w.clock.gravity[k];
  m.losses[0] = w.ledger.work.damping;
  m.losses[1] = w.ledger.work.friction;
  m.losses[2] = w.ledger.work.background;
  m.wall_work = w.ledger.work.wall;
  m.drive_power = w.ledger.work.drive;
  m.gravity_work = w.ledger.work.gravity;
  m.inserted_energy = w.ledger.inserted;
  m.start_energy = w.ledger.start;
  m.start_known = w.ledger.start_known ? 1 : 0;
  m.dt = w.rules.scene.dt;
  return m;
}

void take_meta(World& w, const Meta& m) {
  w.clock.step = w.team.times.step = m.step;
  w.clock.next_event = static_cast<std::size_t>(m.next_event);
  w.rows.next_id = m.next_id;
  w.clock.gravity = {m.gravity[0], m.gravity[1], m.gravity[2]};
  w.counters.inserted = m.inserted;
  w.counters.removed = m.removed;
  w.counters.removed_mass = m.removed_mass;
  w.ledger.work.damping = m.losses[0];
  w.ledger.work.friction = m.losses[1];
  w.ledger.work.background = m.losses[2];
  w.ledger.work.wall = m.wall_work;
  w.ledger.work.drive = m.drive_power;
  w.ledger.work.gravity = m.gravity_work;
  w.ledger.inserted = m.inserted_energy;
  w.ledger.start = m.start_energy;
  w.ledger.start_known = m.start_known != 0;
  w.ledger.work_before = w.ledger.work;
}

/// Entries of n rows or bodies.
void load_columns(const Columns& columns, std::size_t n, const CheckpointReader& in) {
  for (const Columns::Entry& e : columns.all()) {
    if (!e.info.in || !e.info.saved || (e.info.optional && !in.has(e.info.name))) continue;
    const auto s = in.section(e.info.name);
    if (s.size() != e.bytes * n)
      throw Error(ErrorCode::io, "section '" + e.info.name + "' has a wrong size", in.path());
    if (!s.empty()) std::memcpy(e.data(), s.data(), s.size());
  }
  for (const Columns::Entry& e : columns.all())
    if (e.info.in && e.spare != nullptr && n > 0) std::memcpy(e.data_of(e.spare), e.data(), e.bytes * n);
}

void load_bodies(Rows& rows, const CheckpointReader& in) {
  Bodies& bodies = rows.bodies;
  if (!bodies.in) return;
  const std::size_t n = in.section("body_shape").size() / sizeof(std::int32_t);
  if (n > static_cast<std::size_t>(rows.n))
    throw Error(ErrorCode::io, "section 'body_shape': more bodies than particles", in.path());
  set_body_capacity(bodies, static_cast<std::int32_t>(n));
  load_columns(bodies.columns, n, in);
  std::fill(bodies.first.begin(), bodies.first.end(), -1);
  for (Row i = rows.n; i-- > 0;)  // numbers that no run wrote are refused with the rows
    if (const std::int32_t b = rows.body[static_cast<std::size_t>(i)]; b >= 0 && b < bodies.n)
      bodies.first[static_cast<std::size_t>(b)] = i;
}

using SavedEnergies = std::array<double, 10>;  // without those of changing sizes, which most scenes have not
static_assert(sizeof(SavedEnergies) == offsetof(Energies, sizes));

void save_energies(const World& w, CheckpointWriter& out) {
  const Energies e = energies_of(w);
  SavedEnergies saved;
  std::memcpy(&saved, &e, sizeof saved);
  out.add_value("energies", saved);
  const WorkTotals& t = w.ledger.work;
  if (w.rows.resized) out.add_value("energies of sizes", std::array<double, 3>{e.sizes, t.sizes, t.sizes_ahead});
}

void take_energies(World& w, const CheckpointReader& in) {
  const auto saved = in.read_value<SavedEnergies>("energies");
  std::memcpy(static_cast<void*>(&w.ledger.resumed), &saved, sizeof saved);
  if (!w.rows.resized) return;
  const auto sizes = in.read_value<std::array<double, 3>>("energies of sizes");
  w.ledger.resumed.sizes = sizes[0];
  w.ledger.work.sizes = w.ledger.work_before.sizes = sizes[1];
  w.ledger.work.sizes_ahead = w.ledger.work_before.sizes_ahead = sizes[2];
}

void load_parts(Parts& parts, const CheckpointReader& in) {
  for (const auto& p : parts.all)
    if (const std::string section = "part " + p->name(); in.has(section)) p->load(in.section(section), in.path());
}

/// The contacts go to their chunks, and the lists are made.
void restore_lists(World& w, const CheckpointReader& in, const std::vector<int>& walls) {
  const std::vector<ContactEntry> contacts = read_contacts(w.rules, in);
  const std::vector<WallEntry> entries = read_walls(w.rules, w.walls, in, walls);
  check_restored_contacts(w.rules, w.rows, w.walls, contacts, entries, in.path());
  if (w.rules.has.walls) w.walls.set_step(w.clock.step, w.rules.scene.dt);
  taking_back(w, [&] {
    with_threads(w.team, [&] {
      distribute_contacts(w.rules, w.rows, w.contacts, w.team, contacts, entries);
      rebuild_tuned(w.rules, w.clock, w.rows, w.contacts, w.lists, w.counters, w.walls, w.team, false);
    });
  });
  w.lists.valid = true;
  w.lists.last_rebuild_step = w.clock.step;
  ++w.counters.rebuilds_forced;
}

}  // namespace

std::int64_t step_of_checkpoint(const CheckpointReader& in) { return in.read_value<Meta>("meta").step; }

void restore_state(World& w, const CheckpointReader& in, const std::vector<int>& walls) {
  if (in.has("failed") || in.has("flux")) w.team.failure.mark();  // may be looked at, but does not go on
  const auto m = in.read_value<Meta>("meta");
  const Scene& scene = w.rules.scene;
  if (m.stride != w.rules.stride || m.history != w.rules.has.history_columns ||
      m.materials != static_cast<std::int64_t>(scene.materials.size()) || m.dt != scene.dt)
    throw Error(ErrorCode::io, "the checkpoint belongs to another scene (contact law, materials or time step differ)",
                in.path());
  check_meta(m, scene, in);
  set_particle_capacity(w.rows, static_cast<Row>(m.n));
  load_columns(w.rows.columns, static_cast<std::size_t>(m.n), in);
  load_bodies(w.rows, in);
  take_meta(w, m);
  if (w.rules.has.energies && in.has("energies")) take_energies(w, in);
  if (in.has("planes")) w.planes.load(in.section("planes"), in.path());
  load_parts(w.parts, in);
  w.insertion->load(in.section("insertion"));
  check_restored_rows(w.rules, w.rows, in.path());
  w.rows.alive = 0;
  for (Row i = 0; i < w.rows.n; ++i) {
    if (!w.rows.is_alive(i)) continue;
    ++w.rows.alive;
    if (w.rows.body_of(i) < 0) continue;
    ++w.rows.of_bodies;
    w.rows.bodies_alive += w.rows.leads(i) ? 1 : 0;
  }
  warn_of_meshes(w.rules, w.clock, w.walls, w.monitor);
  cut_into_chunks(w);
  restore_lists(w, in, walls);
}

void save_state(const World& w, CheckpointWriter& out) {
  const bool failed = w.team.failure.any();
  const Meta m = meta_of(w);
  out.add_value("meta", m);
  if (failed) out.add_value("failed", m.step);
  const auto n = static_cast<std::size_t>(w.rows.n);
  for (const Columns::Entry& e : w.rows.columns.all())
    if (e.info.in && e.info.saved) out.add_view(e.info.name, e.data(), e.bytes * n);
  for (const Columns::Entry& e : w.rows.bodies.columns.all())
    if (e.info.in) out.add_view(e.info.name, e.data(), e.bytes * static_cast<std::size_t>(w.rows.bodies.n));
  write_contacts(w.rules, w.contacts, w.walls, failed, out);
  if (w.rules.has.energies) save_energies(w, out);
  out.add("insertion", w.insertion->save());
  if (w.rules.has.planes) out.add("planes", w.planes.save());
  for (const auto& p : w.parts.all)
    if (std::vector<std::uint8_t> bytes = p->save(); !bytes.empty()) out.add("part " + p->name(), std::move(bytes));
  // Not the K that a run has chosen: it follows measured times, and these bytes are the same however a run is done.
}

}  // namespace talus
