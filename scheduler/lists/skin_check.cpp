// See skin_check.hpp; why each policy is exact stands in scheduler/lists/README.md.
#include "scheduler/lists/skin_check.hpp"

#include <algorithm>
#include <vector>

#include "scheduler/lists/velocity_profile.hpp"
#include "scheduler/state/faults.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

constexpr double k_shrink = 0.9;  // of a skin that was not used up, per rebuild (Yade's number)
constexpr Row k_neighbours = 64;  // rows lie in Morton order: 64 of them fill a compact part of space

/// Squared length [m2] of the minimum image of d.
double image2(const Rules& rules, const Vec3& d) { return norm2(rules.scene.domain.box().nearest_of_any(d)); }

}  // namespace

double SkinSpeeds::operator()(Row i, const double* v, double speed2) {
  switch (lists_.skin.policy) {
    case ListPolicy::global_velocity:
      return lists_.frame.common_speed;
    case ListPolicy::mean_subtracted:
    case ListPolicy::velocity_profile:
      return norm(Vec3{v[0], v[1], v[2]} - lists_.drift_of(i));
    case ListPolicy::neighbourhood: {
      if (i < block_end_) return block_;
      block_end_ = std::min<Row>(c_.hi, (i / k_neighbours + 1) * k_neighbours);
      double largest = 0;
      for (Row k = i; k < block_end_; ++k) {
        const double* u = rows_.v.data() + static_cast<long>(rows_.stride) * k;
        if (rows_.is_alive(k)) largest = fmax2(largest, (u[0] * u[0] + u[1] * u[1]) + u[2] * u[2]);
      }
      return block_ = __builtin_sqrt(largest);
    }
    case ListPolicy::displacement_history: {
      const double length = lists_.next_skin[static_cast<std::size_t>(i)];
      return length >= 0 ? length : lists_.skin.k_dt * __builtin_sqrt(speed2);
    }
    default:
      return __builtin_sqrt(speed2);
  }
}

RowSkins::RowSkins(const Rules& rules, const Rows& rows, const Lists& lists, const Chunk& c)
    : rules_(rules),
      rows_(rows),
      lists_(lists),
      rule_(lists.skin),
      speed_(rows, lists, c),
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
  return rule_(x[3], speed_(i, v, speed2), a);
}

void set_reference(const Rules& rules, const Rows& rows, Lists& lists, Row i, double skin) {
  const double stored = Faults(rules.options).skin() * skin;
  const double* x = rows.p.data() + 4L * i;
  double* ref = lists.x0.data() + 4L * i;
  for (int k = 0; k < 3; ++k) ref[k] = x[k];
  ref[3] = stored * stored;
}

void note_displacements(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                        Lists& lists, Team& team) {
  if (lists.skin.policy != ListPolicy::displacement_history || lists.frame.noted) return;
  lists.frame.noted = true;
  const double stored_scale = Faults(rules.options).skin();
  const std::int64_t elapsed = std::max<std::int64_t>(1, clock.step - lists.frame.built);
  const double steps_ahead = lists.skin.k_dt / (rules.scene.dt * static_cast<double>(elapsed));
  parallel(team, static_cast<int>(contacts.chunks.size()), [&](int q) {
    const Chunk& c = *contacts.chunks[static_cast<std::size_t>(q)];
    for (Row i = c.lo; i < c.hi; ++i) {
      double& next = lists.next_skin[static_cast<std::size_t>(i)];
      const double *x = rows.p.data() + 4L * i, *ref = lists.x0.data() + 4L * i;
      next = -1;  // no past
      if (i >= lists.frame.rows || !(x[0] < k_far) || !(ref[3] < k_far)) continue;
      const double travel = __builtin_sqrt(distance2(rules, x, ref));
      next = fmax2(k_shrink * (__builtin_sqrt(ref[3]) / stored_scale), travel * steps_ahead);
    }
  });
}

namespace {

void prepare_profile(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists, Team& team) {
  lists.frame.life = lists.skin.k_dt;
  const double fastest = fit_velocity_profile(rules, rows, contacts, lists, team, lists.frame.life);
  lists.frame.rounding = 6e-8 * fastest * lists.frame.life;
  if (rules.has.walls && fastest > 0) lists.frame.life = fmin2(lists.frame.life, lists.skin.drift_travel / fastest);
}

}  // namespace

void prepare_skins(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts, Lists& lists,
                   Team& team) {
  note_displacements(rules, clock, rows, contacts, lists, team);
  lists.frame = {};
  lists.frame.built = clock.step;
  lists.frame.rows = rows.n;
  const bool mean = lists.skin.policy == ListPolicy::mean_subtracted;
  if (lists.skin.policy == ListPolicy::velocity_profile) return prepare_profile(rules, rows, contacts, lists, team);
  if (!mean && lists.skin.policy != ListPolicy::global_velocity) return;
  struct alignas(64) Part {
    Vec3 sum;
    double fastest = 0;
  };
  std::vector<Part> parts(contacts.chunks.size());
  parallel(team, static_cast<int>(contacts.chunks.size()), [&](int q) {
    const Chunk& c = *contacts.chunks[static_cast<std::size_t>(q)];
    Part& part = parts[static_cast<std::size_t>(q)];
    for (Row i = c.lo; i < c.hi; ++i) {
      if (!rows.is_alive(i)) continue;
      const double* u = rows.v.data() + static_cast<long>(rules.stride) * i;
      const Vec3 v{u[0], u[1], u[2]};
      part.sum = part.sum + v;
      part.fastest = fmax2(part.fastest, norm2(v));
    }
  });
  Part all;
  for (const Part& p : parts) {
    all.sum = all.sum + p.sum;
    all.fastest = fmax2(all.fastest, p.fastest);
  }
  lists.frame.common_speed = __builtin_sqrt(all.fastest);
  if (!mean) return;
  const Vec3 u = (1.0 / fmax2(1, static_cast<double>(rows.alive))) * all.sum;
  for (int k = 0; k < 3; ++k) lists.frame.drift[k] = static_cast<float>(u[k]);
  if (rules.has.walls && norm(u) > 0) lists.frame.life = lists.skin.drift_travel / norm(u);
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
  const ListPolicy policy = lists.skin.policy;
  c.result.travel[0] = c.result.travel[1] = 0;
  c.result.expired = 0;
  if (policy == ListPolicy::fixed) return;
  const double* ref = policy == ListPolicy::accumulated ? rows.p.data() : lists.x0.data();
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
  if (lists.skin.policy != ListPolicy::accumulated) return;
  double largest = 0;
  for (const auto& c : contacts.chunks) largest = fmax2(largest, c->result.travel[0]);
  lists.frame.travelled += largest;
}

bool lists_expired(const Rules& rules, const Clock& clock, const Contacts& contacts, const Lists& lists,
                   const WallSet& walls) {
  if (lists.skin.policy == ListPolicy::always) return true;
  if (lists.skin.policy == ListPolicy::fixed) return clock.step % rules.scene.list.interval == 0;
  if (rules.has.moving_walls && walls.expired()) return true;
  const double fault = Faults(rules.options).skin();
  if (static_cast<double>(clock.step - lists.frame.built) * rules.scene.dt > fault * lists.frame.life) return true;
  if (lists.any_expired.load(std::memory_order_relaxed)) return true;
  if (!lists.skin.own_check()) return false;
  double first = 0, second = 0;
  for (const auto& c : contacts.chunks) {
    second = fmax2(second, fmax2(c->result.travel[1], fmin2(first, c->result.travel[0])));
    first = fmax2(first, c->result.travel[0]);
  }
  const double skin = fault * lists.skin.uniform;
  switch (lists.skin.policy) {
    case ListPolicy::two_largest:
      return first + second > 2 * skin;
    case ListPolicy::accumulated:
      return lists.frame.travelled > skin;
    default:
      return false;
  }
}

}  // namespace talus
