// See events.hpp.
#include "scheduler/nodes/events.hpp"

#include <fmt/format.h>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/grains/region.hpp"
#include "scheduler/part.hpp"

namespace talus {

namespace {

void set_gravity(const Rules& rules, Clock& clock, const Rows& rows, Ledger& ledger, Vec3 gravity) {
  double energy = 0;
  if (rules.has.energies)
    for (Row i = 0; i < rows.n; ++i)
      if (rows.is_alive(i)) energy -= row_energy(rules, rows, clock, i);
  clock.gravity = gravity;
  if (rules.has.energies)
    for (Row i = 0; i < rows.n; ++i)
      if (rows.is_alive(i)) energy += row_energy(rules, rows, clock, i);
  ledger.inserted += energy;
}

bool concerns(const Rules& rules, const Rows& rows, const Event& e, Row i) {
  if (e.group < 0) return true;
  const GroupSpec& g = rules.scene.groups[static_cast<std::size_t>(e.group)];
  if (rows.group[i] == e.group) return true;
  if (g.fixed_in_file && rows.fixed[i] != 0) return true;
  if (g.ids && rows.id[i] >= (*g.ids)[0] && rows.id[i] <= (*g.ids)[1]) return true;
  return g.region && inside(rules.scene.domain, *g.region, centre_of(rules, rows, i));
}

void set_motion(const Rules& rules, Rows& rows, Row i, Vec3 velocity, Vec3 spin) {
  double* v = rows.v.data() + static_cast<long>(rows.stride) * i;
  const double r = rows.p[4L * i + 3];
  for (int k = 0; k < 3; ++k) v[k] = velocity[k];
  if (rules.has.rotation)
    for (int k = 0; k < 3; ++k) v[4 + k] = r * spin[k];
}

/// The same for the body that row i leads.
void act_on_body(const Rules& rules, Rows& rows, const Event& e, Row i) {
  Bodies& bodies = rows.bodies;
  const std::int32_t b = rows.body_of(i);
  double* v = bodies.v.data() + 4L * b;
  const bool moves = e.action == Event::Action::drive || e.action == Event::Action::set_velocity;
  Vec3 spin = angular_velocity(rules, bodies, b);
  if (e.action == Event::Action::freeze || moves) {
    const Vec3 velocity = moves ? e.vector : Vec3{};
    for (int k = 0; k < 3; ++k) v[k] = velocity[k];
    spin = moves ? e.spin : Vec3{};
  }
  if (e.action == Event::Action::freeze || e.action == Event::Action::drive) v[3] = 0;
  if (e.action == Event::Action::release) v[3] = 1 / bodies.mass(b);
  set_angular_velocity(rules, bodies, b, spin);
  place_rows(rules, rows, b);
  if (!rules.has.fixed) return;
  const auto count = static_cast<Row>(shape_of(rules, bodies, b).spheres.size());
  for (Row k = i; k < i + count; ++k) rows.fixed[k] = v[3] == 0 ? 1 : 0;
}

/// Everything but removal and gravity.
void act_on_row(const Rules& rules, Rows& rows, const Event& e, Row i) {
  if (rows.body_of(i) >= 0) return act_on_body(rules, rows, e, i);
  double& inverse_mass = rows.v[static_cast<std::size_t>(rows.stride) * static_cast<std::size_t>(i + 1) - 1];
  switch (e.action) {
    case Event::Action::freeze:
    case Event::Action::drive:
      if (e.action == Event::Action::freeze)
        set_motion(rules, rows, i, {}, {});
      else
        set_motion(rules, rows, i, e.vector, e.spin);
      inverse_mass = 0;
      rows.fixed[i] = 1;
      break;
    case Event::Action::release:
      if (!rules.has.fixed) break;  // nothing was ever held: there is no such column
      inverse_mass = 1.0 / mass_of(rules, rows, i);
      rows.fixed[i] = 0;
      break;
    case Event::Action::set_velocity:
      set_motion(rules, rows, i, e.vector, e.spin);
      break;
    default:
      break;
  }
}

void warn_of_nobody(const Rules& rules, const Clock& clock, const Event& e, Monitor& monitor) {
  monitor.warnings.push_back(
      {"event",
       fmt::format("the event at {:g} s ({}) concerns no grain: group '{}' has none at step {}", e.time,
                   enum_word(e.action), rules.scene.groups[static_cast<std::size_t>(e.group)].name, clock.step),
       clock.step, 1, 0, 0});
}

/// Particles due at this step. A pack that finds no room ends a run that has come this far, not the scene.
NewParticles batch_of(const Clock& clock, const Rows& rows, const WallSet& walls, Insertion& insertion) {
  const PresentParticles present{std::span<const double>(rows.p.data(), 4L * static_cast<std::size_t>(rows.n))};
  try {
    return insertion.batch(clock.step, present, &walls);
  } catch (const Error& e) {
    throw Error(ErrorCode::physics, e.what(), "step " + std::to_string(clock.step));
  }
}

}  // namespace

bool event_due(const Rules& rules, const Clock& clock) {
  const auto& events = rules.scene.events;
  return clock.next_event < events.size() && det::nearest(events[clock.next_event].time / rules.scene.dt) <= clock.step;
}

void apply_events(const Rules& rules, Clock& clock, Rows& rows, Lists& lists, Ledger& ledger, Counters& counters,
                  Parts& parts, Monitor& monitor) {
  for (; event_due(rules, clock); ++clock.next_event) {
    const Event& e = rules.scene.events[clock.next_event];
    if (e.action == Event::Action::gravity) {
      set_gravity(rules, clock, rows, ledger, e.vector);
      continue;
    }
    bool any = false;
    for (Row i = 0; i < rows.n; ++i) {
      if (!rows.is_alive(i) || !rows.leads(i) || !concerns(rules, rows, e, i)) continue;
      any = true;
      if (e.action == Event::Action::remove) {
        remove_row(rules, clock, rows, lists, ledger, counters, parts, i);
        continue;
      }
      const double energy = rules.has.energies ? row_energy(rules, rows, clock, i) : 0;
      act_on_row(rules, rows, e, i);
      if (rules.has.energies) ledger.inserted += row_energy(rules, rows, clock, i) - energy;
    }
    if (!any) warn_of_nobody(rules, clock, e, monitor);
  }
}

bool insert_batch(const Rules& rules, const Clock& clock, const WallSet& walls, Insertion& insertion, Rows& rows,
                  Contacts& contacts, Ledger& ledger, Counters& counters, Parts& parts) {
  const NewParticles a = batch_of(clock, rows, walls, insertion);
  if (a.size() == 0) return false;
  const Row first = rows.n;
  append_particles(rules, clock, rows, a, rules.has.energies ? &ledger.inserted : nullptr);
  parts.appended(rows, first, a);
  counters.inserted += a.grains();
  rows.velocity_at_old_step = false;
  make_chunks(contacts, rows);  // rows of existing chunks stay; their lists are carried by the rebuild that follows
  return true;
}

double elastic_in(const Column<double>& energies, const Rows& rows) {
  double sum = 0;
  for (Row i = 0; i < rows.n; ++i)
    if (rows.is_alive(i)) sum = sum + energies[4 * static_cast<std::size_t>(i)];
  return sum;
}

void remove_row(const Rules& rules, const Clock& clock, Rows& rows, Lists& lists, Ledger& ledger, Counters& counters,
                Parts& parts, Row i) {
  if (!rows.is_alive(i)) return;
  ++counters.removed;
  counters.removed_mass += mass_of(rules, rows, i);
  if (rules.has.energies) ledger.inserted -= row_energy(rules, rows, clock, i);
  Row end = i + 1;
  if (const std::int32_t b = rows.body_of(i); b >= 0) {
    end = i + static_cast<Row>(shape_of(rules, rows.bodies, b).spheres.size());
    --rows.bodies_alive;
    rows.of_bodies -= end - i;
  }
  for (; i < end; ++i) {
    --rows.alive;
    parts.removed(rows, i);
    mark_gone(rows, lists, i);
  }
}

}  // namespace talus
