// Part "laser": beams from above that heat the grains they meet. At the end of each heat step, before heat's own:
//   rays of a fixed square around the axis, each with its share of the power, run down to the first grain;
//   that grain takes absorptivity times it, the rest is lost, and so is what passes all grains.
// The axis stands where it is in the middle of the heat step, or of the part of it in which the beam is on. Invariants:
// what is emitted is absorbed, reflected or passed; of two grains at equal height the one of the lower row takes the
// ray (I3).
#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "scheduler/parts/doors.hpp"

namespace talus {
namespace {

constexpr double k_half_width = 2;  // of the square of rays / radius of the beam

/// Where the axis is.
struct Spot {
  double x = 0, y = 0;
};

double leg(const Laser& l, std::size_t k) {
  const double dx = l.x[k + 1] - l.x[k], dy = l.y[k + 1] - l.y[k];
  return __builtin_sqrt(dx * dx + dy * dy);
}

/// When it goes out.
double end_of(const Laser& l) {
  if (l.x.size() == 1) return l.stop;
  double way = 0;
  for (std::size_t k = 0; k + 1 < l.x.size(); ++k) way = way + leg(l, k);
  return fmin2(l.stop, l.start + way / l.speed);
}

/// At a time at which it is on.
Spot spot_at(const Laser& l, double t) {
  double way = l.speed * (t - l.start);
  for (std::size_t k = 0; k + 1 < l.x.size(); ++k) {
    const double length = leg(l, k);
    if (way < length) {
      const double s = way / length;
      return {l.x[k] + s * (l.x[k + 1] - l.x[k]), l.y[k] + s * (l.y[k + 1] - l.y[k])};
    }
    way = way - length;
  }
  return {l.x.back(), l.y.back()};
}

/// All of its way lies beside the domain, where no grain can be.
bool misses(const Laser& l, const Domain& d) {
  for (int k = 0; k < 2; ++k) {
    const auto [low, high] = std::minmax_element(k == 0 ? l.x.begin() : l.y.begin(), k == 0 ? l.x.end() : l.y.end());
    const double reach = k_half_width * l.radius;
    if (!d.periodic(k) && (*high + reach <= d.lower[k] || *low - reach >= d.upper[k])) return true;
  }
  return false;
}

/// The rays of a beam: where they are beside its axis, and their shares of the power.
struct Rays {
  explicit Rays(const Laser& l) : spacing(2 * k_half_width * l.radius / static_cast<double>(l.rays)) {
    double sum = 0;
    for (std::int64_t k = 0; k < l.rays; ++k) {
      const double u = (static_cast<double>(k) + 0.5) * spacing - k_half_width * l.radius;
      offset.push_back(u);
      share.push_back(det::exp(-2 * (u * u) / (l.radius * l.radius)));
      sum = sum + share.back();
    }
    for (double& s : share) s = s / sum;
  }
  double spacing;
  std::vector<double> offset, share;  ///< along one side [m], [-]
};

struct Totals {
  double emitted = 0, absorbed = 0, reflected = 0, passed = 0;  ///< [J]
};

class Lasers final : public Part, public LaserLight {
 public:
  explicit Lasers(const Rules& rules) : all_(rules.scene.heat.lasers), every_(rules.scene.heat.every) {
    for (const Laser& l : all_) rays_.emplace_back(l);
  }

  std::string name() const override { return "laser"; }
  double heat(Row i) const override { return heat_[static_cast<std::size_t>(i)]; }
  double absorbed() const override { return totals_.absorbed; }

  void add_columns(Columns& columns) override {
    ColumnInfo i;
    i.name = "laser heat";
    i.unit = "W";
    i.why = "laser";
    i.moves = false;
    columns.add(i, heat_);
  }

  std::vector<PartNode> nodes() override {
    return {{"laser_step",
             PartNode::When::step,
             {{"p"}},
             {{"laser heat"}},
             every_,
             [this](const PartView& w, const Chunk&) { step(w); }}};
  }

  void take_back() override {
    if (clock_ == nullptr || clock_->step - 1 != last_step_) return;
    totals_ = before_;
    last_step_ = -1;
  }

  std::vector<PartValue> values(const PartView&) const override {
    return {{"laser.power", "W", power_},
            {"laser.emitted", "J", totals_.emitted},
            {"laser.absorbed", "J", totals_.absorbed},
            {"laser.reflected", "J", totals_.reflected},
            {"laser.passed", "J", totals_.passed}};
  }

  std::string idle(const Rules& rules) const override {
    const double end = static_cast<double>(rules.scene.steps) * rules.scene.dt;
    for (const Laser& l : all_)
      if (l.start >= end)
        return fmt::format("has a beam that is switched on at {:.6g} s, and the run ends at {:.6g} s", l.start, end);
      else if (misses(l, rules.scene.domain))
        return fmt::format("has a beam at x = {:.6g} m, y = {:.6g} m, which lies beside the domain", l.x[0], l.y[0]);
    return {};
  }

  std::vector<std::string> advice(const PartView& w) const override {
    std::vector<std::string> lines;
    for (std::size_t k = 0; k < all_.size(); ++k) {
      const Laser& l = all_[k];
      double way = 0;
      for (std::size_t q = 0; q + 1 < l.x.size(); ++q) way += leg(l, q);
      const double end = end_of(l);
      lines.push_back(fmt::format("{}: on from {:.6g} s to {}, way {:.4g} m", k, l.start,
                                  end < k_never ? fmt::format("{:.6g} s", end) : "the end", way));
      if (w.rules.r_min < k_never && rays_[k].spacing > w.rules.r_min / 3)
        lines.push_back(fmt::format("{}: rays {:.2g} m apart are coarse for a grain of radius {:.2g} m: rays = {:.0f}",
                                    k, rays_[k].spacing, w.rules.r_min,
                                    __builtin_ceil(6 * k_half_width * l.radius / w.rules.r_min)));
    }
    return lines;
  }

  std::vector<std::uint8_t> save() const override {
    std::vector<std::uint8_t> bytes(sizeof totals_ + sizeof power_);
    std::memcpy(bytes.data(), &totals_, sizeof totals_);
    std::memcpy(bytes.data() + sizeof totals_, &power_, sizeof power_);
    return bytes;
  }
  void load(std::span<const std::uint8_t> bytes, const std::string& where) override {
    if (bytes.size() != sizeof totals_ + sizeof power_)
      throw Error(ErrorCode::io, "section 'part laser' has a wrong size", where);
    std::memcpy(&totals_, bytes.data(), sizeof totals_);
    std::memcpy(&power_, bytes.data() + sizeof totals_, sizeof power_);
  }

 private:
  void step(const PartView& w) {
    clock_ = &w.clock;
    last_step_ = w.clock.step;
    before_ = totals_;
    power_ = 0;
    std::fill(heat_.data(), heat_.data() + w.rows.n, 0.0);
    for (std::size_t k = 0; k < all_.size(); ++k) shine(w, all_[k], rays_[k]);
  }

  void shine(const PartView& w, const Laser& l, const Rays& rays) {
    const auto every = static_cast<double>(w.rules.scene.heat.every);
    const auto time = [&](double steps) { return (static_cast<double>(w.clock.step + 1) - steps) * w.rules.scene.dt; };
    const double begin = time(every), end = time(0), hair = 1e-9 * (end - begin), out = end_of(l);
    const double from = l.start <= begin + hair ? begin : l.start, to = out >= end - hair ? end : out;
    if (!(to - from > hair)) return;
    // a heat step in which it goes on or out counts for the part that it is on
    const bool whole = from == begin && to == end;
    const double t = whole ? time(0.5 * every) : 0.5 * (from + to);
    const Spot spot = spot_at(l, t);
    const double mean = l.power.mean(t, to - from), power = whole ? mean : mean * ((to - from) / (end - begin));
    if (!(power > 0)) return;
    find_first(w, l, rays, spot);
    double absorbed = 0, reflected = 0, passed = 0;
    const std::size_t n = rays.offset.size();
    for (std::size_t q = 0; q < first_.size(); ++q) {
      const double ray = power * (rays.share[q % n] * rays.share[q / n]);
      if (first_[q] < 0) {
        passed = passed + ray;
        continue;
      }
      double& into = heat_[static_cast<std::size_t>(first_[q])];
      into = into + l.absorptivity * ray;
      absorbed = absorbed + l.absorptivity * ray;
      reflected = reflected + (1 - l.absorptivity) * ray;
    }
    const double dt = every * w.rules.scene.dt;
    power_ = power_ + power;
    totals_.emitted = totals_.emitted + dt * power;
    totals_.absorbed = totals_.absorbed + dt * absorbed;
    totals_.passed = totals_.passed + dt * passed;
    totals_.reflected = totals_.reflected + dt * reflected;
  }

  /// The highest grain below each ray, of all images of the grains.
  void find_first(const PartView& w, const Laser& l, const Rays& rays, const Spot& spot) {
    first_.assign(rays.offset.size() * rays.offset.size(), -1);
    height_.assign(first_.size(), -k_never);
    const Domain& domain = w.rules.scene.domain;
    double axis_x = spot.x - domain.lower.x, axis_y = spot.y - domain.lower.y;
    if (domain.periodic(0)) axis_x = axis_x - w.rules.size.x * __builtin_floor(axis_x / w.rules.size.x);
    if (domain.periodic(1)) axis_y = axis_y - w.rules.size.y * __builtin_floor(axis_y / w.rules.size.y);
    const int images_x = domain.periodic(0) ? 1 : 0, images_y = domain.periodic(1) ? 1 : 0;
    for (Row i = 0; i < w.rows.n; ++i) {
      if (!w.rows.is_alive(i)) continue;
      const double* p = w.rows.p.data() + 4L * i;
      const double dx = p[0] - axis_x, dy = p[1] - axis_y, reach = k_half_width * l.radius + p[3];
      for (int y = -images_y; y <= images_y; ++y)
        for (int x = -images_x; x <= images_x; ++x) {
          const double at_x = dx + x * w.rules.size.x, at_y = dy + y * w.rules.size.y;
          if (__builtin_fabs(at_x) < reach && __builtin_fabs(at_y) < reach) cover(rays, i, at_x, at_y, p[2], p[3]);
        }
    }
  }

  /// A grain at (x, y) from the axis takes the rays that it is the highest on so far.
  void cover(const Rays& rays, Row i, double x, double y, double z, double r) {
    const std::size_t n = rays.offset.size();
    const auto begin = [&](double at) {
      const double k = (at - r - rays.offset.front()) / rays.spacing;
      return k > 0 ? std::min(n, static_cast<std::size_t>(k)) : std::size_t{0};
    };
    for (std::size_t b = begin(y); b < n && rays.offset[b] < y + r; ++b)
      for (std::size_t a = begin(x); a < n && rays.offset[a] < x + r; ++a) {
        const double dx = rays.offset[a] - x, dy = rays.offset[b] - y;
        const double under = r * r - (dx * dx + dy * dy);
        if (!(under > 0)) continue;
        const double top = z + __builtin_sqrt(under);
        if (!(top > height_[b * n + a])) continue;
        height_[b * n + a] = top;
        first_[b * n + a] = i;
      }
  }

  const std::vector<Laser>& all_;
  const std::int64_t every_;  ///< steps per heat step
  std::vector<Rays> rays_;
  Column<double> heat_;
  Totals totals_, before_;
  double power_ = 0;  ///< of the last heat step [W]
  std::int64_t last_step_ = -1;
  const Clock* clock_ = nullptr;
  std::vector<Row> first_;      ///< that each ray meets; -1: none
  std::vector<double> height_;  ///< at which it does [m]
};

}  // namespace

std::unique_ptr<Part> make_laser(const Rules& rules) {
  return rules.scene.heat.lasers.empty() ? nullptr : std::make_unique<Lasers>(rules);
}

}  // namespace talus
