// See gas_coupling.hpp.
#include "scheduler/parts/gas_coupling.hpp"

#include "core/base/det_math.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/species.hpp"

namespace talus {

namespace {

double radius_of(const PartView& w, Row i) { return w.rows.p[4L * i + 3]; }

Vec3 velocity_of(const PartView& w, Row i) {
  const double* v = w.rows.v.data() + static_cast<long>(w.rows.stride) * i;
  return {v[0], v[1], v[2]};
}

Vec3 place_of(const PartView& w, Row i) {
  const double* p = w.rows.p.data() + 4L * i;
  return Vec3{p[0], p[1], p[2]} + w.rules.scene.domain.lower;
}

}  // namespace

void GasShares::find(const PartView& w, const gas::Grid& grid) {
  begin_.assign(1, 0);
  parts_.clear();
  std::vector<std::pair<int, double>> own;
  for (Row i = 0; i < w.rows.n; ++i) {
    if (w.rows.is_alive(i)) {
      gas::share(grid, place_of(w, i), radius_of(w, i), own);
      parts_.insert(parts_.end(), own.begin(), own.end());
    }
    begin_.push_back(parts_.size());
  }
}

void GasShares::give(const PartView& w, gas::FromGrains& to) const {
  for (Row i = 0; i < w.rows.n; ++i)
    each(i, [&](std::size_t c, double volume, double) {
      to.solid[c] += volume;
      to.specific[c] += volume / (2 * radius_of(w, i));
      to.moment[c] = to.moment[c] + volume * velocity_of(w, i);
    });
}

GasForce GasShares::force(const PartView& w, const GasSettings& s, const gas::ToGrains& gas, Row i) const {
  GasForce f;
  const double d = 2 * radius_of(w, i), whole = det::k_pi / 6 * (d * d * d);
  const Vec3 v = velocity_of(w, i);
  Vec3 pull;  // drag times gas velocity
  each(i, [&](std::size_t c, double volume, double) {
    const double e = gas.porosity[c];
    const Vec3 u = (1 / e) * gas.velocity[c];
    const double k = volume / whole *
                     gas::grain_drag(s.drag, e, d, gas.diameter[c], gas.viscosity[c], gas.density[c], e * norm(u - v));
    f.drag += k;
    pull = pull + k * u;
    f.push = f.push - volume * gas.gradient[c];
  });
  if (f.drag > 0) f.gas = (1 / f.drag) * pull;
  return f;
}

GasAtGrain GasShares::around(const PartView& w, const GasSettings& s, const gas::ToGrains& gas, Row i) const {
  GasAtGrain a;
  const double d = 2 * radius_of(w, i), area = det::k_pi * (d * d), whole = d * area / 6;
  const Vec3 v = velocity_of(w, i);
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
