// See bodies.hpp.
#include "scheduler/state/bodies.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/error.hpp"
#include "kernels/views.hpp"
#include "scheduler/state/rows.hpp"

namespace talus {

namespace {

constexpr std::uint64_t k_seed = 200;  // of the terms in the state hash, one after another

void put(Column<double>& to, std::int32_t b, Vec3 v, double last) {
  double* at = to.data() + 4L * b;
  at[0] = v.x;
  at[1] = v.y;
  at[2] = v.z;
  at[3] = last;
}

Vec3 get(const Column<double>& from, std::int32_t b) {
  const double* at = from.data() + 4L * b;
  return {at[0], at[1], at[2]};
}

}  // namespace

Bodies::Bodies(const Rules& rules) : in(rules.has.bodies), resized(in && changes_sizes(rules.scene)) {
  const auto info = [&](const char* name, const char* unit, int width, std::uint64_t seed) {
    ColumnInfo i;
    i.name = name;
    i.unit = unit;
    i.in = in;
    i.why = in ? "a source makes bodies" : "no source makes bodies";
    i.width = width;
    i.saved = true;
    i.hash_seed = seed;
    return i;
  };
  columns.add(info("body_shape", "", 1, k_seed), shape);
  columns.add(info("body_size", "", 2, k_seed + 5), size, resized ? &size2 : nullptr);
  columns.add(info("body_position", "m", 4, k_seed + 1), x, &x2);
  columns.add(info("body_velocity", "m/s", 4, k_seed + 2), v, &v2);
  columns.add(info("body_turn", "-", 4, k_seed + 3), turn, &turn2);
  columns.add(info("body_spin", "kg m2/s", 4, k_seed + 4), spin, &spin2);
}

void Bodies::swap() noexcept {
  std::swap(x, x2);
  std::swap(v, v2);
  std::swap(turn, turn2);
  std::swap(spin, spin2);
  if (resized) std::swap(size, size2);
}

const BodyShape& shape_of(const Rules& rules, const Bodies& bodies, std::int32_t b) {
  return *rules.scene.shapes[static_cast<std::size_t>(bodies.shape[static_cast<std::size_t>(b)])].body;
}

double inertia_scale(const Bodies& bodies, std::int32_t b, bool second) {
  return bodies.mass(b, second) * (bodies.scale(b, second) * bodies.scale(b, second));
}

void set_body_capacity(Bodies& bodies, std::int32_t n) {
  bodies.columns.resize(static_cast<std::size_t>(n), std::min(bodies.n, n));
  bodies.first.resize(static_cast<std::size_t>(n));
  bodies.n = n;
}

BodyState state_of(const Bodies& bodies, std::int32_t b, bool second) {
  const double* q = (second ? bodies.turn2 : bodies.turn).data() + 4L * b;
  return {get(second ? bodies.x2 : bodies.x, b),
          get(second ? bodies.v2 : bodies.v, b),
          {q[0], q[1], q[2], q[3]},
          get(second ? bodies.spin2 : bodies.spin, b)};
}

Vec3 spin_of(const BodyShape& shape, double inverse_inertia, const shapes::Rotation& r, Vec3 l) {
  const Vec3 inverse = inverse_inertia * shape.rotor.inverse;
  return shapes::to_space(r, {l.x * inverse.x, l.y * inverse.y, l.z * inverse.z});
}

Vec3 angular_velocity(const Rules& rules, const Bodies& bodies, std::int32_t b) {
  const BodyState s = state_of(bodies, b);
  if (bodies.v[4L * b + 3] == 0) return s.spin;
  return spin_of(shape_of(rules, bodies, b), 1 / inertia_scale(bodies, b), shapes::rotation(s.turn), s.spin);
}

void set_angular_velocity(const Rules& rules, Bodies& bodies, std::int32_t b, Vec3 w) {
  if (bodies.v[4L * b + 3] != 0) {
    const Vec3 moments = inertia_scale(bodies, b) * shape_of(rules, bodies, b).moments;
    const Vec3 own = shapes::to_body(shapes::rotation(state_of(bodies, b).turn), w);
    w = {moments.x * own.x, moments.y * own.y, moments.z * own.z};
  }
  put(bodies.spin, b, w, 0);
}

Vec3 wrapped(const Rules& rules, Vec3 x) {
  for (int k = 0; k < 3; ++k) {
    if (!rules.scene.domain.periodic(k)) continue;
    if (x[k] < 0) x[k] = x[k] + rules.size[k];
    if (!(x[k] < rules.size[k])) x[k] = x[k] - rules.size[k];
  }
  return x;
}

void place_rows(const Rules& rules, Rows& rows, std::int32_t b) {
  Bodies& bodies = rows.bodies;
  const BodyShape& shape = shape_of(rules, bodies, b);
  const BodyState s = state_of(bodies, b);
  const shapes::Rotation r = shapes::rotation(s.turn);
  const Vec3 w = angular_velocity(rules, bodies, b);
  const double scale = bodies.scale(b), inverse_mass = bodies.v[4L * b + 3];
  Row i = bodies.first[static_cast<std::size_t>(b)];
  for (const shapes::SubSphere& part : shape.spheres) {
    const Vec3 off = shapes::to_space(r, scale * part.x), x = wrapped(rules, s.x + off), v = s.v + cross(w, off);
    const double radius = scale * part.r;
    double *p = rows.p.data() + 4L * i, *u = rows.v.data() + static_cast<long>(rows.stride) * i;
    for (int k = 0; k < 3; ++k) p[k] = x[k], u[k] = v[k];
    p[3] = radius;
    if (rules.has.rotation)
      for (int k = 0; k < 3; ++k) u[4 + k] = radius * w[k];
    u[rows.stride - 1] = inverse_mass;
    ++i;
  }
}

void append_bodies(const Rules& rules, const Clock& clock, Rows& rows, Row first, const NewParticles& a,
                   double* energy) {
  Bodies& bodies = rows.bodies;
  if (!bodies.in) return;
  std::int32_t b = bodies.n;
  set_body_capacity(bodies, b + static_cast<std::int32_t>(a.bodies.size()));
  const double half = clock.step == 0 ? 0.0 : 0.5 * rules.scene.dt;  // as for grains: v(n-1/2) = v - g dt/2
  for (const NewBody& from : a.bodies) {
    const BodyShape& shape = *rules.scene.shapes[static_cast<std::size_t>(from.shape)].body;
    const Row lead = first + from.first;
    bodies.first[static_cast<std::size_t>(b)] = lead;
    bodies.shape[static_cast<std::size_t>(b)] = from.shape;
    bodies.size[2L * b] = from.scale;
    bodies.size[2L * b + 1] = from.mass;
    put(bodies.x, b, from.x - rules.scene.domain.lower, from.scale * shape.bound);
    put(bodies.v, b, from.fixed ? from.v : from.v - half * clock.gravity, from.fixed ? 0 : 1 / from.mass);
    double* q = bodies.turn.data() + 4L * b;
    q[0] = from.turn.w, q[1] = from.turn.x, q[2] = from.turn.y, q[3] = from.turn.z;
    put(bodies.spin, b, {}, 0);
    if (norm2(from.w) > 0) set_angular_velocity(rules, bodies, b, from.w);
    for (Row i = lead; i < lead + from.count; ++i) rows.body[static_cast<std::size_t>(i)] = b;
    place_rows(rules, rows, b);
    std::copy_n(rows.p.data() + 4L * lead, 4L * from.count, rows.p2.data() + 4L * lead);
    const long stride = rows.stride;
    std::copy_n(rows.v.data() + stride * lead, stride * from.count, rows.v2.data() + stride * lead);
    if (energy != nullptr)
      *energy += 0.5 * from.mass * norm2(from.v) + rotation_energy(rules, bodies, b) -
                 (from.fixed ? 0 : from.mass * dot(gravity_along(rules, clock, false), from.x));
    ++b;
    ++rows.bodies_alive;
    rows.of_bodies += from.count;
  }
}

void sort_bodies(Rows& rows) {
  Bodies& bodies = rows.bodies;
  if (!bodies.in) return;
  std::vector<std::int32_t> order;
  for (Row i = 0; i < rows.n;) {
    const std::int32_t b = rows.body[static_cast<std::size_t>(i)];
    if (b < 0) {
      ++i;
      continue;
    }
    const auto now = static_cast<std::int32_t>(order.size());
    order.push_back(b);
    for (; i < rows.n && rows.body[static_cast<std::size_t>(i)] == b; ++i) rows.body[static_cast<std::size_t>(i)] = now;
  }
  for (const Columns::Entry& e : bodies.columns.all()) {
    Column<unsigned char> sorted(e.bytes * order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
      std::memcpy(sorted.data() + e.bytes * k, e.data() + e.bytes * static_cast<std::size_t>(order[k]), e.bytes);
    if (!sorted.empty()) std::memcpy(e.data(), sorted.data(), sorted.size());
  }
  set_body_capacity(bodies, static_cast<std::int32_t>(order.size()));
  find_rows(rows);
}

void copy_bodies(const Rows& from, Rows& to) {
  if (!to.bodies.in) return;
  set_body_capacity(to.bodies, from.bodies.n);
  to.bodies.columns.copy_saved(from.bodies.columns, static_cast<std::size_t>(from.bodies.n));
  find_rows(to);
}

void find_rows(Rows& rows) {
  Bodies& bodies = rows.bodies;
  if (!bodies.in) return;
  for (Row i = rows.n; i-- > 0;)
    if (const std::int32_t b = rows.body[static_cast<std::size_t>(i)]; b >= 0)
      bodies.first[static_cast<std::size_t>(b)] = i;
}

double rotation_energy(const Rules& rules, const Bodies& bodies, std::int32_t b, Vec3 l, bool second) {
  const Vec3 inverse = (1 / inertia_scale(bodies, b, second)) * shape_of(rules, bodies, b).rotor.inverse;
  return 0.5 * ((l.x * l.x * inverse.x + l.y * l.y * inverse.y) + l.z * l.z * inverse.z);
}

double rotation_energy(const Rules& rules, const Bodies& bodies, std::int32_t b) {
  const Vec3 spin = get(bodies.spin, b);
  if (bodies.v[4L * b + 3] != 0) return rotation_energy(rules, bodies, b, spin);
  const Vec3 w = shapes::to_body(shapes::rotation(state_of(bodies, b).turn), spin);
  const Vec3 moments = inertia_scale(bodies, b) * shape_of(rules, bodies, b).moments;
  return 0.5 * ((w.x * w.x * moments.x + w.y * w.y * moments.y) + w.z * w.z * moments.z);
}

Vec3 momentum_in_space(const Rules& rules, const Bodies& bodies, std::int32_t b, bool second) {
  const BodyState s = state_of(bodies, b, second);
  if (bodies.v[4L * b + 3] != 0) return shapes::to_space(shapes::rotation(s.turn), s.spin);
  const shapes::Rotation r = shapes::rotation(s.turn);
  const Vec3 w = shapes::to_body(r, s.spin),
             moments = inertia_scale(bodies, b, second) * shape_of(rules, bodies, b).moments;
  return shapes::to_space(r, {w.x * moments.x, w.y * moments.y, w.z * moments.z});
}

}  // namespace talus
