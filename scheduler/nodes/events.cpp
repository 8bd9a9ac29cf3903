// See events.hpp.
#include "scheduler/nodes/events.hpp"

#include <fmt/format.h>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/grains/region.hpp"
#include "scheduler/part.hpp"

namespace talus {

namespace {

/// An event gives velocities at n, a free row holds those at n-1/2: the kick of n, whose first half lies before the
/// event, is one of gravity's too many by this time. Before the first step there is no such half.
double half_kick(const Rules& rules, const Clock& clock) { return clock.step == 0 ? 0.0 : 0.5 * rules.scene.dt; }

double* velocity_in(Rows& rows, Row i) {
  const std::int32_t b = rows.body_of(i);
  return b >= 0 ? rows.bodies.v.data() + 4L * b : rows.v.data() + static_cast<long>(rows.stride) * i;
}

/// What gravity does along periodic axes in the step that ends here, as the ledger will sum it [J].
double pull_of_step(const Rules& rules, const Clock& clock, const Rows& rows, Row i) {
  const auto [u, inverse_mass] = velocity_of(rows, i);
  if (!(inverse_mass > 0)) return 0;
  return rules.scene.dt * mass_of(rules, rows, i) * dot(gravity_along(rules, clock, true), Vec3{u[0], u[1], u[2]});
}

/// Row i is changed by `act`; the ledger gets the energy that it brings, and keeps the work of the step before.
template <class Act>
void change_row(const Rules& rules, Clock& clock, Rows& rows, Ledger& ledger, Row i, const Act& act) {
  if (!rules.has.energies) return act();
  const double energy = row_energy(rules, rows, clock, i), pull = pull_of_step(rules, clock, rows, i);
  act();
  ledger.inserted += row_energy(rules, rows, clock, i) - energy;
  if (clock.step > rules.scene.relax.steps) ledger.work.gravity += pull - pull_of_step(rules, clock, rows, i);
}

/// Velocities at n stay as they are. Grains that are still being pushed apart have had no gravity yet.
void set_gravity(const Rules& rules, Clock& clock, Rows& rows, Ledger& ledger, Vec3 gravity) {
  const Vec3 before = clock.gravity;
  const Vec3 turn = (clock.step > rules.scene.relax.steps ? half_kick(rules, clock) : 0.0) * (before - gravity);
  for (Row i = 0; i < rows.n; ++i) {
    if (!rows.is_alive(i) || !rows.leads(i)) continue;
    clock.gravity = before;
    change_row(rules, clock, rows, ledger, i, [&] {
      clock.gravity = gravity;
      if (!(velocity_of(rows, i).inverse_mass > 0)) return;
      double* v = velocity_in(rows, i);
      for (int k = 0; k < 3; ++k) v[k] += turn[k];
      if (const std::int32_t b = rows.body_of(i); b >= 0) place_rows(rules, rows, b);
    });
  }
  clock.gravity = gravity;
}

bool concerns(const Rules& rules, const Rows& rows, const Event& e, Row i) {
  if (e.group < 0) return true;
  const GroupSpec& g = rules.scene.groups[static_cast<std::size_t>(e.group)];
  if (rows.group[i] == e.group) return true;
  if (g.fixed_in_file && rows.in_file[i] != 0) return true;
  if (g.ids && rows.id[i] >= (*g.ids)[0] && rows.id[i] <= (*g.ids)[1]) return true;
  return g.region && inside(rules.scene.domain, *g.region, centre_of(rules, rows, i));
}

/// A row that is released, or free and given a velocity, goes on from n with that of its first half step taken away.
Vec3 carried(const Rules& rules, const Clock& clock, Vec3 at_n, bool free) {
  return free ? at_n - half_kick(rules, clock) * clock.gravity : at_n;
}

void set_motion(const Rules& rules, Rows& rows, Row i, Vec3 velocity, Vec3 spin) {
  double* v = rows.v.data() + static_cast<long>(rows.stride) * i;
  const double r = rows.p[4L * i + 3];
  for (int k = 0; k < 3; ++k) v[k] = velocity[k];
  if (rules.has.rotation)
    for (int k = 0; k < 3; ++k) v[4 + k] = r * spin[k];
}

/// The same for the body that row i leads.
void act_on_body(const Rules& rules, const Clock& clock, Rows& rows, const Event& e, Row i) {
  Bodies& bodies = rows.bodies;
  const std::int32_t b = rows.body_of(i);
  double* v = bodies.v.data() + 4L * b;
  const bool held = v[3] == 0, moves = e.action == Event::Action::drive || e.action == Event::Action::set_velocity;
  Vec3 velocity{v[0], v[1], v[2]}, spin = angular_velocity(rules, bodies, b);
  if (e.action == Event::Action::freeze || moves) {
    velocity = moves ? e.vector : Vec3{};
    spin = moves ? e.spin : Vec3{};
  }
  if (e.action == Event::Action::freeze || e.action == Event::Action::drive) v[3] = 0;
  if (e.action == Event::Action::release) v[3] = 1 / bodies.mass(b);
  if (e.action != Event::Action::release || held) velocity = carried(rules, clock, velocity, v[3] > 0);
  for (int k = 0; k < 3; ++k) v[k] = velocity[k];
  set_angular_velocity(rules, bodies, b, spin);
  place_rows(rules, rows, b);
  if (!rules.has.fixed) return;
  const auto count = static_cast<Row>(shape_of(rules, bodies, b).spheres.size());
  for (Row k = i; k < i + count; ++k) rows.fixed[k] = v[3] == 0 ? 1 : 0;
}

/// Everything but removal and gravity.
void act_on_row(const Rules& rules, const Clock& clock, Rows& rows, const Event& e, Row i) {
  if (rows.body_of(i) >= 0) return act_on_body(rules, clock, rows, e, i);
  double* v = rows.v.data() + static_cast<long>(rows.stride) * i;
  double& inverse_mass = v[rows.stride - 1];
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
    case Event::Action::release: {
      if (!rules.has.fixed || inverse_mass > 0) break;  // no such column: nothing was ever held
      const Vec3 u = carried(rules, clock, {v[0], v[1], v[2]}, true);
      for (int k = 0; k < 3; ++k) v[k] = u[k];
      inverse_mass = 1.0 / mass_of(rules, rows, i);
      rows.fixed[i] = 0;
      break;
    }
    case Event::Action::set_velocity:
      set_motion(rules, rows, i, carried(rules, clock, e.vector, inverse_mass > 0), e.spin);
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
      change_row(rules, clock, rows, ledger, i, [&] { act_on_row(rules, clock, rows, e, i); });
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
