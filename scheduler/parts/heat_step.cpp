// The end of a heat step: flows that reach without touching, gas, enclosure, then enthalpies and temperatures. In
// blocks of 1024 rows, on all threads; sums over rows are added up block by block (I3).
#include <fmt/format.h>

#include <algorithm>

#include "core/heat/radiation.hpp"
#include "scheduler/parts/heat.hpp"
#include "scheduler/parts/heat_neighbours.hpp"
#include "scheduler/state/step_failure.hpp"

namespace talus {
namespace {

constexpr Row k_rows = k_heat_rows;
constexpr double k_hottest = 1e5;  // as keys may say [K]

/// What a block's rows have received, for the ledger [W]; friction and held [J].
struct BlockSums {
  double gas = 0, radiation = 0, friction = 0, held = 0, inside = 0;
  std::vector<double> source, wall;
  Row worst = -1;  ///< row whose step is farthest beyond its limit
  double excess = 1;
  double change = 0, nearest = 0;  ///< largest change of a temperature [K]; largest excess, in a bed too
};

class HeatStep {
 public:
  HeatStep(HeatState& s, const PartView& w)
      : s_(s),
        w_(w),
        dt_(s.dt(w)),
        gas_(part_as<GasCells>(w.parts)),
        inside_(part_as<GrainInside>(w.parts)),
        laser_(part_as<LaserLight>(w.parts)),
        near_(s, w) {
    blocks_ = (w.rows.n + k_rows - 1) / k_rows;
    sums_.resize(static_cast<std::size_t>(blocks_));
  }

  /// Returns the largest change of a temperature and the largest excess.
  std::pair<double, double> run() {
    for (BlockSums& b : sums_) b.wall.assign(s_.scene.walls.size(), 0.0);
    near_.find(blocks_);
    w_.blocks(blocks_, [&](int b) { exchange(b); });
    if (w_.rows.bodies.in) w_.blocks(blocks_, [&](int b) { gather(b); });
    refuse_overshoot();
    w_.blocks(blocks_, [&](int b) { advance(b); });
    add_up();
    double change = 0, nearest = 0;
    for (const BlockSums& b : sums_) change = fmax2(change, b.change), nearest = fmax2(nearest, b.nearest);
    return {change, nearest};
  }

 private:
  template <class F>
  void for_rows(int b, F fn) const {
    for (Row i = b * k_rows; i < std::min<Row>(w_.rows.n, (b + 1) * k_rows); ++i)
      if (w_.rows.is_alive(i)) fn(i);
  }
  const HeatMatter& matter(Row i) const { return s_.matter[static_cast<std::size_t>(s_.material(w_, i))]; }
  double surface(Row i) const { return s_.surface(w_, i); }
  bool has_shells(Row i) const { return inside_ != nullptr && s_.has_shells(w_, i); }

  // --- near grains and walls -----------------------------------------------------------------------------------------

  /// Of row i, number q of its block. Returns the share of its surface that sees no other grain.
  double exchange_near(BlockSums& sum, const NearRows& near, std::size_t q, Row i) {
    const auto at = static_cast<std::size_t>(i);
    const double T = s_.temperature[at], e = s_.emissivity(w_, inside_, i);
    double seen = 0;
    for (std::int32_t k = near.first[q]; k < near.first[q + 1]; ++k) {
      const Near& n = near.all[static_cast<std::size_t>(k)];
      const auto j = static_cast<std::size_t>(n.j);
      double g = n.gap;
      if (n.area > 0) {
        const double area = n.area * fmin2(near_.shade(i), near_.shade(n.j));
        seen = seen + area;
        g = g + heat::k_stefan * (area * heat::grey_factor(e, s_.emissivity(w_, inside_, n.j))) *
                    heat::radiant_slope(T, s_.temperature[j]);
      }
      if (n.j != i) add(at, g, s_.temperature[j]);
    }
    for (std::int32_t k = near.first_wall[q]; k < near.first_wall[q + 1]; ++k) {
      const NearWall& n = near.walls[static_cast<std::size_t>(k)];
      const auto wall = static_cast<std::size_t>(n.entry);
      const double other = s_.mean(s_.scene.walls[wall].temperature, w_),
                   area = n.area > 0 ? n.area * near_.shade(i) : 0.0;
      seen = seen + area;
      sum.wall[wall] = sum.wall[wall] + add(at, conductance_to(n, area, e, T, other), other);
    }
    if (!(seen > 0)) return 1;
    const double rest = 1 - seen / surface(i);
    return rest > 0 ? rest : 0.0;
  }

  /// To what is beyond a wall's layer, if it has one: gas, radiation and contact pass it together; without what the
  /// contact passes alone, which heat_walls has counted.
  static double conductance_to(const NearWall& n, double area, double e, double T, double other) {
    const double black = heat::k_stefan * (area * heat::grey_factor(e, n.emissivity));
    if (!(n.layer > 0)) return n.gap + black * heat::radiant_slope(T, other);
    const double beside = n.touch + n.gap, there = heat::layer_surface(n.layer, beside, black, T, other);
    return fmax2(0, heat::in_series(n.layer, beside + black * heat::radiant_slope(T, there)) -
                        heat::in_series(n.layer, n.touch));
  }

  // --- one grain alone -----------------------------------------------------------------------------------------------

  /// Returns the flow [W].
  double add(std::size_t i, double g, double other) {
    const double f = g * (other - s_.temperature[i]);
    s_.flow[i] = s_.flow[i] + f;
    s_.conductance[i] = s_.conductance[i] + g;
    return f;
  }

  /// Of gas, cells or given. Returns the flow [W].
  double add_gas(Row i) {
    const auto at = static_cast<std::size_t>(i);
    if (gas_ != nullptr) {
      s_.flow[at] = s_.flow[at] + gas_->heat(i);
      s_.conductance[at] = s_.conductance[at] + gas_->conductance(i);
      return gas_->heat(i);
    }
    const double film = given_gas(s_, w_, i).film * surface(i);
    return add(at, has_shells(i) ? thinned(film, inside_->surface(i).carried) : film,
               s_.mean(s_.scene.gas.temperature, w_));
  }

  void exchange(int b) {
    BlockSums& sum = sums_[static_cast<std::size_t>(b)];
    const bool gas = gas_ != nullptr || s_.scene.gas.on;
    const RadiationHeat& radiation = s_.scene.radiation;
    const double enclosure = radiation.enclosure.given() ? s_.mean(radiation.enclosure, w_) : 0;
    std::size_t q = 0;
    for_rows(b, [&](Row i) {
      const auto at = static_cast<std::size_t>(i);
      double open = 1;
      if (near_.any()) open = exchange_near(sum, near_.of(b), q++, i);
      const bool body = w_.rows.body_of(i) >= 0;
      if (gas && !(body && !w_.rows.leads(i))) sum.gas = sum.gas + add_gas(i);
      if (laser_ != nullptr) s_.flow[at] = s_.flow[at] + laser_->heat(i);
      if (enclosure > 0)
        sum.radiation = sum.radiation + add(at,
                                            heat::k_stefan * (open * surface(i) * s_.emissivity(w_, inside_, i)) *
                                                heat::radiant_slope(s_.temperature[at], enclosure),
                                            enclosure);
      if (!body) judge(sum, i);
    });
  }

  void judge(BlockSums& sum, Row i) const {
    if (s_.any_held && s_.held[static_cast<std::size_t>(i)] > 0) return;
    const double beyond = s_.excess(w_, inside_, i);
    if (!(beyond <= sum.excess)) sum.excess = beyond, sum.worst = i;
    if (s_.scene.error > 0) sum.nearest = fmax2(sum.nearest, fmax2(beyond, s_.excess_in_a_bed(w_, i)));
  }

  /// The first row of each body takes what all its rows receive.
  void gather(int b) {
    for_rows(b, [&](Row i) {
      if (w_.rows.body_of(i) < 0 || !w_.rows.leads(i)) return;
      const auto at = static_cast<std::size_t>(i);
      for (Row k = i + 1; k < end_of_grain(w_, i); ++k) {
        s_.flow[at] = s_.flow[at] + s_.flow[static_cast<std::size_t>(k)];
        s_.conductance[at] = s_.conductance[at] + s_.conductance[static_cast<std::size_t>(k)];
        if (!s_.scene.friction) continue;
        s_.loss[at] = s_.loss[at] + s_.loss[static_cast<std::size_t>(k)];
      }
      judge(sums_[static_cast<std::size_t>(b)], i);
    });
  }

  void refuse_overshoot() const {
    const BlockSums* worst = nullptr;
    for (const BlockSums& b : sums_)
      if (b.worst >= 0 && (worst == nullptr || !(b.excess <= worst->excess))) worst = &b;
    if (worst == nullptr) return;
    const double most = static_cast<double>(s_.pace.steps) / worst->excess;
    const bool chosen = s_.scene.error > 0 && most >= static_cast<double>(s_.scene.every);
    throw StepFailure(
        {w_.rows.id[worst->worst]},
        fmt::format("the heat step of {:.6g} s is too long for grain {}: it would overshoot what surrounds it", dt_,
                    w_.rows.id[worst->worst]),
        most >= 1
            ? fmt::format("heat.{} = {} at most{}", chosen ? "every_most" : "every", static_cast<std::int64_t>(most),
                          gas_ != nullptr || inside_ != nullptr ? ", with it that of conversion and gas" : "")
            : fmt::format("heat.every = 1 and time.step = {:.3g} at most", most * w_.rules.scene.dt));
  }

  // --- the new state -------------------------------------------------------------------------------------------------

  void advance(int b) {
    BlockSums& sum = sums_[static_cast<std::size_t>(b)];
    sum.source.assign(s_.source_flow.size(), 0.0);
    for_rows(b, [&](Row i) {
      if (!w_.rows.leads(i)) return;
      const auto at = static_cast<std::size_t>(i);
      s_.next_enthalpy[at] = s_.enthalpy[at];
      s_.next_temperature[at] = s_.temperature[at];
      if (s_.molten.any) s_.molten.next[at] = s_.molten.share[at];
      double heat = dt_ * s_.flow[at];
      if (s_.scene.friction) {
        heat = heat + s_.loss[at];
        sum.friction = sum.friction + s_.loss[at];
        s_.loss[at] = 0;
      }
      if (s_.any_held && s_.held[at] > 0) {
        double& source = sum.source[static_cast<std::size_t>(s_.held[at]) - 1];
        source = source - s_.flow[at];
        sum.held = sum.held - heat;
      } else if (has_shells(i)) {
        sum.inside = sum.inside - heat;
        if (s_.scene.friction) s_.flow[at] = heat / dt_;
      } else {
        s_.next_enthalpy[at] = s_.enthalpy[at] + heat;
        const double per_mass = s_.next_enthalpy[at] / mass_of(w_.rules, w_.rows, i);
        s_.next_temperature[at] = matter(i).enthalpy.temperature(per_mass, s_.temperature[at]);
        if (s_.molten.any) s_.molten.next[at] = matter(i).enthalpy.molten(per_mass);
      }
      sum.change = fmax2(sum.change, __builtin_fabs(s_.next_temperature[at] - s_.temperature[at]));
      if (s_.sizes.any) expand(i);
      share_with_body(s_, w_, i);
      if (!(s_.next_temperature[at] > 0 && s_.next_temperature[at] <= k_hottest)) sum.worst = i;
    });
  }

  void expand(Row i) {
    const double cold = s_.sizes.radii[2 * static_cast<std::size_t>(i) + 1];
    double* next = s_.sizes.next.data() + 2L * i;
    next[0] = cold * (1 + matter(i).expansion * s_.next_temperature[static_cast<std::size_t>(i)]);
    next[1] = cold;
  }

  [[noreturn]] void refuse_temperature(Row i) const {
    const double T = s_.next_temperature[static_cast<std::size_t>(i)];
    const ParticleId id = w_.rows.id[i];
    if (!(T > k_hottest))
      throw StepFailure({id}, fmt::format("grain {} has lost more heat than it had", id),
                        "a negative flux of a wall takes more than there is");
    throw StepFailure({id}, fmt::format("grain {} is heated to {:.4g} K, beyond all matter", id, T),
                      fmt::format("less flux, power or time; up to {:g} K", k_hottest));
  }

  void add_up() {
    std::fill(s_.source_flow.begin(), s_.source_flow.end(), 0.0);
    for (const BlockSums& b : sums_) {
      if (b.worst >= 0) refuse_temperature(b.worst);
      s_.totals.gas = s_.totals.gas + dt_ * b.gas;
      s_.totals.radiation = s_.totals.radiation + dt_ * b.radiation;
      s_.totals.friction = s_.totals.friction + b.friction;
      s_.totals.held = s_.totals.held + b.held;
      s_.totals.inside = s_.totals.inside + b.inside;
      for (std::size_t k = 0; k < b.wall.size(); ++k) s_.wall_flow[k] = s_.wall_flow[k] + b.wall[k];
      for (std::size_t k = 0; k < s_.source_flow.size(); ++k) s_.source_flow[k] = s_.source_flow[k] + b.source[k];
    }
    for (std::size_t e = 0; e < s_.wall_flow.size(); ++e) {
      const double heat = dt_ * s_.wall_flow[e];
      s_.wall_heat[e] = s_.wall_heat[e] + heat;
      s_.totals.walls = s_.totals.walls + heat;
    }
  }

  HeatState& s_;
  const PartView& w_;
  const double dt_;
  const GasCells* gas_;
  const GrainInside* inside_;
  const LaserLight* laser_;
  HeatNeighbours near_;
  int blocks_ = 0;
  std::vector<BlockSums> sums_;
};

}  // namespace

void heat_step(HeatState& s, const PartView& w) {
  s.clock = &w.clock;
  if (!s.ends(w)) return;
  s.totals_before = s.totals;
  s.pace.steps_before = s.pace.steps;
  s.pace.error_before = s.pace.error;
  heat_walls(s, w);
  const auto [change, excess] = HeatStep(s, w).run();
  std::swap(s.temperature, s.next_temperature);
  std::swap(s.enthalpy, s.next_enthalpy);
  std::swap(s.molten.share, s.molten.next);
  std::swap(s.sizes.radii, s.sizes.next);
  s.last_step = w.clock.step;
  if (s.scene.error > 0) choose_pace(s, w, change, excess);
}

}  // namespace talus
