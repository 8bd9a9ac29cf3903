// See transport.hpp.
#include "core/gas/transport.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"
#include "core/gas/species.hpp"

namespace talus::gas {

namespace {

using Size = std::size_t;

constexpr int k_most_sweeps = 2000;
constexpr double k_sweep_change = 1e-15;
constexpr int k_most_rounds = 40;
constexpr double k_round_change = 1e-9;     // [K]
constexpr double k_least_fraction = 1e-12;  // below it what grains want is taken as from this fraction

/// What reaches a cell from a neighbour.
struct Link {
  int from;
  double weight;
};

/// The implicit upwind system: (own + rest) x = known + sum(weight x_from), per cell.
struct Upwind {
  std::vector<int> begin;  ///< [cells + 1] into links
  std::vector<Link> links;
  std::vector<double> out;    ///< mass that leaves the cell [kg]
  std::vector<double> in;     ///< mass that comes through sides [kg]
  std::vector<double> mixed;  ///< mass that neighbours exchange over a face by diffusion [kg]

  Upwind(const Grid& g, const Flow& flow, const ToGrains& state, double dt)
      : begin(Size(g.cells()) + 1), out(Size(g.cells())), in(out.size()) {
    for (const InnerFace& f : g.inner) {
      const Size a = Size(f.a), b = Size(f.b);
      const double rho_d = 0.5 * (state.porosity[a] * state.viscosity[a] + state.porosity[b] * state.viscosity[b]);
      mixed.push_back(dt * rho_d / k_prandtl * g.area[Size(f.axis)] / g.h[f.axis]);
    }
    std::vector<int> count(out.size());
    const auto each = [&](const auto& use) {
      for (Size k = 0; k < g.inner.size(); ++k) {
        const double m = dt * flow.inner_flux[k], d = mixed[k];
        use(g.inner[k].a, g.inner[k].b, m > 0 ? d + m : d);
        use(g.inner[k].b, g.inner[k].a, m < 0 ? d - m : d);
      }
    };
    each([&](int from, int to, double m) {
      out[Size(from)] += m;
      ++count[Size(to)];
    });
    for (Size c = 0; c < count.size(); ++c) begin[c + 1] = begin[c] + count[c];
    links.resize(Size(begin.back()));
    std::vector<int> at(begin.begin(), begin.end() - 1);
    each([&](int from, int to, double m) { links[Size(at[Size(to)]++)] = {from, m}; });
    for (Size k = 0; k < g.outer.size(); ++k) {
      const double m = dt * flow.outer_flux[k];
      (m > 0 ? out : in)[Size(g.outer[k].cell)] += m > 0 ? m : -m;
    }
  }
};

/// Sweeps along the flow until nothing changes: x[c] = (known[c] + sum over its links) / total[c].
void sweep(const Upwind& w, const std::vector<int>& order, const std::vector<double>& total,
           const std::vector<double>& known, double scale, std::vector<double>& x) {
  for (int q = 0; q < k_most_sweeps; ++q) {
    double change = 0;
    for (Size s = 0; s < order.size(); ++s) {
      const auto c = Size(order[q % 2 == 0 || q < 2 ? s : order.size() - 1 - s]);
      double top = known[c];
      for (int l = w.begin[c]; l < w.begin[c + 1]; ++l) top += w.links[Size(l)].weight * x[Size(w.links[Size(l)].from)];
      const double next = total[c] > 0 ? top / total[c] : x[c];
      change = fmax2(change, __builtin_fabs(next - x[c]));
      x[c] = next;
    }
    if (change <= k_sweep_change * scale) return;
  }
}

/// A step of all that the flow carries.
struct Step {
  const Grid& grid;
  const Flow& flow;
  const std::vector<Opening>& openings;
  const FromGrains& grains;
  double dt;
  const std::vector<int>& order;
  Upwind upwind;
  std::vector<double> before, weight;  ///< mass before the step; that and what comes = mass after it and what leaves

  Step(const Grid& g, const Flow& f, const std::vector<Opening>& o, const FromGrains& s, double step,
       const std::vector<int>& along, const Content& content, const ToGrains& state)
      : grid(g), flow(f), openings(o), grains(s), dt(step), order(along), upwind(g, f, state, step) {
    for (Size c = 0; c < content.mass.size(); ++c) {
      before.push_back(sum(content.mass[c]));
      double w = before[c] + upwind.in[c];
      for (int l = upwind.begin[c]; l < upwind.begin[c + 1]; ++l) w += upwind.links[Size(l)].weight;
      weight.push_back(fmax2(w + dt * sum(grains.source[c]), 0.1 * w));
    }
  }

  /// Adds what comes in through the sides with `of(opening)` per mass.
  template <class Of>
  void add_inflow(const Of& of, std::vector<double>& to) const {
    for (Size k = 0; k < grid.outer.size(); ++k)
      if (flow.outer_flux[k] < 0) to[Size(grid.outer[k].cell)] += -dt * flow.outer_flux[k] * of(openings[k]);
  }

  /// Moves x over the faces: what one cell loses another gains, to the bit.
  template <class Of, class To>
  void carry(const std::vector<double>& x, const Of& of, const To& to, double& in, double& out) const {
    for (Size k = 0; k < grid.inner.size(); ++k) {
      const InnerFace& f = grid.inner[k];
      const double m = dt * flow.inner_flux[k];
      const double q = m * x[Size(m > 0 ? f.a : f.b)] + upwind.mixed[k] * (x[Size(f.a)] - x[Size(f.b)]);
      to(Size(f.a)) -= q;
      to(Size(f.b)) += q;
    }
    for (Size k = 0; k < grid.outer.size(); ++k) {
      const double m = dt * flow.outer_flux[k];
      if (m == 0) continue;
      const auto c = Size(grid.outer[k].cell);
      const double q = m * (m > 0 ? x[c] : of(openings[k]));
      to(c) -= q;
      if (m > 0) out += q;
      if (m < 0) in -= q;
    }
  }

  /// One species. What grains want is taken in proportion to the fraction that is there: never more than there is.
  void species(Size k, Content& content, ToGrains& out, Passed& passed) const {
    const Size n = weight.size();
    std::vector<double> x(n), total = weight, known(n), sink(n);
    double scale = 1e-30;
    const auto of = [&](const Opening& o) { return o.fractions[k]; };
    for (Size c = 0; c < n; ++c) {
      known[c] = content.mass[c][k];
      x[c] = before[c] > 0 ? known[c] / before[c] : 0;
      const double s = dt * grains.source[c][k];
      if (s > 0) known[c] += s;
      if (s < 0) total[c] += sink[c] = -s / fmax2(x[c], k_least_fraction);
      scale = fmax2(scale, x[c]);
    }
    add_inflow(of, known);
    sweep(upwind, order, total, known, scale, x);
    carry(
        x, of, [&](Size c) -> double& { return content.mass[c][k]; }, passed.in[k], passed.out[k]);
    for (Size c = 0; c < n; ++c) {
      const double wanted = dt * grains.source[c][k], given = wanted < 0 ? -sink[c] * x[c] : wanted;
      out.taken[c][k] = wanted < 0 ? given / wanted : 1;
      content.mass[c][k] = fmax2(0, content.mass[c][k] + given);  // below it by the rounding of fluxes at most
      passed.grains[k] += given;
    }
  }

  /// Enthalpy per mass, with heat of grains in proportion to a temperature that is linear in it; a few
  /// rounds of that. Capacities are those of the fractions after the step.
  void energy(Vessel& vessel, Content& content, ToGrains& out, Passed& passed) const {
    const Size n = weight.size();
    std::vector<double> x(n), t = content.temperature, cp(n), h(n);
    std::vector<GasFractions> y(n);
    for (Size c = 0; c < n; ++c) {
      const double m = sum(content.mass[c]);
      for (Size k = 0; k < k_gas_species; ++k) y[c][k] = content.mass[c][k] / m;
    }
    double rise = 0;  // of the pressure; a round passes on less than R / cp of its error
    const auto of = [](const Opening& o) { return o.enthalpy; };
    for (int round = 0; round < k_most_rounds; ++round) {
      for (Size c = 0; c < n; ++c) cp[c] = heat_capacity(y[c], t[c]), h[c] = enthalpy(y[c], t[c]);
      std::vector<double> total = weight, known = content.enthalpy;
      double scale = 1e-30;
      if (vessel.sealed) rise = pressure_of(content, y, t, out) - vessel.pressure;
      for (Size c = 0; c < n; ++c) {
        known[c] += out.porosity[c] * grid.volume * rise;
        // to the grains goes g T(x), with T = t + (x - h) / cp
        const double g = dt * grains.conductance[c];
        known[c] += dt * (grains.enthalpy[c] + grains.heat[c]) - g * (t[c] - h[c] / cp[c]);
        total[c] += g / cp[c];
        x[c] = h[c];
        scale = fmax2(scale, cp[c] * t[c]);
      }
      add_inflow(of, known);
      sweep(upwind, order, total, known, scale, x);
      double change = 0;
      for (Size c = 0; c < n; ++c) {
        const double next = t[c] + (x[c] - h[c]) / cp[c];
        if (!(next > 0.5 * k_coldest && next < 2 * k_hottest)) fail(c, next);
        change = fmax2(change, __builtin_fabs(next - t[c]));
        t[c] = next;
      }
      if (change <= k_round_change) break;
    }
    for (Size c = 0; c < n; ++c) {
      const double work = out.porosity[c] * grid.volume * rise;
      content.enthalpy[c] += work;
      passed.pressure_work += work;
    }
    vessel.pressure += rise;
    finish_energy(x, t, of, content, out, passed);
  }

  /// Of all gas in its voids at these temperatures [Pa].
  double pressure_of(const Content& content, const std::vector<GasFractions>& y, const std::vector<double>& t,
                     const ToGrains& out) const {
    double whole = 0, room = 0;
    for (Size c = 0; c < t.size(); ++c) {
      whole += sum(content.mass[c]) * specific_gas_constant(y[c]) * t[c];
      room += out.porosity[c] * grid.volume;
    }
    return whole / room;
  }

  template <class Of>
  void finish_energy(const std::vector<double>& x, const std::vector<double>& t, const Of& of, Content& content,
                     ToGrains& out, Passed& passed) const {
    carry(
        x, of, [&](Size c) -> double& { return content.enthalpy[c]; }, passed.enthalpy_in, passed.enthalpy_out);
    for (Size c = 0; c < t.size(); ++c) {
      const double heat = dt * (grains.heat[c] - grains.conductance[c] * t[c]), brought = dt * grains.enthalpy[c];
      content.enthalpy[c] += heat + brought;
      passed.heat_grains += heat;
      passed.enthalpy_grains += brought;
      out.exchange_temperature[c] = t[c];
      content.temperature[c] = t[c];
    }
  }

  [[noreturn]] void fail(Size c, double t) const {
    const Vec3 x = grid.middle(static_cast<int>(c));
    throw Error(ErrorCode::physics,
                fmt::format("the gas at ({:.4g}, {:.4g}, {:.4g}) m would have {:.4g} K", x.x, x.y, x.z, t), "gas",
                "its properties are known from 200 to 3500 K; a smaller gas.every where sources are strong");
  }
};

}  // namespace

double sum(const GasFractions& y) noexcept {
  double s = 0;
  for (const double v : y) s += v;
  return s;
}

void transport(const Grid& grid, const Flow& flow, const std::vector<Opening>& openings, const FromGrains& grains,
               double dt, const std::vector<int>& order, Vessel& vessel, Content& content, ToGrains& out,
               Passed& passed) {
  const Step step(grid, flow, openings, grains, dt, order, content, out);
  for (Size k = 0; k < k_gas_species; ++k) step.species(k, content, out, passed);
  step.energy(vessel, content, out, passed);
}

}  // namespace talus::gas
