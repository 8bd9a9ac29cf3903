// What a checkpoint brings, looked at before lists are built on it. Its checksums tell that the bytes are those that
// were written, not that a run wrote them. Who calls it: Simulation. Invariant: a state that passes is one that steps
// can be made from; everything else is refused with the section and the row.
#include <fmt/format.h>

#include <cmath>
#include <tuple>

#include "core/base/error.hpp"
#include "scheduler/step/world.hpp"

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

const char* fault_of_position(const World& w, const double* x) {
  for (int k = 0; k < 3; ++k)
    if (!(x[k] >= 0 && x[k] <= w.size[k])) return "the particle is outside the domain";
  if (!(x[3] >= w.r_min * (1 - k_rounding) && x[3] <= w.r_max * (1 + k_rounding)))
    return "no source of the scene has such a radius";
  return nullptr;
}

void check_row(const World& w, Row i, const std::string& path) {
  const auto row = static_cast<std::size_t>(i);
  const double *x = w.p.data() + 4L * i, *v = w.v.data() + static_cast<long>(w.stride) * i;
  if (!all_finite(x, 4)) refuse("position", row, "a number is not finite", path);
  if (!all_finite(v, w.stride)) refuse("velocity", row, "a number is not finite", path);
  if (w.has.materials && w.material[i] >= w.scene.materials.size()) refuse("material", row, "no such material", path);
  if (w.has.groups && (w.group[i] < -1 || w.group[i] >= static_cast<int>(w.scene.groups.size())))
    refuse("group", row, "no such group", path);
  if (!w.is_alive(i)) {
    if (x[0] != k_gone || x[1] != k_gone || x[2] != k_gone || x[3] != 0)
      refuse("position", row, "the particle is neither there nor removed", path);
    return;
  }
  if (const char* what = fault_of_position(w, x)) refuse("position", row, what, path);
  if (w.id[i] < 0 || w.id[i] >= w.next_id) refuse("id", row, "the number was never given to a particle", path);
  const double inverse = v[w.stride - 1], product = inverse * w.mass(i);
  if (inverse != 0 && !(std::fabs(product - 1) < k_rounding))
    refuse("velocity", row, "the mass does not belong to the radius and the density", path);
}

}  // namespace

void check_restored_rows(const World& w, const std::string& path) {
  for (Row i = 0; i < w.n; ++i) check_row(w, i, path);
}

void check_restored_contacts(const World& w, const std::vector<ContactEntry>& contacts,
                             const std::vector<WallEntry>& walls, const std::string& path) {
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const ContactEntry& e = contacts[k];
    if (e.a < 0 || e.a >= e.b || e.b >= w.n) refuse("contacts", k, "it names a particle that does not exist", path);
    if (k > 0 && !(std::tie(contacts[k - 1].a, contacts[k - 1].b) < std::tie(e.a, e.b)))
      refuse("contacts", k, "the pairs do not ascend", path);
    if (!all_finite(e.h, w.has.history_columns)) refuse("contact_history", k, "a number is not finite", path);
  }
  for (std::size_t k = 0; k < walls.size(); ++k) {
    const WallEntry& s = walls[k];
    if (s.row < 0 || s.row >= w.n || s.contact.wall < 0 || s.contact.wall >= w.walls.size())
      refuse("wall_contacts", k, "it names a particle or a wall that does not exist", path);
    const Vec3 sum = 0.0 * (s.contact.normal + s.contact.velocity + s.contact.centre);
    if (!(norm2(sum) + 0.0 * s.contact.distance == 0) || !all_finite(s.h, w.has.law_columns) ||
        !all_finite(s.m, w.has.moment_columns))
      refuse("wall_contacts", k, "a number is not finite", path);
  }
}

}  // namespace talus
