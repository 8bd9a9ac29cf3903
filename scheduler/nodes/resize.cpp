// See resize.hpp.
#include "scheduler/nodes/resize.hpp"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "scheduler/lists/skin_check.hpp"

namespace talus {
namespace {

/// Velocity and spin stay: momentum goes with the mass. The row holds r w.
void set_size(const Rules& rules, Rows& rows, Row i, double radius, double mass) {
  double *x = rows.p2.data() + 4L * i, *v = rows.v2.data() + static_cast<long>(rows.stride) * i;
  if (rules.has.rotation) {
    const double scale = radius / x[3];
    for (int k = 4; k < 7; ++k) v[k] = v[k] * scale;
  }
  x[3] = radius;
  v[rows.stride - 1] = 1 / mass;
}

/// What the chunk's rows take from their skins by growing.
class Growth {
 public:
  Growth(const PartView& w, const Rows& rows, Lists& lists) : w_(w), rows_(rows), lists_(lists) {}

  void add(Row i, double growth) {
    double* ref = lists_.x0.data() + 4L * i;
    const double left = __builtin_sqrt(ref[3]) - growth;
    ref[3] = left > 0 ? left * left : 0;
    if (lists_.skin.cuts()) {
      double& outer = lists_.outer[4L * i + 3];
      outer = fmax2(outer - growth, 0);
    }
    largest_ = fmax2(largest_, growth);
    if (lists_.skin.own_check())
      charged_ = fmax2(charged_, lists_.skin.uniform - left);
    else
      expired_ = expired_ || !(left > 0) || !(moved2(i, ref) <= ref[3]);
  }

  /// A row that has grown (or shrunk), and was moved by it.
  void add_moved(Row i, double growth, double way) {
    if (growth > 0)
      add(i, growth);
    else if (const double* ref = lists_.x0.data() + 4L * i; !lists_.skin.own_check())
      expired_ = expired_ || !(moved2(i, ref) <= ref[3]);
    moved_ = fmax2(moved_, way);
  }

  /// Own checks compare travels with the whole skin.
  void finish(Chunk& c) const {
    if (expired_) c.result.expired = 1;
    if ((largest_ == 0 && moved_ == 0) || !lists_.skin.own_check()) return;
    const double more = (lists_.skin.policy->check == Policy::Check::largest_of_step ? largest_ : charged_) + moved_;
    c.result.travel[0] += more;
    c.result.travel[1] += more;
  }

 private:
  double moved2(Row i, const double* ref) const {
    const double* x = rows_.p2.data() + 4L * i;
    if (!lists_.skin.drifts()) return distance2(w_.rules, x, ref);
    const double t = static_cast<double>(w_.clock.step + 1 - lists_.frame.built) * w_.rules.scene.dt;
    const Vec3 d = Vec3{x[0] - ref[0], x[1] - ref[1], x[2] - ref[2]} - t * lists_.drift_of(i);
    return norm2(w_.rules.scene.domain.box().nearest_of_any(d));
  }

  const PartView& w_;
  const Rows& rows_;
  Lists& lists_;
  bool expired_ = false;
  double largest_ = 0, charged_ = 0, moved_ = 0;
};

/// What a chunk's bodies are done to. The spin stays, so that the angular momentum goes with the inertia.
class BodySizes {
 public:
  BodySizes(const Rules& rules, Rows& rows, Growth& growth) : rules_(rules), rows_(rows), growth_(growth) {}

  void set(std::int32_t b, Row first, double scale, double mass) {
    Bodies& bodies = rows_.bodies;
    const BodyShape& shape = shape_of(rules_, bodies, b);
    const double before = bodies.scale(b), inertia = mass * (scale * scale) / inertia_scale(bodies, b);
    bodies.size2[2L * b] = scale;
    bodies.size2[2L * b + 1] = mass;
    bodies.x2[4L * b + 3] = scale * shape.bound;
    bodies.v2[4L * b + 3] = 1 / mass;
    for (int k = 0; k < 3; ++k) bodies.spin2[4L * b + k] = inertia * bodies.spin2[4L * b + k];
    const BodyState s = state_of(bodies, b, true);
    const shapes::Rotation r = shapes::rotation(s.turn);
    Row i = first;
    for (const shapes::SubSphere& part : shape.spheres) place(i++, part, s.x, r, before, scale, 1 / mass);
  }

 private:
  /// The row goes with its body's surface: its velocity, the chord of its way, counts that.
  void place(Row i, const shapes::SubSphere& part, Vec3 centre, const shapes::Rotation& r, double before, double scale,
             double inverse_mass) {
    double *x = rows_.p2.data() + 4L * i, *v = rows_.v2.data() + static_cast<long>(rows_.stride) * i;
    const Vec3 arm = shapes::to_space(r, scale * part.x), way = arm - shapes::to_space(r, before * part.x);
    const Vec3 at = wrapped(rules_, centre + arm);
    const double radius = scale * part.r, growth = radius - x[3], per_step = 1 / rules_.scene.dt;
    if (rules_.has.rotation) {
      const double ratio = radius / x[3];
      for (int k = 4; k < 7; ++k) v[k] = v[k] * ratio;
    }
    for (int k = 0; k < 3; ++k) x[k] = at[k], v[k] = v[k] + per_step * way[k];
    x[3] = radius;
    v[rows_.stride - 1] = inverse_mass;
    growth_.add_moved(i, growth, norm(way));
  }

  const Rules& rules_;
  Rows& rows_;
  Growth& growth_;
};

/// Of row i at the end of the step: of the row that leads a body, of this.
std::pair<double, double> size_of(const Rows& rows, Row i) {
  if (const std::int32_t b = rows.body_of(i); b >= 0) {
    const bool free = rows.leads(i) && rows.bodies.v2[4L * b + 3] > 0;
    return {rows.bodies.scale(b), free ? rows.bodies.mass(b) : 0};
  }
  const double inverse = rows.v2[static_cast<std::size_t>(static_cast<long>(rows.stride) * (i + 1) - 1)];
  return {rows.p2[4L * i + 3], inverse > 0 ? 1 / inverse : 0};
}

/// Second buffers hold what the bodies have, until a part says otherwise.
void keep_sizes(Rows& rows, const Chunk& c) {
  Bodies& bodies = rows.bodies;
  for (Row i = c.lo; i < c.hi; ++i)
    if (const std::int32_t b = rows.body_of(i); b >= 0 && rows.leads(i))
      bodies.size2[2L * b] = bodies.size[2L * b], bodies.size2[2L * b + 1] = bodies.size[2L * b + 1];
}

}  // namespace

void resize_chunk(const PartView& w, const Parts& parts, Rows& rows, Lists& lists, Chunk& c) {
  const auto count = static_cast<std::size_t>(c.hi - c.lo);
  std::vector<double> radius(count), mass(count);
  if (rows.bodies.in) keep_sizes(rows, c);
  for (Row i = c.lo; i < c.hi; ++i)
    std::tie(radius[static_cast<std::size_t>(i - c.lo)], mass[static_cast<std::size_t>(i - c.lo)]) = size_of(rows, i);
  const std::vector<double> before = radius, mass_before = mass;
  for (const auto& p : parts.all)
    if (p->resizes()) p->sizes(w, c, {c.lo, c.hi, radius.data(), mass.data()});
  Growth growth(w, rows, lists);
  BodySizes bodies(w.rules, rows, growth);
  const std::int32_t outside = c.result.out_count;  // in row order
  for (Row i = c.lo; i < c.hi; ++i) {
    const auto k = static_cast<std::size_t>(i - c.lo);
    if (!(rows.p2[4L * i] < k_far) || (rows.body_of(i) >= 0 && !rows.leads(i))) continue;
    if (!(radius[k] > 0)) {
      // a grain may leave the domain in the step in which it is used up: it is listed once
      if (!std::binary_search(c.result.out.begin(), c.result.out.begin() + outside, i))
        c.result.out[static_cast<std::size_t>(c.result.out_count++)] = i;
      continue;
    }
    if (mass_before[k] == 0 || (radius[k] == before[k] && mass[k] == mass_before[k])) continue;
    if (const std::int32_t b = rows.body_of(i); b >= 0) {
      bodies.set(b, i, radius[k], mass[k]);
      continue;
    }
    set_size(w.rules, rows, i, radius[k], mass[k]);
    if (radius[k] > before[k]) growth.add(i, radius[k] - before[k]);
  }
  growth.finish(c);
  std::sort(c.result.out.begin(), c.result.out.begin() + c.result.out_count);  // removed in row order (I3)
}

}  // namespace talus
