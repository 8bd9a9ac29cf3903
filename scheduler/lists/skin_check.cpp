// See skin_check.hpp; why each policy is exact stands in scheduler/lists/README.md.
#include "scheduler/lists/skin_check.hpp"

#include <algorithm>
#include <vector>

#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

/// Squared length [m2] of the minimum image of d.
double image2(const Rules& rules, const Vec3& d) { return norm2(rules.scene.domain.box().nearest_of_any(d)); }

}  // namespace

RowSkins::RowSkins(const Rules& rules, const Rows& rows, const Lists& lists, const Chunk& c)
    : rules_(rules),
      rows_(rows),
      lists_(lists),
      rule_(lists.skin),
      query_{rows, lists, c},
      acceleration_(lists.skin.acceleration_on && rows.velocity_at_old_step),
      inverse_dt_(1.0 / rules.scene.dt) {}

double RowSkins::operator()(Row i) {
  const double *x = rows_.p.data() + 4L * i, *v = rows_.v.data() + static_cast<long>(rules_.stride) * i;
  const double speed2 = (v[0] * v[0] + v[1] * v[1]) + v[2] * v[2];
  if (!(x[0] < k_far) || !(x[1] < k_far) || !(x[2] < k_far) || !(speed2 < 1e200)) return -1;
  double a = 0;
  if (acceleration_) {
    const double* u = rows_.v2.data() + static_cast<long>(rules_.stride) * i;
    const double d[3] = {v[0] - u[0], v[1] - u[1], v[2] - u[2]};
    a = __builtin_sqrt((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]) * inverse_dt_;
  }
  const auto speed = rule_.policy->speed;
  return rule_(x[3], speed != nullptr ? speed(query_, i, v, speed2) : __builtin_sqrt(speed2), a);
}

void set_reference(const Rules& rules, const Rows& rows, Lists& lists, Row i, double skin) {
  const double stored = rules.hooks.skin * skin;
  const double* x = rows.p.data() + 4L * i;
  double* ref = lists.x0.data() + 4L * i;
  for (int k = 0; k < 3; ++k) ref[k] = x[k];
  ref[3] = stored * stored;
}

void note_displacements(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                        Lists& lists, Team& team) {
  if (const auto note = lists.skin.policy->note) note(rules, clock, rows, contacts, lists, team);
}

void prepare_skins(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts, Lists& lists,
                   Team& team) {
  note_displacements(rules, clock, rows, contacts, lists, team);
  lists.frame = {};
  lists.frame.built = clock.step;
  lists.frame.rows = rows.n;
  if (const auto prepare = lists.skin.policy->prepare) prepare(rules, rows, contacts, lists, team);
}

double distance2(const Rules& rules, const double* x, const double* y) {
  return image2(rules, {x[0] - y[0], x[1] - y[1], x[2] - y[2]});
}

WallSet::Wraps wraps_of(const Rules& rules, const double* x, const double* y) {
  const Box box = rules.scene.domain.box();
  return {box.wraps(0, x[0] - y[0]), box.wraps(1, x[1] - y[1]), box.wraps(2, x[2] - y[2])};
}

double used2(const Rules& rules, const Clock& clock, const Rows& rows, const Lists& lists, Row i) {
  const double *x = rows.p.data() + 4L * i, *ref = lists.x0.data() + 4L * i;
  if (!lists.skin.drifts()) return distance2(rules, x, ref);
  const double t = static_cast<double>(clock.step - lists.frame.built) * rules.scene.dt;
  return image2(rules, Vec3{x[0] - ref[0], x[1] - ref[1], x[2] - ref[2]} - t * lists.drift_of(i));
}

double drift_reach(const Lists& lists, Row i) {
  if (!lists.skin.drifts()) return 0;
  const double speed = norm(lists.drift_of(i));
  return speed > 0 ? speed * lists.frame.life : 0;
}

void travel_chunk(const Rules& rules, const Rows& rows, const Lists& lists, Chunk& c) {
  const Policy::Check check = lists.skin.policy->check;
  c.result.travel[0] = c.result.travel[1] = 0;
  c.result.expired = 0;
  if (check == Policy::Check::none) return;
  const double* ref = check == Policy::Check::largest_of_step ? rows.p.data() : lists.x0.data();
  double first = 0, second = 0;
  bool left = false;
  for (Row i = c.lo; i < c.hi; ++i) {
    const double* x = rows.p2.data() + 4L * i;
    if (x[0] >= k_far) continue;  // removed
    const double d2 = distance2(rules, x, ref + 4L * i);
    left = left || !(d2 < 1e200);  // not a number: as the kernel's check has it
    second = fmax2(second, fmin2(first, d2));
    first = fmax2(first, d2);
  }
  c.result.travel[0] = __builtin_sqrt(first);
  c.result.travel[1] = __builtin_sqrt(second);
  c.result.expired = left ? 1 : 0;
}

void note_travel(const Contacts& contacts, Lists& lists) {
  if (lists.skin.policy->check != Policy::Check::largest_of_step) return;
  double largest = 0;
  for (const auto& c : contacts.chunks) largest = fmax2(largest, c->result.travel[0]);
  lists.frame.travelled += largest;
}

bool lists_expired(const Rules& rules, const Clock& clock, const Contacts& contacts, const Lists& lists,
                   const WallSet& walls) {
  const Policy& policy = *lists.skin.policy;
  if (policy.by_step != nullptr) return policy.by_step(rules, clock);
  if (rules.has.moving_walls && walls.expired()) return true;
  const double fault = rules.hooks.skin;
  if (static_cast<double>(clock.step - lists.frame.built) * rules.scene.dt > fault * lists.frame.life) return true;
  if (lists.any_expired.load(std::memory_order_relaxed)) return true;
  if (policy.used_up == nullptr) return false;
  double first = 0, second = 0;
  for (const auto& c : contacts.chunks) {
    second = fmax2(second, fmax2(c->result.travel[1], fmin2(first, c->result.travel[0])));
    first = fmax2(first, c->result.travel[0]);
  }
  return policy.used_up(lists, first, second, fault * lists.skin.uniform);
}

}  // namespace talus
