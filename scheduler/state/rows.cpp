// See rows.hpp.
#include "scheduler/state/rows.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/base/memory.hpp"
#include "core/grains/body.hpp"
#include "kernels/views.hpp"

namespace talus {
namespace {

bool asks_for_file(const Scene& scene) {
  return std::any_of(scene.groups.begin(), scene.groups.end(), [](const GroupSpec& g) { return g.fixed_in_file; });
}

}  // namespace

Rows::Rows(const Rules& rules) : stride(rules.stride), bodies(rules) {
  const Features& h = rules.has;
  const auto row = [](const char* name, const char* label, const char* unit, const char* why, int width,
                      std::vector<double> dead) {
    ColumnInfo i;
    i.name = name;
    i.label = label;
    i.unit = unit;
    i.why = why;
    i.width = width;
    i.dead = std::move(dead);
    i.saved = true;
    return i;
  };
  columns.add(row("position", "p, p2", "m", "position and radius, double buffered", 4, {k_gone, k_gone, k_gone, 0}), p,
              &p2);
  std::vector<double> still(static_cast<std::size_t>(stride), 0.0);
  still.back() = 1.0;  // padding lanes divide by it
  columns.add(
      row("velocity", "v, v2", "m/s",
          h.rotation ? "velocity, r*spin, 1/m, double buffered" : "velocity and 1/m, double buffered", stride, still),
      v, &v2);
  columns.add(row("id", "id", "", "identity", 1, {-1}), id);
  const auto optional = [&](const char* name, bool in, const char* with, const char* without, double dead) {
    ColumnInfo i = row(name, name, "", in ? with : without, 1, {dead});
    i.in = in;
    return i;
  };
  columns.add(optional("material", h.materials, "several materials", "one material", 0), material);
  ColumnInfo held = optional("fixed", h.fixed, "some particles are or become fixed", "nothing is fixed", 0);
  held.optional = true;  // an event that is new at a resume may be the first to need it
  columns.add(held, fixed);
  columns.add(
      optional("fixed in file", asks_for_file(rules.scene), "a group of what is fixed in its file", "no such group", 0),
      in_file);
  columns.add(optional("group", h.groups, "scene.groups", "no groups", -1), group);
  columns.add(optional("body", h.bodies, "a source makes bodies", "no source makes bodies", -1), body);
}

namespace {

double mass_from(const Rules& rules, const Rows& rows, const Column<double>& v, const Column<double>& p, Row i) {
  if (rows.resized)
    if (const double inverse = v[static_cast<long>(rows.stride) * (i + 1) - 1]; inverse > 0) return 1 / inverse;
  return Body{p[4L * i + 3], rules.scene.materials[rules.has.materials ? rows.material[i] : 0].density}.mass();
}

}  // namespace

double mass_of(const Rules& rules, const Rows& rows, Row i) {
  if (const std::int32_t b = rows.body_of(i); b >= 0) return rows.leads(i) ? rows.bodies.mass(b) : 0;
  return mass_from(rules, rows, rows.v, rows.p, i);
}
double old_mass_of(const Rules& rules, const Rows& rows, Row i) {
  if (const std::int32_t b = rows.body_of(i); b >= 0) return rows.leads(i) ? rows.bodies.mass(b, true) : 0;
  return mass_from(rules, rows, rows.v2, rows.p2, i);
}

Vec3 gravity_along(const Rules& rules, const Clock& clock, bool periodic) {
  Vec3 g = clock.gravity;
  for (int k = 0; k < 3; ++k)
    if (rules.scene.domain.periodic(k) != periodic) g[k] = 0;
  return g;
}

double row_energy(const Rules& rules, const Rows& rows, const Clock& clock, Row i) {
  if (!rows.leads(i)) return 0;
  const std::int32_t body = rows.body_of(i);
  const auto [u, inverse_mass] = velocity_of(rows, i);
  const double m = mass_of(rules, rows, i);
  // the row holds v(n-1/2); what gravity adds on the way to n is known, what contacts do is not. At the start v(0).
  const bool free = inverse_mass > 0;
  const bool exact = (clock.step == 0 && rules.scene.integrator == Integrator::velocity_verlet) || !free;
  const Vec3 now = Vec3{u[0], u[1], u[2]} + (exact ? 0.0 : 0.5 * rules.scene.dt) * clock.gravity;
  double e = 0.5 * m * norm2(now);
  if (body >= 0)
    e += rotation_energy(rules, rows.bodies, body);
  else if (rules.has.rotation)
    e += 0.2 * m * ((u[4] * u[4] + u[5] * u[5]) + u[6] * u[6]);
  return free ? e - m * dot(gravity_along(rules, clock, false), centre_of(rules, rows, i)) : e;
}

Vec3 centre_of(const Rules& rules, const Rows& rows, Row i) {
  const std::int32_t b = rows.body_of(i);
  return b < 0 ? position_of(rules, rows, i) : rows.bodies.centre(b) + rules.scene.domain.lower;
}

GrainVelocity velocity_of(const Rows& rows, Row i, bool second) {
  if (const std::int32_t b = rows.body_of(i); b >= 0) {
    const double* v = (second ? rows.bodies.v2 : rows.bodies.v).data() + 4L * b;
    return {v, v[3]};
  }
  const double* v = (second ? rows.v2 : rows.v).data() + static_cast<long>(rows.stride) * i;
  return {v, v[rows.stride - 1]};
}

Vec3 position_of(const Rules& rules, const Rows& rows, Row i) {
  const double* x = rows.p.data() + 4L * i;
  return Vec3{x[0], x[1], x[2]} + rules.scene.domain.lower;
}

bool finite_row(const Rows& rows, Row i) {
  const double *x = rows.p.data() + 4L * i, *v = rows.v.data() + static_cast<long>(rows.stride) * i;
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += 0 * x[k] + 0 * v[k];
  if (rows.stride == 8)
    for (int k = 4; k < 7; ++k) sum += 0 * v[k];
  return sum == 0;
}

void set_particle_capacity(Rows& rows, Row n) {
  rows.columns.resize(static_cast<std::size_t>(n) + k_pad, std::min(rows.n, n));
  rows.n = n;
}

namespace {

/// Judges the memory that the columns take when they must grow: vectors double.
void require_room(const Clock& clock, const Rows& rows, std::size_t count) {
  constexpr double row = 250;  // [B] of all columns
  const std::size_t room = rows.p.capacity() / 4;
  if (count <= room) return;
  const double more = static_cast<double>(std::max(count, 2 * room)) - 0.5 * static_cast<double>(room);
  require_memory(row * more, fmt::format("room for {} particles", count), fmt::format("step {}", clock.step),
                 "let the sources deliver fewer", ErrorCode::physics);
}

}  // namespace

void append_particles(const Rules& rules, const Clock& clock, Rows& rows, const NewParticles& a, double* energy) {
  const Row first = rows.n;
  if (static_cast<std::int64_t>(first) + static_cast<std::int64_t>(a.size()) > (std::int64_t{1} << 30))
    throw Error(ErrorCode::physics, "more than 2^30 particles", "step " + std::to_string(clock.step));
  require_room(clock, rows, static_cast<std::size_t>(first) + a.size());
  set_particle_capacity(rows, first + static_cast<Row>(a.size()));
  // a grain born at step n carries v(n-1/2) = v - g dt/2
  const double half = clock.step == 0 ? 0.0 : 0.5 * rules.scene.dt;
  auto body = a.bodies.begin();
  const bool remembered = asks_for_file(rules.scene);
  for (std::size_t q = 0; q < a.size(); ++q) {
    const Row i = first + static_cast<Row>(q);
    const Vec3 x = a.x[q] - rules.scene.domain.lower;
    for (auto* p : {&rows.p, &rows.p2}) {
      double* r = p->data() + 4L * i;
      r[0] = x.x;
      r[1] = x.y;
      r[2] = x.z;
      r[3] = a.r[q];
    }
    rows.id[i] = rows.next_id++;
    if (rules.has.materials) rows.material[i] = a.material[q];
    const bool fixed = a.fixed[q] != 0;
    if (rules.has.fixed) rows.fixed[i] = fixed ? 1 : 0;
    if (remembered) rows.in_file[i] = fixed ? 1 : 0;
    if (rules.has.groups) rows.group[i] = a.group[q];
    const double m = Body{a.r[q], rules.scene.materials[rules.has.materials ? rows.material[i] : 0].density}.mass();
    const Vec3 v = fixed ? a.v[q] : a.v[q] - half * clock.gravity;
    for (auto* column : {&rows.v, &rows.v2}) {
      double* r = column->data() + static_cast<long>(rules.stride) * i;
      r[0] = v.x;
      r[1] = v.y;
      r[2] = v.z;
      if (rules.has.rotation) {
        r[3] = 0;
        r[4] = a.r[q] * a.w[q].x;
        r[5] = a.r[q] * a.w[q].y;
        r[6] = a.r[q] * a.w[q].z;
      }
      r[rules.stride - 1] = fixed ? 0.0 : 1.0 / m;
    }
    while (body != a.bodies.end() && q >= static_cast<std::size_t>(body->first + body->count)) ++body;
    if (body != a.bodies.end() && q >= static_cast<std::size_t>(body->first)) continue;  // append_bodies
    if (energy != nullptr)  // at n; the row holds the velocity of half a step before
      *energy += 0.5 * m * norm2(a.v[q]) + 0.2 * m * a.r[q] * a.r[q] * norm2(a.w[q]) -
                 (fixed ? 0 : m * dot(gravity_along(rules, clock, false), a.x[q]));
  }
  rows.alive += static_cast<Row>(a.size());
  append_bodies(rules, clock, rows, first, a, energy);
}

}  // namespace talus
