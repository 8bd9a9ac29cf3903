// What a checkpoint brings, looked at before lists are built on it. Its checksums tell that the bytes are those that
// were written, not that a run wrote them. Who calls it: Simulation. Invariant: a state that passes is one that steps
// can be made from; everything else is refused with the section and the row.
#include "scheduler/state/restored_state.hpp"

#include <fmt/format.h>

#include <cmath>
#include <tuple>

#include "core/base/error.hpp"

namespace talus {

namespace {

constexpr double k_rounding = 1e-12;

[[noreturn]] void refuse(const char* section, std::size_t row, const char* what, const std::string& path) {
  throw Error(ErrorCode::io, fmt::format("section '{}', entry {}: {}", section, row, what), path,
              "resume from another checkpoint of this scene");
}

bool all_finite(const double* x, int n) {
  double sum = 0;
  for (int k = 0; k < n; ++k) sum += 0.0 * x[k];
  return sum == 0;
}

const char* fault_of_position(const Rules& rules, const Rows& rows, Row i, const double* x) {
  const bool of_body = rows.body_of(i) >= 0;
  for (int k = 0; k < 3 && !of_body; ++k)  // a sphere of a body may stand out of an open side
    if (!(x[k] >= 0 && x[k] <= rules.size[k])) return "the particle is outside the domain";
  if (rows.resized) return x[3] > 0 ? nullptr : "the particle has no size";
  if (!(x[3] >= rules.r_min * (1 - k_rounding) && x[3] <= rules.r_max * (1 + k_rounding)))
    return "no source of the scene has such a radius";
  return nullptr;
}

void check_row(const Rules& rules, const Rows& rows, Row i, const std::string& path) {
  const auto row = static_cast<std::size_t>(i);
  const double *x = rows.p.data() + 4L * i, *v = rows.v.data() + static_cast<long>(rules.stride) * i;
  if (!all_finite(x, 4)) refuse("position", row, "a number is not finite", path);
  if (!all_finite(v, rules.stride)) refuse("velocity", row, "a number is not finite", path);
  if (rules.has.materials && rows.material[i] >= rules.scene.materials.size())
    refuse("material", row, "no such material", path);
  if (rules.has.groups && (rows.group[i] < -1 || rows.group[i] >= static_cast<int>(rules.scene.groups.size())))
    refuse("group", row, "no such group", path);
  if (!rows.is_alive(i)) {
    if (x[0] != k_gone || x[1] != k_gone || x[2] != k_gone || x[3] != 0)
      refuse("position", row, "the particle is neither there nor removed", path);
    return;
  }
  if (const char* what = fault_of_position(rules, rows, i, x)) refuse("position", row, what, path);
  if (rows.id[i] < 0 || rows.id[i] >= rows.next_id) refuse("id", row, "the number was never given to a particle", path);
  const std::int32_t body = rows.body_of(i);
  const double mass = body < 0 ? mass_of(rules, rows, i) : rows.bodies.mass(body);
  const double inverse = v[rules.stride - 1], product = inverse * mass;
  if (inverse != 0 && !rows.resized && !(std::fabs(product - 1) < k_rounding))
    refuse("velocity", row, "the mass does not belong to the radius and the density", path);
}

void check_body(const Rules& rules, const Bodies& bodies, std::int32_t b, const std::string& path) {
  const auto at = static_cast<std::size_t>(b);
  if (bodies.shape[at] < 0 || bodies.shape[at] >= static_cast<std::int32_t>(rules.scene.shapes.size()))
    refuse("body_shape", at, "no such shape", path);
  if (bodies.first[at] < 0) refuse("body_shape", at, "no particle belongs to the body", path);
  const double* q = bodies.turn.data() + 4L * b;
  if (!all_finite(q, 4) || !all_finite(bodies.x.data() + 4L * b, 4) || !all_finite(bodies.v.data() + 4L * b, 4) ||
      !all_finite(bodies.spin.data() + 4L * b, 4) || !all_finite(bodies.size.data() + 2L * b, 2))
    refuse("body_position", at, "a number of the body is not finite", path);
  if (!(std::fabs(((q[0] * q[0] + q[1] * q[1]) + q[2] * q[2]) + q[3] * q[3] - 1) < k_rounding))
    refuse("body_turn", at, "it is no rotation", path);
  if (!(bodies.scale(b) > 0) || !(bodies.mass(b) > 0)) refuse("body_size", at, "it is not positive", path);
  const double inverse = bodies.v[4L * b + 3];
  if (inverse != 0 && !(std::fabs(inverse * bodies.mass(b) - 1) < k_rounding))
    refuse("body_velocity", at, "the mass is not that of the body", path);
}

/// Before anything is asked of bodies: they lie whole, each as many rows as its shape has spheres.
void check_bodies(const Rules& rules, const Rows& rows, const std::string& path) {
  const Bodies& bodies = rows.bodies;
  for (std::int32_t b = 0; b < bodies.n; ++b) check_body(rules, bodies, b, path);
  for (Row i = 0; i < rows.n;) {
    const std::int32_t b = rows.body[static_cast<std::size_t>(i)];
    const Row first = i++;
    if (b < -1 || b >= bodies.n) refuse("body", static_cast<std::size_t>(first), "no such body", path);
    if (b < 0) continue;
    while (i < rows.n && rows.body[static_cast<std::size_t>(i)] == b && rows.is_alive(i) == rows.is_alive(first)) ++i;
    if (i - first != static_cast<Row>(shape_of(rules, bodies, b).spheres.size()) ||
        bodies.first[static_cast<std::size_t>(b)] != first)
      refuse("body", static_cast<std::size_t>(first), "the body has other rows than its shape has spheres", path);
  }
}

}  // namespace

void check_restored_rows(const Rules& rules, const Rows& rows, const std::string& path) {
  if (rows.bodies.in) check_bodies(rules, rows, path);
  for (Row i = 0; i < rows.n; ++i) check_row(rules, rows, i, path);
}

void check_restored_contacts(const Rules& rules, const Rows& rows, const WallSet& walls,
                             const std::vector<ContactEntry>& contacts, const std::vector<WallEntry>& entries,
                             const std::string& path) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactEntry& e = contacts[k];
    if (e.a < 0 || e.a >= e.b || e.b >= rows.n) refuse("contacts", k, "it names a particle that does not exist", path);
    if (k > 0 && !(std::tie(contacts[k - 1].a, contacts[k - 1].b) < std::tie(e.a, e.b)))
      refuse("contacts", k, "the pairs do not ascend", path);
    if (!all_finite(e.h, rules.has.history_columns)) refuse("contact_history", k, "a number is not finite", path);
  }
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const WallEntry& s = entries[k];
    if (s.row < 0 || s.row >= rows.n || s.contact.wall < 0 || s.contact.wall >= walls.size())
      refuse("wall_contacts", k, "it names a particle or a wall that does not exist", path);
    const Vec3 sum = 0.0 * (s.contact.normal + s.contact.velocity + s.contact.centre);
    if (!(norm2(sum) + 0.0 * s.contact.distance == 0) || !all_finite(s.h, rules.has.law_columns) ||
        !all_finite(s.m, rules.has.moment_columns))
      refuse("wall_contacts", k, "a number is not finite", path);
  }
}

}  // namespace talus
