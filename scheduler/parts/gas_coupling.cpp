// See gas_coupling.hpp.
#include "scheduler/parts/gas_coupling.hpp"

#include <algorithm>

#include "core/base/det_math.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/species.hpp"
#include "scheduler/team/pools.hpp"

namespace talus {

namespace {

Vec3 velocity(const PartView& w, Row i) {
  const double* v = velocity_of(w.rows, i).v;
  return {v[0], v[1], v[2]};
}

void add_force(double* to, Vec3 force) {
  to[0] = to[0] + force.x;
  to[1] = to[1] + force.y;
  to[2] = to[2] + force.z;
}

/// Of a body by its first row; where that lies off the centre, with the torque that moves the force there.
void push_bodies(const PartView& w, const Chunk& c, const Column<double>& force) {
  const auto stride = static_cast<long>(w.rows.stride);
  double* f = c.scratch->f.data();
  for (Row i = c.lo; i < c.hi; ++i, f += stride) {
    if (!w.rows.leads(i)) continue;
    const Vec3 q = row_of<GasForce>(force, i).at(velocity_of(w.rows, i).v);
    add_force(f, q);
    const std::int32_t b = w.rows.body_of(i);
    if (b < 0 || shape_of(w.rules, w.rows.bodies, b).spheres.size() == 1) continue;
    const Vec3 back = (-1 / w.rows.p[4L * i + 3]) *
                      cross(arm_of_first(w.rules, w.rows.bodies, b), q);  // lanes: over the sphere's radius
    add_force(f + 4, back);
  }
}

}  // namespace

void push_grains(const PartView& w, const Chunk& c, const Column<double>& force) {
  if (w.rows.bodies.in) return push_bodies(w, c, force);
  const auto stride = static_cast<long>(w.rows.stride);
  double* f = c.scratch->f.data();
  for (Row i = c.lo; i < c.hi; ++i, f += stride)
    add_force(f, row_of<GasForce>(force, i).at(w.rows.v.data() + stride * i));
}

void GasShares::find(const PartView& w, const gas::Grid& grid) {
  begin_.assign(1, 0);
  parts_.clear();
  std::vector<std::pair<int, double>> own;
  for (Row i = 0; i < w.rows.n; ++i) {
    if (w.rows.is_alive(i) && w.rows.leads(i)) {
      grains_.share(w.rules, w.rows, grid, i, own);
      parts_.insert(parts_.end(), own.begin(), own.end());
    }
    begin_.push_back(parts_.size());
  }
}

void GasShares::give(const PartView& w, gas::FromGrains& to) const {
  for (Row i = 0; i < w.rows.n; ++i) {
    if (!reaches(i)) continue;
    const GasGrain g = grains_.of(w.rows, i);
    each(i, [&](std::size_t c, double volume, double) {
      to.solid[c] += volume;
      to.specific[c] += volume / (g.shape->sphericity * g.diameter);
    });
  }
}

namespace {

/// A cell as the drag laws see it, and the drag per volume of grain that its law gives for the mean of its grains.
struct CellDrag {
  double porosity = 1, diameter = 0, per_volume = 0;
};

CellDrag cell_drag(const GasSettings& s, const gas::ToGrains& gas, std::size_t c, double solid, double specific,
                   double cell, Vec3 mean) {
  CellDrag d;
  d.porosity = fmax2(s.least_porosity, 1 - solid / cell);
  if (!(solid > 0) || d.porosity >= 1) return d;
  d.diameter = solid / specific;
  const double e = d.porosity, slip = norm(gas.velocity[c] - e * mean);
  d.per_volume = e * e * gas::bed_resistance(s.drag, e, d.diameter, gas.viscosity[c], gas.density[c], slip) / (1 - e);
  return d;
}

}  // namespace

void GasShares::weigh(const PartView& w, const GasSettings& s, const gas::Grid& grid, const gas::ToGrains& gas,
                      gas::FromGrains& to) {
  const std::size_t cells = to.solid.size();
  std::vector<Vec3> moment(cells);
  for (Row i = 0; i < w.rows.n; ++i)
    each(i, [&](std::size_t c, double volume, double) { moment[c] = moment[c] + volume * velocity(w, i); });
  std::vector<CellDrag> bed(cells);
  for (std::size_t c = 0; c < cells; ++c)
    if (to.solid[c] > 0)
      bed[c] = cell_drag(s, gas, c, to.solid[c], to.specific[c], grid.volume, (1 / to.solid[c]) * moment[c]);
  weight_.assign(parts_.size(), 1);
  std::vector<double> sum(cells);
  for (Row i = 0; i < w.rows.n; ++i) {
    if (!reaches(i)) continue;
    const GasGrain g = grains_.of(w.rows, i);
    const double d = g.diameter, whole = det::k_pi / 6 * (d * d * d);
    for (std::size_t k = begin_[static_cast<std::size_t>(i)]; k < begin_[static_cast<std::size_t>(i) + 1]; ++k) {
      const auto c = static_cast<std::size_t>(parts_[k].first);
      const CellDrag& b = bed[c];
      if (b.per_volume > 0) {
        const double slip = norm(gas.velocity[c] - b.porosity * velocity(w, i));
        const double own =
            gas::grain_drag(s.drag, b.porosity, d, b.diameter, gas.viscosity[c], gas.density[c], slip, *g.shape);
        weight_[k] = own / (whole * b.per_volume);
      }
      sum[c] += parts_[k].second * weight_[k];
      to.moment[c] = to.moment[c] + (parts_[k].second * weight_[k]) * velocity(w, i);
    }
  }
  for (std::size_t c = 0; c < cells; ++c)
    if (to.solid[c] > 0) to.drag_factor[c] = sum[c] / to.solid[c];
}

GasForce GasShares::force(const PartView& w, const gas::Grid& grid, const gas::FromGrains& from,
                          const gas::ToGrains& gas, Row i) const {
  GasForce f;
  Vec3 pull;  // drag times gas velocity
  for (std::size_t k = begin_[static_cast<std::size_t>(i)]; k < begin_[static_cast<std::size_t>(i) + 1]; ++k) {
    const auto c = static_cast<std::size_t>(parts_[k].first);
    const double volume = parts_[k].second, e = gas.porosity[c];
    const double drag = gas.drag[c] * (volume * weight_[k]) / (from.drag_factor[c] * from.solid[c]);
    f.drag += drag;
    pull = pull + (drag / e) * gas.velocity[c];
    // fuller than the least porosity allows: the pressure acts on as much as the gas takes for solid
    f.push = f.push - (volume * fmin2(1, (1 - e) * grid.volume / from.solid[c])) * gas.gradient[c];
  }
  if (f.drag > 0) f.gas = (1 / f.drag) * pull;
  return f;
}

GasAtGrain GasShares::around(const PartView& w, const GasSettings& s, const gas::ToGrains& gas, Row i) const {
  GasAtGrain a;
  const GasGrain g = grains_.of(w.rows, i);
  const double d = g.diameter, ball = det::k_pi * (d * d), area = ball / g.shape->sphericity, whole = d * ball / 6;
  const Vec3 v = velocity(w, i);
  each(i, [&](std::size_t c, double volume, double weight) {
    const double e = gas.porosity[c], slip = norm(gas.velocity[c] - e * v);
    const double re = gas.density[c] * slip * d / gas.viscosity[c];
    const double h = gas::nusselt(s.nusselt, e, re, gas.prandtl[c]) * gas.conductivity[c] / d;
    a.conductance += volume / whole * area * h;
    a.film += weight * h;
    a.slip += weight * slip;
  });
  return a;
}

/// A step of implicit Euler for what is taken alone: y' = -(sum of uptakes / mass) y.
void GasMatter::offer(Row rows, const std::vector<GasUptake>& uptake) {
  std::vector<double> all(static_cast<std::size_t>(gas_.grid().cells()), 0.0);
  for (Row i = 0; i < rows; ++i)
    if (const double u = uptake[static_cast<std::size_t>(i)].oxidant; u > 0)
      shares_.each(i, [&](std::size_t c, double, double weight) { all[c] += weight * u; });
  kept_.resize(all.size());
  for (std::size_t c = 0; c < all.size(); ++c)
    for (std::size_t k = 0; k < 3; ++k)
      kept_[c][k] =
          gas_.fields().fractions[c][k_taken[k]] / (1 + duration_ * all[c] / gas::sum(gas_.content().mass[c]));
  offered_ = uptake;
  keep_steam(rows, all);
}

/// Likewise where steam condenses: y' = -(sum of uptakes (y - balanced)+ / mass), from the coldest surface on.
void GasMatter::keep_steam(Row rows, const std::vector<double>& oxidant) {
  struct Sink {
    std::size_t cell;
    double balanced, rate;
  };
  std::vector<Sink> sinks;
  for (Row i = 0; i < rows; ++i)
    if (const GasUptake& u = offered_[static_cast<std::size_t>(i)]; u.vapour > 0)
      shares_.each(i, [&](std::size_t c, double, double weight) {
        const double at = balanced(c, u.saturation), mass = gas::sum(gas_.content().mass[c]);
        if (at < 1) sinks.push_back({c, at, duration_ * weight * u.vapour / mass});
      });
  std::stable_sort(sinks.begin(), sinks.end(), [](const Sink& a, const Sink& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.balanced < b.balanced;
  });
  for (std::size_t k = 0; k < sinks.size();) {
    const std::size_t c = sinks[k].cell;
    double& kept = kept_[c][2];
    double sum = gas_.fields().fractions[c][k_taken[2]];
    double part = 1 + duration_ * oxidant[c] / gas::sum(gas_.content().mass[c]);
    for (; k < sinks.size() && sinks[k].cell == c; ++k) {
      if (!(sinks[k].balanced < kept)) continue;
      sum += sinks[k].rate * sinks[k].balanced;
      part += sinks[k].rate;
      kept = sum / part;
    }
  }
}

double GasMatter::steam_pressure(std::size_t c) const {
  return gas::steam_pressure(gas_.fields().fractions[c], gas_.fields().pressure[c]);
}

double GasMatter::balanced(std::size_t c, double saturation) const {
  const double there = steam_pressure(c);
  return there > saturation ? gas_.fields().fractions[c][k_taken[2]] * (saturation / there) : 2;
}

template <class Use>
void GasMatter::each_condensing(Row i, const Use& use) const {
  const auto at = static_cast<std::size_t>(i);
  if (!(at < offered_.size() && offered_[at].vapour > 0)) return;
  shares_.each(i, [&](std::size_t c, double, double weight) {
    const double balance = balanced(c, offered_[at].saturation), kept = kept_[c][2];
    if (kept > balance) use(c, duration_ * weight * offered_[at].vapour * (kept - balance), kept / balance);
  });
}

double GasMatter::saturable(Row i) const {
  double most = 0;
  shares_.each(i, [&](std::size_t c, double, double) { most = fmax2(most, steam_pressure(c)); });
  return most;
}

GasSteam GasMatter::steam(Row i) const {
  constexpr int steam = static_cast<int>(k_taken[2]);
  GasSteam s;
  double heat = 0;
  each_condensing(i, [&](std::size_t c, double mass, double above) {
    s.mass += mass;
    s.above = fmax2(s.above, above);
    heat += mass * (gas::enthalpy(steam, gas_.fields().temperature[c]) - gas::enthalpy(steam, 298.15));
  });
  if (s.mass > 0) s.enthalpy = heat / s.mass;
  return s;
}

/// From each cell its part of what would have condensed; it brings its enthalpy along.
void GasMatter::take_condensed(Row i, double condensed, double& enthalpy) {
  const double share = condensed / steam(i).mass;
  each_condensing(i, [&](std::size_t c, double mass, double) {
    GasFractions m{};
    m[k_taken[2]] = share * mass;
    const double h = gas::enthalpy(m, gas_.fields().temperature[c]);
    m[k_taken[2]] = -m[k_taken[2]];
    gas_.give(static_cast<int>(c), m, -h);
    enthalpy += h;
  });
}

/// What is taken comes from each cell as much as it keeps: no more than its share of what lasts; it leaves at the
/// temperature of the cell, so that what is released brings the rest.
void GasMatter::give(Row i, const GasFractions& released, const std::array<double, 3>& taken, double condensed,
                     double enthalpy) {
  if (condensed > 0) take_condensed(i, condensed, enthalpy);
  std::array<double, 3> seen{};
  shares_.each(i, [&](std::size_t c, double, double weight) {
    for (std::size_t k = 0; k < 3; ++k) seen[k] += weight * kept_[c][k];
  });
  const auto from = [&](std::size_t c, double weight, std::size_t k) {
    return taken[k] > 0 ? taken[k] * (weight * kept_[c][k] / seen[k]) : 0;
  };
  const auto carried = [&](std::size_t c, double weight) {
    GasFractions m{};
    for (std::size_t k = 0; k < 3; ++k) m[k_taken[k]] = from(c, weight, k);
    return gas::enthalpy(m, gas_.fields().temperature[c]);
  };
  double brought = enthalpy;
  shares_.each(i, [&](std::size_t c, double, double weight) { brought += carried(c, weight); });
  shares_.each(i, [&](std::size_t c, double, double weight) {
    GasFractions m{};
    for (std::size_t k = 0; k < m.size(); ++k) m[k] = weight * released[k];
    for (std::size_t k = 0; k < 3; ++k) m[k_taken[k]] -= from(c, weight, k);
    gas_.give(static_cast<int>(c), m, weight * brought - carried(c, weight));
  });
}

GridData grid_data(const gas::Grid& grid, const gas::ToGrains& fields) {
  GridData g;
  g.lower = grid.lower;
  g.spacing = grid.h;
  g.cells = grid.n;
  const auto vectors = [&](const char* name, const std::vector<Vec3>& from) {
    std::vector<double> v;
    for (const Vec3& x : from) v.insert(v.end(), {x.x, x.y, x.z});
    g.cell_data.push_back({name, 3, std::move(v)});
  };
  g.cell_data.push_back({"porosity", 1, fields.porosity});
  vectors("velocity", fields.velocity);
  g.cell_data.push_back({"pressure", 1, fields.pressure});
  vectors("pressure_gradient", fields.gradient);
  g.cell_data.push_back({"temperature", 1, fields.temperature});
  g.cell_data.push_back({"density", 1, fields.density});
  for (std::size_t k = 0; k < k_gas_species; ++k) {
    std::vector<double> y;
    for (const GasFractions& f : fields.fractions) y.push_back(f[k]);
    g.cell_data.push_back({std::string(gas::species(static_cast<int>(k)).name), 1, std::move(y)});
  }
  return g;
}

}  // namespace talus
