// See ledger.hpp.
#include "scheduler/state/ledger.hpp"

#include <algorithm>
#include <functional>

#include "scheduler/team/parallel.hpp"

namespace talus {

Ledger::Ledger(const Rules& rules, Columns& columns) {
  ColumnInfo i;
  i.name = "energy";
  i.unit = "J";
  i.in = rules.has.energies;
  i.why = i.in ? "output.energies" : "output.energies is off";
  i.width = 4;
  i.moves = false;
  columns.add(i, rows);
}

void Ledger::count_leavers(Columns& columns) {
  ColumnInfo i;
  i.name = "energy of pairs";
  i.unit = "J";
  i.why = "output.energies and grains that may leave";
  i.moves = false;
  columns.add(i, pairs);
}

void Ledger::count_sizes(Columns& columns) {
  ColumnInfo i;
  i.name = "energy by radius";
  i.unit = "N";
  i.why = "output.energies and changing sizes";
  i.moves = false;
  columns.add(i, push);
  ColumnInfo g;
  g.name = "growth";
  g.label = "growth of the last step, the one before";
  g.unit = "m";
  g.why = i.why;
  g.saved = true;
  columns.add(g, grown, &spare);
}

namespace {

/// Old radius over new one: rows of velocities hold radius times spin.
double size_ratio(const Rows& rows, Row i) {
  return rows.resized && rows.p[4L * i + 3] > 0 ? rows.p2[4L * i + 3] / rows.p[4L * i + 3] : 1;
}

/// Angular velocity of a body at n-1/2, as it lies at n, which the second buffers hold now [rad/s].
Vec3 old_spin(const Rules& rules, const Rows& rows, std::int32_t b) {
  const BodyState s = state_of(rows.bodies, b, true);
  if (rows.bodies.v[4L * b + 3] == 0) return s.spin;
  return spin_of(shape_of(rules, rows.bodies, b), 1 / inertia_scale(rows.bodies, b, true), shapes::rotation(s.turn),
                 s.spin);
}

/// The same of the body that row i leads: its scale changes, and with it place and radius of all its rows. The push is
/// then by scale [J].
std::array<double, 2> size_work_of_body(const Rules& rules, const Clock& clock, const Rows& rows, Ledger& ledger,
                                        Row i) {
  const auto at = static_cast<std::size_t>(i);
  ledger.spare[at] = 0;
  if (!rows.leads(i)) return {};
  const Bodies& bodies = rows.bodies;
  const std::int32_t b = rows.body_of(i);
  const double push = 0.5 * ledger.push[at], settled = push * ledger.grown[at];
  ledger.spare[at] = bodies.scale(b) - bodies.scale(b, true);
  const auto [u, inverse_mass] = velocity_of(rows, i);
  if (!rows.is_alive(i) || !(inverse_mass > 0)) return {settled, 0};
  const Vec3 v{u[0], u[1], u[2]}, x = bodies.centre(b), before = state_of(bodies, b, true).x;
  const double come = bodies.mass(b) - bodies.mass(b, true);
  const double ahead =
      push * ledger.spare[at] + 0.5 * come * norm2(v) +
      (1 - inertia_scale(bodies, b, true) / inertia_scale(bodies, b)) * rotation_energy(rules, bodies, b);
  const Vec3 along = gravity_along(rules, clock, false), pull = gravity_along(rules, clock, true);
  const Vec3 middle = 0.5 * (before + x) + rules.scene.domain.lower;
  return {settled, ahead - come * (dot(along, middle) + 0.5 * rules.scene.dt * dot(pull, v))};
}

/// What the changing size of row i brings in: on the way to n (place 0) what was not known before the contacts of n; on
/// that to n + 1 the share of those contacts, and the energy of the mass that comes, at the velocity between.
std::array<double, 2> size_work(const Rules& rules, const Clock& clock, const Rows& rows, Ledger& ledger, Row i) {
  if (rows.body_of(i) >= 0) return size_work_of_body(rules, clock, rows, ledger, i);
  const auto at = static_cast<std::size_t>(i);
  const double *x = rows.p2.data() + 4L * i, *next = rows.p.data() + 4L * i;
  const double push = 0.5 * ledger.push[at], settled = push * ledger.grown[at];
  ledger.spare[at] = next[3] - x[3];
  const auto [v, inverse_mass] = velocity_of(rows, i);
  if (!rows.is_alive(i) || !(inverse_mass > 0)) return {settled, 0};
  double ahead = push * ledger.spare[at];
  const double before = old_mass_of(rules, rows, i), after = mass_of(rules, rows, i), come = after - before;
  ahead += 0.5 * come * ((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
  if (rules.has.rotation) {  // the row holds the new radius times the spin
    const double scale = x[3] / next[3];
    ahead += 0.2 * (after - before * (scale * scale)) * ((v[4] * v[4] + v[5] * v[5]) + v[6] * v[6]);
  }
  const Vec3 along = gravity_along(rules, clock, false), pull = gravity_along(rules, clock, true);
  const Vec3 middle = 0.5 * Vec3{x[0] + next[0], x[1] + next[1], x[2] + next[2]} + rules.scene.domain.lower;
  ahead -= come * (dot(along, middle) + 0.5 * rules.scene.dt * dot(pull, Vec3{v[0], v[1], v[2]}));
  return {settled, ahead};
}

/// Terms of one block of rows: damping, friction, background, drive, gravity along periodic axes, in places 1 to 5.
StepWork work_of_rows(const Rules& rules, const Rows& rows, const Ledger& ledger, Row from, Row to, Vec3 pull) {
  StepWork part{};
  const bool pulled = norm2(pull) > 0;
  const auto mass = [&](Row i) { return rows.resized ? old_mass_of(rules, rows, i) : mass_of(rules, rows, i); };
  for (Row i = from; i < to; ++i) {
    const double* e = ledger.rows.data() + 4L * i;
    for (int k = 1; k < 3; ++k) part[k] = part[k] + e[k];
    // a driven row's work, or what local damping takes from a free one
    const bool free =
        rules.scene.local_damping != 0 && rows.v[static_cast<long>(rules.stride) * i + rules.stride - 1] > 0;
    part[free ? 3 : 4] += e[3];
    if (!rows.leads(i)) continue;
    if (pulled && rows.is_alive(i)) {
      // v2 holds v(n-1/2) now: what gravity has done on the way from n-1 to n
      const auto [u, inverse_mass] = velocity_of(rows, i, true);
      if (inverse_mass > 0) part[5] += rules.scene.dt * mass(i) * dot(pull, Vec3{u[0], u[1], u[2]});
    }
    if (rules.scene.viscous_damping != 0 && rows.is_alive(i)) {
      const auto [v, inverse_mass] = velocity_of(rows, i);
      const double* u = velocity_of(rows, i, true).v;
      double q = 0, rot = 0;
      for (int k = 0; k < 3; ++k) q += u[k] * (0.5 * (u[k] + v[k]));
      if (const std::int32_t body = rows.body_of(i); body >= 0)  // w_old (L_old + L) / 2, over 0.4 m as below
        rot = dot(old_spin(rules, rows, body), 0.5 * (momentum_in_space(rules, rows.bodies, body, true) +
                                                      momentum_in_space(rules, rows.bodies, body))) /
              (0.4 * rows.bodies.mass(body, true));
      else if (rules.has.rotation)
        for (int k = 4; k < 7; ++k) rot += u[k] * (0.5 * (u[k] + size_ratio(rows, i) * v[k]));
      if (inverse_mass > 0) part[3] += rules.scene.viscous_damping * rules.scene.dt * mass(i) * (q + 0.4 * rot);
    }
  }
  return part;
}

/// Sum over rows in fixed blocks of 1024 (I3).
double sum_all(const Rows& rows, const std::function<double(Row)>& value) {
  double total = 0;
  for (Row b = 0; b < rows.n; b += k_energy_block) {
    double part = 0;
    for (Row i = b; i < std::min<Row>(rows.n, b + k_energy_block); ++i)
      if (rows.is_alive(i)) part = part + value(i);
    total = total + part;
  }
  return total;
}

/// The same over the rows that lead a grain.
double sum_rows(const Rows& rows, const std::function<double(Row)>& value) {
  return sum_all(rows, [&](Row i) { return rows.leads(i) ? value(i) : 0.0; });
}

/// Energy of rotation of a body at n, with the mean of L(n-1/2) and L(n+1/2) as it lies at n [J].
double mean_rotation(const Rules& rules, const Rows& rows, std::int32_t b, bool start, bool given) {
  const Bodies& bodies = rows.bodies;
  if (start) return rotation_energy(rules, bodies, b);
  const BodyState then = state_of(bodies, b, true);
  const Vec3 before = momentum_in_space(rules, bodies, b, true),
             after = given ? before : momentum_in_space(rules, bodies, b);
  // in a step whose sizes change the spin stays, not the momentum
  const double size = bodies.resized ? inertia_scale(bodies, b, true) / inertia_scale(bodies, b) : 1;
  return rotation_energy(rules, bodies, b, shapes::to_body(shapes::rotation(then.turn), 0.5 * (before + size * after)),
                         true);
}

}  // namespace

void add_step_work(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts, Ledger& ledger,
                   Team& team) {
  // fixed blocks of 1024 rows in a fixed tree: independent of chunks and threads (I3)
  const Vec3 pull = gravity_along(rules, clock, true);
  const std::int64_t count = (rows.n + k_energy_block - 1) / k_energy_block;
  ledger.blocks.resize(static_cast<std::size_t>(count));
  const Blocks blocks{count, static_cast<int>(std::clamp<std::int64_t>(count / 8, 1, rules.threads))};
  parallel(team, blocks.count, [&](int q) {
    for (std::int64_t b = blocks.from(q); b < blocks.to(q); ++b) {
      const auto from = static_cast<Row>(b * k_energy_block);
      ledger.blocks[static_cast<std::size_t>(b)] =
          work_of_rows(rules, rows, ledger, from, std::min<Row>(rows.n, from + k_energy_block), pull);
      if (!rows.resized) continue;
      StepWork& part = ledger.blocks[static_cast<std::size_t>(b)];
      for (Row i = from; i < std::min<Row>(rows.n, from + k_energy_block); ++i) {
        const auto [settled, ahead] = size_work(rules, clock, rows, ledger, i);
        part[6] += settled;
        part[7] += ahead;
      }
    }
  });
  StepWork sum{};
  for (const StepWork& part : ledger.blocks)
    for (int k = 1; k < 8; ++k) sum[k] = sum[k] + part[k];
  double power = sum[4];
  if (rules.has.moving_walls)
    for (const auto& c : contacts.chunks)
      for (const double p : c->wall.power) power += p;
  ledger.work_before = ledger.work;
  ledger.left = 0;
  const double before = ledger.work.drive;
  ledger.work.drive = power;
  if (rows.resized) std::swap(ledger.grown, ledger.spare);
  const double known = ledger.work.sizes_ahead;
  ledger.work.sizes_ahead = sum[7];
  if (clock.step <= rules.scene.relax.steps) return;
  ledger.work.damping += sum[1];
  ledger.work.friction += sum[2];
  ledger.work.background += sum[3];
  ledger.work.gravity += sum[5];
  ledger.work.sizes += known + sum[6];
  // energies hold at n: the trapezium rule over [n-1, n]
  ledger.work.wall += 0.5 * (before + power);
}

double kinetic_energy_of(const Rules& rules, const Rows& rows) {
  return sum_rows(rows, [&](Row i) {
    const double* v = velocity_of(rows, i).v;
    return 0.5 * mass_of(rules, rows, i) * ((v[0] * v[0] + v[1] * v[1]) + v[2] * v[2]);
  });
}

Energies energies_of(const Rules& rules, const Clock& clock, const Rows& rows, const Ledger& ledger,
                     std::int64_t executed, const double* springs) {
  Energies e;
  if (!rules.has.energies) return e;
  const bool start = clock.step == 0;
  if (!start && executed == 0) return ledger.resumed;
  if (!start && !rows.velocity_at_old_step) return e;
  // state of step n = clock.step - 1: positions p2, velocities at n the mean of n - 1/2 (v2) and n + 1/2 (v), at the
  // start those given; before the first step what is given
  const bool given =
      clock.step == 1 && rules.scene.integrator == Integrator::velocity_verlet && rules.scene.relax.steps == 0;
  const auto mass = [&](Row i) {
    return rows.resized && !start ? old_mass_of(rules, rows, i) : mass_of(rules, rows, i);
  };
  const auto mean2 = [&](Row i, int from) {
    const double *u = velocity_of(rows, i, !start).v, *v = given ? u : velocity_of(rows, i).v;
    const double scale = from == 4 && !start && !given ? size_ratio(rows, i) : 1;
    double s = 0;
    for (int k = from; k < from + 3; ++k) s += 0.25 * (u[k] + scale * v[k]) * (u[k] + scale * v[k]);
    return s;
  };
  e.kinetic_translation = sum_rows(rows, [&](Row i) { return 0.5 * mass(i) * mean2(i, 0); });
  if (rules.has.rotation || rules.has.bodies)
    e.kinetic_rotation = sum_rows(rows, [&](Row i) {
      if (const std::int32_t b = rows.body_of(i); b >= 0) return mean_rotation(rules, rows, b, start, given);
      return rules.has.rotation ? 0.2 * mass(i) * mean2(i, 4) : 0.0;
    });
  const Vec3 weight = gravity_along(rules, clock, false);
  e.potential = -ledger.work.gravity - sum_rows(rows, [&](Row i) {
    const std::int32_t b = rows.body_of(i);
    const double* x =
        b < 0 ? (start ? rows.p : rows.p2).data() + 4L * i : (start ? rows.bodies.x : rows.bodies.x2).data() + 4L * b;
    const bool free = velocity_of(rows, i).inverse_mass > 0;
    return free ? mass(i) * dot(weight, Vec3{x[0], x[1], x[2]} + rules.scene.domain.lower) : 0.0;
  });
  e.elastic = sum_all(rows, [&](Row i) { return springs[4L * i]; }) - ledger.left;
  e.dissipated_damping = ledger.work.damping;
  e.dissipated_friction = ledger.work.friction;
  e.dissipated_background = ledger.work.background;
  e.wall_work = ledger.work.wall;
  e.inserted = ledger.inserted;
  e.sizes = ledger.work.sizes;
  const double total = e.kinetic_translation + e.kinetic_rotation + e.potential + e.elastic + e.dissipated_damping +
                       e.dissipated_friction + e.dissipated_background - e.wall_work - e.inserted - e.sizes;
  e.residual = ledger.start_known ? total - ledger.start : 0;
  return e;
}

}  // namespace talus
