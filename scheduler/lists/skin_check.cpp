// See skin_check.hpp; why each policy is exact stands in scheduler/lists/README.md.
#include "scheduler/lists/skin_check.hpp"

#include <algorithm>
#include <vector>

#include "scheduler/lists/velocity_profile.hpp"
#include "scheduler/step/world.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

constexpr double k_shrink = 0.9;  // of a skin that was not used up, per rebuild (Yade's number)
constexpr Row k_neighbours = 64;  // rows lie in Morton order: 64 of them fill a compact part of space

/// Squared length [m2] of the minimum image of d.
double image2(const World& w, const Vec3& d) { return norm2(w.scene.domain.box().nearest_of_any(d)); }

}  // namespace

double SkinSpeeds::operator()(Row i, const double* v, double speed2) {
  switch (w_.skin.policy) {
    case ListPolicy::global_velocity:
      return w_.frame.common_speed;
    case ListPolicy::mean_subtracted:
    case ListPolicy::velocity_profile:
      return norm(Vec3{v[0], v[1], v[2]} - w_.drift_of(i));
    case ListPolicy::neighbourhood: {
      if (i < block_end_) return block_;
      block_end_ = std::min<Row>(c_.hi, (i / k_neighbours + 1) * k_neighbours);
      double largest = 0;
      for (Row k = i; k < block_end_; ++k) {
        const double* u = w_.v.data() + static_cast<long>(w_.stride) * k;
        if (w_.is_alive(k)) largest = fmax2(largest, (u[0] * u[0] + u[1] * u[1]) + u[2] * u[2]);
      }
      return block_ = __builtin_sqrt(largest);
    }
    case ListPolicy::displacement_history: {
      const double length = w_.next_skin[static_cast<std::size_t>(i)];
      return length >= 0 ? length : w_.skin.k_dt * __builtin_sqrt(speed2);
    }
    default:
      return __builtin_sqrt(speed2);
  }
}

RowSkins::RowSkins(const World& w, const Chunk& c)
    : w_(w),
      rule_(w.skin),
      speed_(w, c),
      acceleration_(w.skin.acceleration_on && w.velocity_at_old_step),
      inverse_dt_(1.0 / w.scene.dt) {}

double RowSkins::operator()(Row i) {
  const double *x = w_.p.data() + 4L * i, *v = w_.v.data() + static_cast<long>(w_.stride) * i;
  const double speed2 = (v[0] * v[0] + v[1] * v[1]) + v[2] * v[2];
  if (!(x[0] < 1e100) || !(x[1] < 1e100) || !(x[2] < 1e100) || !(speed2 < 1e200)) return -1;
  double a = 0;
  if (acceleration_) {
    const double* u = w_.v2.data() + static_cast<long>(w_.stride) * i;
    const double d[3] = {v[0] - u[0], v[1] - u[1], v[2] - u[2]};
    a = __builtin_sqrt((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2]) * inverse_dt_;
  }
  return rule_(x[3], speed_(i, v, speed2), a);
}

void set_reference(World& w, Row i, double skin) {
  // tests only: the check believes in more than the list was built for
  const double stored = (w.options.seeded_fault == 3 ? 3 : 1) * skin;
  const double* x = w.p.data() + 4L * i;
  double* ref = w.x0.data() + 4L * i;
  for (int k = 0; k < 3; ++k) ref[k] = x[k];
  ref[3] = stored * stored;
}

void note_displacements(World& w) {
  if (w.skin.policy != ListPolicy::displacement_history || w.frame.noted) return;
  w.frame.noted = true;
  const double stored_scale = w.options.seeded_fault == 3 ? 3 : 1;
  const std::int64_t elapsed = std::max<std::int64_t>(1, w.step - w.frame.built);
  const double steps_ahead = w.skin.k_dt / (w.scene.dt * static_cast<double>(elapsed));
  parallel(w, static_cast<int>(w.chunks.size()), [&](int q) {
    const Chunk& c = *w.chunks[static_cast<std::size_t>(q)];
    for (Row i = c.lo; i < c.hi; ++i) {
      double& next = w.next_skin[static_cast<std::size_t>(i)];
      const double *x = w.p.data() + 4L * i, *ref = w.x0.data() + 4L * i;
      next = -1;  // no past
      if (i >= w.frame.rows || !(x[0] < 1e100) || !(ref[3] < 1e100)) continue;
      const double travel = __builtin_sqrt(distance2(w, x, ref));
      next = fmax2(k_shrink * (__builtin_sqrt(ref[3]) / stored_scale), travel * steps_ahead);
    }
  });
}

namespace {

void prepare_profile(World& w) {
  w.frame.life = w.skin.k_dt;
  const double fastest = fit_velocity_profile(w, w.frame.life);
  w.frame.rounding = 6e-8 * fastest * w.frame.life;
  if (w.has.walls && fastest > 0) w.frame.life = fmin2(w.frame.life, w.skin.drift_travel / fastest);
}

}  // namespace

void prepare_skins(World& w) {
  note_displacements(w);
  w.frame = {};
  w.frame.built = w.step;
  w.frame.rows = w.n;
  const bool mean = w.skin.policy == ListPolicy::mean_subtracted;
  if (w.skin.policy == ListPolicy::velocity_profile) return prepare_profile(w);
  if (!mean && w.skin.policy != ListPolicy::global_velocity) return;
  struct alignas(64) Part {
    Vec3 sum;
    double fastest = 0;
  };
  std::vector<Part> parts(w.chunks.size());
  parallel(w, static_cast<int>(w.chunks.size()), [&](int q) {
    const Chunk& c = *w.chunks[static_cast<std::size_t>(q)];
    Part& part = parts[static_cast<std::size_t>(q)];
    for (Row i = c.lo; i < c.hi; ++i) {
      if (!w.is_alive(i)) continue;
      const double* u = w.v.data() + static_cast<long>(w.stride) * i;
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
  w.frame.common_speed = __builtin_sqrt(all.fastest);
  if (!mean) return;
  const Vec3 u = (1.0 / fmax2(1, static_cast<double>(w.alive))) * all.sum;
  for (int k = 0; k < 3; ++k) w.frame.drift[k] = static_cast<float>(u[k]);
  if (w.has.walls && norm(u) > 0) w.frame.life = w.skin.drift_travel / norm(u);
}

double distance2(const World& w, const double* x, const double* y) {
  return image2(w, {x[0] - y[0], x[1] - y[1], x[2] - y[2]});
}

WallSet::Wraps wraps_of(const World& w, const double* x, const double* y) {
  const Box box = w.scene.domain.box();
  return {box.wraps(0, x[0] - y[0]), box.wraps(1, x[1] - y[1]), box.wraps(2, x[2] - y[2])};
}

double used2(const World& w, Row i) {
  const double *x = w.p.data() + 4L * i, *ref = w.x0.data() + 4L * i;
  if (!w.skin.drifts()) return distance2(w, x, ref);
  const double t = static_cast<double>(w.step - w.frame.built) * w.scene.dt;
  return image2(w, Vec3{x[0] - ref[0], x[1] - ref[1], x[2] - ref[2]} - t * w.drift_of(i));
}

double drift_reach(const World& w, Row i) {
  if (!w.skin.drifts()) return 0;
  const double speed = norm(w.drift_of(i));
  return speed > 0 ? speed * w.frame.life : 0;
}

void travel_chunk(World& w, Chunk& c) {
  const ListPolicy policy = w.skin.policy;
  c.travel[0] = c.travel[1] = 0;
  c.expired = 0;
  if (policy == ListPolicy::fixed) return;
  const double* ref = policy == ListPolicy::accumulated ? w.p.data() : w.x0.data();
  double first = 0, second = 0;
  bool left = false;
  for (Row i = c.lo; i < c.hi; ++i) {
    const double* x = w.p2.data() + 4L * i;
    if (x[0] >= 1e100) continue;  // removed
    const double d2 = distance2(w, x, ref + 4L * i);
    left = left || !(d2 < 1e200);  // not a number: as the kernel's check has it
    second = fmax2(second, fmin2(first, d2));
    first = fmax2(first, d2);
  }
  c.travel[0] = __builtin_sqrt(first);
  c.travel[1] = __builtin_sqrt(second);
  c.expired = left ? 1 : 0;
}

void note_travel(World& w) {
  if (w.skin.policy != ListPolicy::accumulated) return;
  double largest = 0;
  for (const auto& c : w.chunks) largest = fmax2(largest, c->travel[0]);
  w.frame.travelled += largest;
}

bool lists_expired(const World& w) {
  if (w.skin.policy == ListPolicy::always) return true;
  if (w.skin.policy == ListPolicy::fixed) return w.step % w.scene.list.interval == 0;
  if (w.has.moving_walls && w.walls.expired()) return true;
  const double fault = w.options.seeded_fault == 3 ? 3 : 1;  // tests only: believes in more than was listed
  if (static_cast<double>(w.step - w.frame.built) * w.scene.dt > fault * w.frame.life) return true;
  if (w.any_expired.load(std::memory_order_relaxed)) return true;
  if (!w.skin.own_check()) return false;
  double first = 0, second = 0;
  for (const auto& c : w.chunks) {
    second = fmax2(second, fmax2(c->travel[1], fmin2(first, c->travel[0])));
    first = fmax2(first, c->travel[0]);
  }
  const double skin = fault * w.skin.uniform;
  switch (w.skin.policy) {
    case ListPolicy::two_largest:
      return first + second > 2 * skin;
    case ListPolicy::accumulated:
      return w.frame.travelled > skin;
    default:
      return false;
  }
}

}  // namespace talus
