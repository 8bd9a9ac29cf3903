// The end of a heat step: flows that reach without touching, gas, enclosure, then enthalpies and temperatures. In
// blocks of 1024 rows, on all threads; sums over rows are added up block by block (I3).
#include <fmt/format.h>

#include <algorithm>

#include "core/heat/contact.hpp"
#include "core/heat/radiation.hpp"
#include "scheduler/parts/heat.hpp"
#include "scheduler/parts/heat_near.hpp"
#include "scheduler/state/step_failure.hpp"

namespace talus {
namespace {

constexpr Row k_rows = 1024;       // per block
constexpr double k_hottest = 1e5;  // as keys may say [K]

/// A grain that another exchanges with over a distance.
struct Near {
  Row j;
  double gap;   ///< conductance of the gas between; of two fixed grains that of their contact too [W/K]
  double area;  ///< of radiation, not yet shaded [m2]
};

struct NearWall {
  int entry;         ///< of [[heat.wall]]
  double gap, area;  ///< as in Near
  double emissivity;
};

/// Neighbours of the rows of a block.
struct NearRows {
  std::vector<Near> all;
  std::vector<NearWall> walls;
  std::vector<std::int32_t> first, first_wall;
};

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
        laser_(part_as<LaserLight>(w.parts)) {
    blocks_ = (w.rows.n + k_rows - 1) / k_rows;
    sums_.resize(static_cast<std::size_t>(blocks_));
  }

  /// Returns the largest change of a temperature and the largest excess.
  std::pair<double, double> run() {
    for (BlockSums& b : sums_) b.wall.assign(s_.scene.walls.size(), 0.0);
    if (reaches() || w_.rules.has.fixed) find_near();
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
  /// Something acts without touching.
  bool reaches() const { return s_.scene.gap.conductivity > 0 || s_.scene.radiation.grains; }
  /// Of two fixed grains no list of the engine holds the contact: neither can move.
  bool fixed(Row i) const { return w_.rules.has.fixed && w_.rows.fixed[i] != 0; }

  // --- near grains ---------------------------------------------------------------------------------------------------

  /// Largest distance of centres at which grains of radii r and q exchange something [m].
  double reach(double r, double q) const {
    const double film = s_.scene.gap.conductivity > 0 ? 2 * s_.scene.gap.layer * heat::reduced(r, q) : 0;
    const double sight = s_.scene.radiation.grains ? s_.scene.radiation.range * (0.5 * (r + q)) : 0;
    return (r + q) + fmax2(film, sight);
  }

  void find_near() {
    const NearGrid grid(w_, reach(w_.rules.r_max, w_.rules.r_max), !reaches());
    near_.resize(static_cast<std::size_t>(blocks_));
    if (reaches()) shade_.assign(static_cast<std::size_t>(w_.rows.n), 1.0);
    entry_ = heat_wall_entries(s_, w_.walls);
    w_.blocks(blocks_, [&](int b) { find_near(grid, b); });
  }

  void find_near(const NearGrid& grid, int b) {
    NearRows& near = near_[static_cast<std::size_t>(b)];
    std::vector<Row> partners;
    std::vector<std::int32_t> elements;
    near.first.reserve(k_rows + 1);
    near.first_wall.reserve(k_rows + 1);
    const Box box = w_.rules.scene.domain.box();
    const GapHeat& gap = s_.scene.gap;
    for_rows(b, [&](Row i) {
      near.first.push_back(static_cast<std::int32_t>(near.all.size()));
      near.first_wall.push_back(static_cast<std::int32_t>(near.walls.size()));
      partners.clear();
      if (reaches() || fixed(i)) grid.partners(w_, i, partners);
      const double* a = w_.rows.p.data() + 4L * i;
      double seen = reaches() ? find_walls(a, near.walls, elements) : 0.0;
      for (const Row j : partners) {
        const double* o = w_.rows.p.data() + 4L * j;
        const double d = norm(box.nearest({a[0] - o[0], a[1] - o[1], a[2] - o[2]}));
        if (!(d < reach(a[3], o[3]))) continue;
        Near n{j, 0, 0};
        const double contact = fixed(i) && fixed(j) ? conductance_between(s_, w_, i, j, (a[3] + o[3]) - d) : 0.0;
        if (gap.conductivity > 0)
          n.gap = heat::gap_conductance(gap.conductivity, 2 * heat::reduced(a[3], o[3]), d - (a[3] + o[3]), gap.layer,
                                        gap.least_gap);
        if (s_.scene.radiation.grains && d < (a[3] + o[3]) + s_.scene.radiation.range * (0.5 * (a[3] + o[3])))
          n.area = heat::exchange_area(a[3], o[3], d);
        seen = seen + n.area;
        n.gap = n.gap + contact;
        if (n.gap > 0 || n.area > 0) near.all.push_back(n);
      }
      // more than the whole surface cannot be seen: those behind stand in the shade of those before
      if (seen > surface(i)) shade_[static_cast<std::size_t>(i)] = surface(i) / seen;
    });
    near.first.push_back(static_cast<std::int32_t>(near.all.size()));
    near.first_wall.push_back(static_cast<std::int32_t>(near.walls.size()));
  }

  /// Walls of given temperature near position row a. Returns the area of the grain that they are seen from.
  double find_walls(const double* a, std::vector<NearWall>& found, std::vector<std::int32_t>& elements) const {
    if (s_.scene.walls.empty()) return 0;
    const GapHeat& gap = s_.scene.gap;
    const bool radiates = s_.scene.radiation.grains;
    const double reach = heat_reach(s_.scene, a[3]);
    elements.clear();
    w_.walls.candidates({a[0], a[1], a[2]}, reach, elements);
    WallContact contact[WallSet::k_max_contacts];
    const int n = elements.empty() ? 0 : w_.walls.contacts({a[0], a[1], a[2]}, reach, elements, contact);
    double seen = 0;
    for (int k = 0; k < n; ++k) {
      const int e = entry_[static_cast<std::size_t>(contact[k].wall)];
      if (e < 0 || !s_.scene.walls[static_cast<std::size_t>(e)].temperature.given()) continue;
      const WallHeat& wall = s_.scene.walls[static_cast<std::size_t>(e)];
      NearWall w{e, 0, 0, s_.matter[static_cast<std::size_t>(w_.walls.material(contact[k].wall))].emissivity};
      if (gap.conductivity > 0)
        w.gap = heat::gap_conductance_to_plane(gap.conductivity, a[3], contact[k].distance - a[3], gap.layer,
                                               gap.least_gap);
      if (!wall.layer.empty() && w.gap > 0)
        w.gap = 1 / (1 / w.gap + wall.layer[0] / (wall.layer[1] * (det::k_pi * (a[3] * a[3]))));
      if (radiates && wall.layer.empty())
        w.area = 4 * det::k_pi * (a[3] * a[3]) * heat::share_of_plane(contact[k].distance, reach);
      seen = seen + w.area;
      found.push_back(w);
    }
    return seen;
  }

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
        const double area = n.area * fmin2(shade_[at], shade_[j]);
        seen = seen + area;
        g = g + heat::k_stefan * (area * heat::grey_factor(e, s_.emissivity(w_, inside_, n.j))) *
                    heat::radiant_slope(T, s_.temperature[j]);
      }
      add(at, g, s_.temperature[j]);
    }
    for (std::int32_t k = near.first_wall[q]; k < near.first_wall[q + 1]; ++k) {
      const NearWall& n = near.walls[static_cast<std::size_t>(k)];
      const auto wall = static_cast<std::size_t>(n.entry);
      const double other = s_.scene.walls[wall].temperature(s_.middle(w_)),
                   area = n.area > 0 ? n.area * shade_[at] : 0.0;
      seen = seen + area;
      const double g =
          n.gap + heat::k_stefan * (area * heat::grey_factor(e, n.emissivity)) * heat::radiant_slope(T, other);
      sum.wall[wall] = sum.wall[wall] + add(at, g, other);
    }
    if (!(seen > 0)) return 1;
    const double rest = 1 - seen / surface(i);
    return rest > 0 ? rest : 0.0;
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
               s_.scene.gas.temperature(s_.middle(w_)));
  }

  void exchange(int b) {
    BlockSums& sum = sums_[static_cast<std::size_t>(b)];
    const bool gas = gas_ != nullptr || s_.scene.gas.on;
    const RadiationHeat& radiation = s_.scene.radiation;
    const double enclosure = radiation.enclosure.given() ? radiation.enclosure(s_.middle(w_)) : 0;
    std::size_t q = 0;
    for_rows(b, [&](Row i) {
      const auto at = static_cast<std::size_t>(i);
      double open = 1;
      if (!near_.empty()) open = exchange_near(sum, near_[static_cast<std::size_t>(b)], q++, i);
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
    const double* now = s_.sizes.radii.data() + 3L * i;
    double* next = s_.sizes.next.data() + 3L * i;
    next[0] = now[1];
    next[1] = now[2] * (1 + matter(i).expansion * s_.next_temperature[static_cast<std::size_t>(i)]);
    next[2] = now[2];
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
  int blocks_ = 0;
  std::vector<BlockSums> sums_;
  std::vector<NearRows> near_;
  std::vector<int> entry_;     ///< of each wall
  std::vector<double> shade_;  ///< by row: share of what it would see that is in sight
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
