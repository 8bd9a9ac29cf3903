// See resize.hpp.
#include "scheduler/nodes/resize.hpp"

#include <algorithm>
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

  /// Own checks compare travels with the whole skin.
  void finish(Chunk& c) const {
    if (expired_) c.result.expired = 1;
    if (largest_ == 0 || !lists_.skin.own_check()) return;
    const double more = lists_.skin.policy->check == Policy::Check::largest_of_step ? largest_ : charged_;
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
  double largest_ = 0, charged_ = 0;
};

}  // namespace

void resize_chunk(const PartView& w, const Parts& parts, Rows& rows, Lists& lists, Chunk& c) {
  const auto count = static_cast<std::size_t>(c.hi - c.lo);
  std::vector<double> radius(count), mass(count);
  const long stride = rows.stride;
  for (Row i = c.lo; i < c.hi; ++i) {
    const auto k = static_cast<std::size_t>(i - c.lo);
    const double inverse = rows.v2[static_cast<std::size_t>(stride * (i + 1) - 1)];
    radius[k] = rows.p2[4L * i + 3];
    mass[k] = inverse > 0 ? 1 / inverse : 0;
  }
  const std::vector<double> before = radius, mass_before = mass;
  for (const auto& p : parts.all)
    if (p->resizes()) p->sizes(w, c, {c.lo, c.hi, radius.data(), mass.data()});
  Growth growth(w, rows, lists);
  const std::int32_t outside = c.result.out_count;  // in row order
  for (Row i = c.lo; i < c.hi; ++i) {
    const auto k = static_cast<std::size_t>(i - c.lo);
    if (!(rows.p2[4L * i] < k_far) || mass_before[k] == 0) continue;
    if (!(radius[k] > 0)) {
      // a grain may leave the domain in the step in which it is used up: it is listed once
      if (!std::binary_search(c.result.out.begin(), c.result.out.begin() + outside, i))
        c.result.out[static_cast<std::size_t>(c.result.out_count++)] = i;
      continue;
    }
    if (radius[k] == before[k] && mass[k] == mass_before[k]) continue;
    set_size(w.rules, rows, i, radius[k], mass[k]);
    if (radius[k] > before[k]) growth.add(i, radius[k] - before[k]);
  }
  growth.finish(c);
  std::sort(c.result.out.begin(), c.result.out.begin() + c.result.out_count);  // removed in row order (I3)
}

}  // namespace talus
