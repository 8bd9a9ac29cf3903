// See tuner.hpp.
#include "scheduler/tuner.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "scheduler/parallel.hpp"
#include "scheduler/world.hpp"

namespace talus {

namespace {

constexpr double k_least_k = 1, k_most_k = 5000, k_least_floor = 1e-4, k_most_floor = 0.25;
constexpr double k_weight = 0.5;       // of one interval in the moving average of ln K and ln floor
constexpr double k_most_change = 2;    // of K or floor in one rebuild
constexpr std::int64_t k_sample = 16;  // every k_sample-th group of 8 slots is looked at

// Classes of skins, in diameters: two per octave of the square, from 2^-28 (6e-5 d) on.
constexpr int k_first_class = (127 - 28) * 2, k_classes = 2 * 30;

int class_of(double square) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(square));
  return std::clamp(static_cast<int>(bits >> 22) - k_first_class, 0, k_classes - 1);
}

}  // namespace

void RecentMedian::add(double x) noexcept {
  last_[count_ % k_size] = x;
  if (++count_ == 2 * k_size) count_ = k_size;
}

double RecentMedian::value() const noexcept {
  if (count_ == 0) return 0;
  const int n = std::min(count_, k_size);
  double sorted[k_size];
  std::copy(last_, last_ + n, sorted);
  std::sort(sorted, sorted + n);
  return sorted[n < 3 ? 0 : n / 2];
}

/// What an interval has used of the skins, by class of skin; lengths in diameters. Rows at the floor are apart: their
/// speeds say nothing about their skins.
struct SkinTuner::Use {
  double rows[k_classes] = {}, skin[k_classes] = {};       ///< number, sum of skins
  double travel2[k_classes] = {}, ratio2[k_classes] = {};  ///< largest; of (travel / skin)^2
  double floor_rows = 0, floor_travel2 = 0, floor_ratio2 = 0;
  double cap_ratio2 = 0;  ///< among rows whose skin is capped: a larger K does not help them

  void add(const Use& o) {
    for (int k = 0; k < k_classes; ++k) {
      rows[k] += o.rows[k];
      skin[k] += o.skin[k];
      travel2[k] = fmax2(travel2[k], o.travel2[k]);
      ratio2[k] = fmax2(ratio2[k], o.ratio2[k]);
    }
    floor_rows += o.floor_rows;
    floor_travel2 = fmax2(floor_travel2, o.floor_travel2);
    floor_ratio2 = fmax2(floor_ratio2, o.floor_ratio2);
    cap_ratio2 = fmax2(cap_ratio2, o.cap_ratio2);
  }
  double largest_ratio2() const {
    double q = floor_ratio2;
    for (const double r : ratio2) q = fmax2(q, r);
    return q;
  }
};

void SkinTuner::prepare(const World& w, double k, double floor) {
  on_ = w.scene.list.automatic && w.skin.has_k();
  has_floor_ = w.skin.floor_on;
  k_ = k;
  floor_ = floor;
  cut_ = w.step;
  spacing_ = static_cast<double>(w.scene.sort_every);
}

SkinTuner::Use SkinTuner::used_skins(World& w) const {
  std::vector<Use> parts(w.chunks.size());
  const Vec3 frame = frame_travel(w, w.step - w.frame.built);
  const double floor2 = has_floor_ ? floor_ * floor_ * (1 + 1e-9) : 0;
  parallel(w, static_cast<int>(w.chunks.size()), [&](int q) {
    const Chunk& c = *w.chunks[static_cast<std::size_t>(q)];
    Use& use = parts[static_cast<std::size_t>(q)];
    const Row last = std::min(c.hi, w.frame.rows);  // an insertion may have appended rows since
    for (Row i = c.lo; i < last; ++i) {
      const double *x = w.p.data() + 4L * i, *ref = w.x0.data() + 4L * i;
      if (!(x[0] < 1e100) || !(ref[3] > 0) || !(ref[3] < 1e100)) continue;
      const double size2 = 4 * x[3] * x[3], skin2 = ref[3] / size2, travelled2 = travel2(w, x, ref, frame) / size2;
      const double ratio2 = travelled2 / skin2;
      if (skin2 <= floor2) {
        use.floor_rows += 1;
        use.floor_travel2 = fmax2(use.floor_travel2, travelled2);
        use.floor_ratio2 = fmax2(use.floor_ratio2, ratio2);
        continue;
      }
      const int k = class_of(skin2);
      use.rows[k] += 1;
      use.skin[k] += __builtin_sqrt(skin2);
      use.travel2[k] = fmax2(use.travel2[k], travelled2);
      use.ratio2[k] = fmax2(use.ratio2[k], ratio2);
      if (skin2 > 0.0624) use.cap_ratio2 = fmax2(use.cap_ratio2, ratio2);  // half a radius is 1/4 of a diameter
    }
  });
  Use all;
  for (const Use& u : parts) all.add(u);
  return all;
}

void SkinTuner::interval_ends(World& w) {
  if (!on_ || ended_ == w.step) return;
  ended_ = w.step;
  const std::int64_t steps = w.step - w.frame.built;
  if (w.frame.rows == 0 || steps <= 0) return;
  const std::uint64_t now = w.times.ticks(Node::narrow_phase);
  // Rows and contacts have their part in the narrow phase, in slots: 0.45 and 0.2 (fit to a flowing and a resting bed
  // of 32k grains, skins 0.005 to 0.05 d: 2.3 and 2.5 ns per further slot).
  const double work = slots_ + 0.45 * static_cast<double>(w.alive) + 0.2 * contacts_;
  if (now > narrow_begin_ && slots_ > 0)  // less: the profile was restarted in between
    pair_.add(static_cast<double>(now - narrow_begin_) / (static_cast<double>(steps) * work));
  const Use use = used_skins(w);
  if (use.largest_ratio2() < 1) {  // an epoch, an insertion, a wall
    spacing_ = static_cast<double>(w.step - cut_);
    cut_ = w.step;
  }
  choose(w, use, static_cast<double>(steps));
}

/// `use` holds for an interval of `steps`.
void SkinTuner::choose(World& w, const Use& use, double steps) {
  // 1. The (K', floor') of least total skin among those that last as long: K' = K * factor covers the classes that
  // floor' does not. Floors are tried upwards from what the rows at the floor need.
  double present = use.floor_rows * floor_, least = 1e300, factor = 1, floor = floor_;
  for (const double s : use.skin) present += s;
  double tried = has_floor_ ? fmax2(__builtin_sqrt(use.floor_travel2), k_least_floor) : 0;
  for (int round = 0; round < 40; ++round, tried *= 1.2) {
    double f = 0, total = use.floor_rows * tried;
    for (int k = 0; k < k_classes; ++k)
      if (use.rows[k] > 0 && use.travel2[k] > tried * tried) f = fmax2(f, use.ratio2[k]);
    f = __builtin_sqrt(f);
    for (int k = 0; k < k_classes; ++k) total += fmax2(f * use.skin[k], tried * use.rows[k]);
    if (total < least) {
      least = total;
      factor = f;
      floor = tried;
    }
    if (!has_floor_ || tried > k_most_floor) break;
  }
  // 2. How long lists should last.
  const double rebuild = rebuild_.value(), pair = pair_.value();
  if (!(present > 0) || !(least > 0) || !(rebuild > 0) || !(pair > 0)) return;
  // a pair costs at its rebuild as much as in 3 steps: 8 ns
  const double slope = fmax2(gain_ * least / present, 1e-3 * slots_) * (1 + 3 / steps);
  double ideal = __builtin_sqrt(rebuild * steps / (pair * slope));
  ideal = fmin2(ideal, 1.2 * spacing_);
  if (use.cap_ratio2 > 0) ideal = fmin2(ideal, 1.05 * steps / __builtin_sqrt(use.cap_ratio2));
  ideal = fmax2(ideal, 1);
  // 3. A step towards it; an interval much shorter than wanted says little about a long one.
  const double weight = k_weight * fmin2(1, 2 * steps / ideal), scale = ideal / steps;
  const auto move = [&](double& value, double to, double low, double high) {
    const double ratio = std::clamp(to / value, 1 / k_most_change, k_most_change);
    value = std::clamp(value * std::pow(ratio, weight), low, high);
  };
  if (factor > 0) move(k_, factor * k_ * scale, k_least_k, k_most_k);
  if (has_floor_) move(floor_, floor * scale, k_least_floor, k_most_floor);
  w.skin.k_dt = k_ * w.scene.dt;
  w.skin.floor = floor_;
}

void SkinTuner::list_built(World& w, double ticks) {
  if (!on_) return;
  rebuild_.add(ticks);
  narrow_begin_ = w.times.ticks(Node::narrow_phase);
  // pairs whose gap lies between 3/4 and 1 of their skins: what a change of skins adds or takes
  std::int64_t near = 0;
  slots_ = contacts_ = 0;
  for (const auto& cp : w.chunks) {
    const Chunk& c = *cp;
    slots_ += static_cast<double>(c.end[2]);
    contacts_ += static_cast<double>(c.contact_end[2]);
    for (std::int64_t group = 8 * (c.index % k_sample); group < c.end[2]; group += 8 * k_sample)
      for (std::int64_t k = group; k < group + 8; ++k) {
        const Row i = c.pi[static_cast<std::size_t>(k)], j = c.pj[static_cast<std::size_t>(k)];
        if (i >= w.n || j >= w.n) continue;  // padding
        const double *x = w.p.data() + 4L * i, *y = w.p.data() + 4L * j;
        const double skins = __builtin_sqrt(w.x0[4L * i + 3]) + __builtin_sqrt(w.x0[4L * j + 3]);
        const double d = __builtin_sqrt(travel2(w, x, y, {}));
        near += d - (x[3] + w.skin.range(x[3]) + y[3] + w.skin.range(y[3])) > 0.75 * skins ? 1 : 0;
      }
  }
  gain_ = 4.0 * k_sample * static_cast<double>(near);
}

}  // namespace talus
