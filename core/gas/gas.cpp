// See gas.hpp.
#include "core/gas/gas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/base/error.hpp"
#include "core/gas/combustion.hpp"
#include "core/gas/openings.hpp"
#include "core/gas/species.hpp"

namespace talus::gas {

namespace {

constexpr double k_rounding = 1e-9;  // negative share of a cell's mass that is none

GasFractions fractions_of(const GasFractions& mass) {
  const double m = sum(mass);
  GasFractions y = mass;
  for (double& x : y) x /= m;
  return y;
}

void add(GasFractions& to, const GasFractions& what) {
  for (std::size_t k = 0; k < to.size(); ++k) to[k] += what[k];
}

void add(Passed& to, const Passed& p) {
  add(to.in, p.in);
  add(to.out, p.out);
  add(to.grains, p.grains);
  to.enthalpy_in += p.enthalpy_in;
  to.enthalpy_out += p.enthalpy_out;
  to.enthalpy_grains += p.enthalpy_grains;
  to.heat_grains += p.heat_grains;
  to.pressure_work += p.pressure_work;
}

}  // namespace

double Balance::mass_residual() const noexcept {
  return ((sum(stored) - sum(start)) - sum(passed.in)) + (sum(passed.out) - sum(passed.grains));
}
double Balance::enthalpy_residual() const noexcept {
  return ((stored_enthalpy - start_enthalpy) - passed.enthalpy_in) + passed.enthalpy_out -
         (passed.enthalpy_grains + passed.heat_grains) - passed.pressure_work;
}
double Balance::element_residual(int element) const noexcept {
  double r = 0;
  for (int k = 0; k < k_gas_species; ++k) {
    const auto q = static_cast<std::size_t>(k);
    static constexpr double weight[k_elements] = {12.011e-3, 1.00794e-3, 15.9994e-3, 14.0067e-3};
    const double share = species(k).atoms[element] * weight[element] / species(k).molar_mass;
    r += share * (((stored[q] - start[q]) - passed.in[q]) + (passed.out[q] - passed.grains[q]));
  }
  return r;
}

Gas::Gas(const GasSettings& settings, std::array<bool, 3> periodic, Vec3 gravity)
    : settings_(settings),
      grid_(settings.lower, settings.upper, settings.cells, periodic),
      gravity_(gravity),
      solver_(grid_),
      openings_(openings_of(grid_, settings)) {
  fields_.resize(grid_.cells());
  vessel_ = {std::none_of(openings_.begin(), openings_.end(),
                          [](const Opening& o) { return o.kind == Opening::Kind::pressure; }),
             settings_.pressure};
}

void Gas::set_porosity(const FromGrains& grains) {
  double volume = 0, specific = 0;
  for (std::size_t c = 0; c < fields_.porosity.size(); ++c) {
    const double solid = grains.solid[c] / grid_.volume;
    fields_.porosity[c] = fmax2(settings_.least_porosity, 1 - solid);
    fields_.diameter[c] = grains.specific[c] > 0 ? grains.solid[c] / grains.specific[c] : 0;
    volume += grains.solid[c];
    specific += grains.specific[c];
  }
  // without any grain: as if the smallest edge of a cell held three
  mean_diameter_ = specific > 0 ? volume / specific : fmin2(grid_.h.x, fmin2(grid_.h.y, grid_.h.z)) / 3;
}

void Gas::start(const FromGrains& grains) {
  const auto n = static_cast<std::size_t>(grid_.cells());
  set_porosity(grains);
  const double rt = specific_gas_constant(settings_.fractions) * settings_.temperature;
  const double h = enthalpy(settings_.fractions, settings_.temperature);
  content_.mass.assign(n, settings_.fractions);
  content_.enthalpy.resize(n);
  content_.temperature.assign(n, settings_.temperature);
  for (std::size_t c = 0; c < n; ++c) {
    const double m = settings_.pressure / rt * fields_.porosity[c] * grid_.volume;
    for (double& x : content_.mass[c]) x *= m;
    content_.enthalpy[c] = m * h;
    add(balance_.start, content_.mass[c]);
    balance_.start_enthalpy += content_.enthalpy[c];
  }
  vessel_.pressure = settings_.pressure;
  balance_.stored = balance_.start;
  balance_.stored_enthalpy = balance_.start_enthalpy;
  flow_ = {};
  flow_.pressure.assign(n, settings_.pressure);
  flow_.inner.assign(grid_.inner.size(), 0);
  flow_.outer.assign(grid_.outer.size(), 0);
  flow_.inner_flux = flow_.inner;
  flow_.outer_flux = flow_.outer;
  flow_.outer_pressure.assign(flow_.outer.size(), settings_.pressure);
  flow_.velocity.assign(n, Vec3{});
  flow_.gradient.assign(n, Vec3{});
  set_fields();
}

/// What a sealed vessel comes to by its mass: pressures are solved for as differences from it, which are small.
double Gas::sealed_pressure(const FlowInput& in) const {
  double mass = 0, room = 0;
  for (std::size_t c = 0; c < in.mass.size(); ++c) {
    mass += in.mass[c] + in.dt * in.source[c];
    room += in.porosity[c] * grid_.volume / in.gas_constant_t[c];
  }
  for (const Opening& o : in.outer) mass += in.dt * o.flux;
  return mass > 0 ? mass / room : in.reference;
}

FlowInput Gas::flow_input(const FromGrains& grains, double dt) const {
  const auto n = static_cast<std::size_t>(grid_.cells());
  FlowInput in;
  in.drag = settings_.drag;
  in.reference = settings_.pressure;
  in.dt = dt;
  in.most_porosity = settings_.most_porosity;
  in.mean_diameter = mean_diameter_;
  in.gravity = gravity_;
  in.porosity = fields_.porosity;
  in.diameter = fields_.diameter;
  in.drag_factor = grains.drag_factor;
  in.outer = openings_;
  in.viscosity.resize(n);
  in.gas_constant_t.resize(n);
  in.mass.resize(n);
  in.source.resize(n);
  in.solid_velocity.resize(n);
  for (std::size_t c = 0; c < n; ++c) {
    in.viscosity[c] = viscosity(content_.temperature[c]);
    in.gas_constant_t[c] = specific_gas_constant(fractions_of(content_.mass[c])) * content_.temperature[c];
    in.mass[c] = sum(content_.mass[c]);
    in.source[c] = sum(grains.source[c]);
    if (grains.solid[c] > 0) in.solid_velocity[c] = (1 / (grains.drag_factor[c] * grains.solid[c])) * grains.moment[c];
  }
  if (vessel_.sealed) in.reference = sealed_pressure(in);
  return in;
}

/// Cells by falling pressure: the flow runs that way.
std::vector<int> Gas::flow_order() const {
  std::vector<int> order(static_cast<std::size_t>(grid_.cells()));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return flow_.pressure[static_cast<std::size_t>(a)] > flow_.pressure[static_cast<std::size_t>(b)];
  });
  return order;
}

/// What grains want is at most what is there and what the flow of the step before brings.
FromGrains Gas::at_most_there(const FromGrains& grains, double dt) const {
  FromGrains capped = grains;
  std::vector<GasFractions> there = content_.mass;
  const auto bring = [&](int to, const GasFractions& y, double mass) {
    for (std::size_t k = 0; k < y.size(); ++k) there[static_cast<std::size_t>(to)][k] += mass * y[k];
  };
  for (std::size_t k = 0; k < grid_.inner.size(); ++k) {
    const InnerFace& f = grid_.inner[k];
    const double m = dt * flow_.inner_flux[k];
    if (m > 0) bring(f.b, fields_.fractions[static_cast<std::size_t>(f.a)], m);
    if (m < 0) bring(f.a, fields_.fractions[static_cast<std::size_t>(f.b)], -m);
  }
  for (std::size_t k = 0; k < grid_.outer.size(); ++k)
    if (const double m = dt * flow_.outer_flux[k]; m < 0) bring(grid_.outer[k].cell, openings_[k].fractions, -m);
  for (std::size_t c = 0; c < there.size(); ++c)
    for (std::size_t k = 0; k < k_gas_species; ++k) capped.source[c][k] = fmax2(grains.source[c][k], -there[c][k] / dt);
  return capped;
}

void Gas::step(const FromGrains& wanted, double dt) {
  set_porosity(wanted);
  const FromGrains grains = at_most_there(wanted, dt);
  solver_.solve(flow_input(grains, dt), flow_);
  for (std::size_t c = 0; c < fields_.drag.size(); ++c) {
    const double e = fields_.porosity[c];
    fields_.drag[c] = e * e * flow_.resistance[c] * grid_.volume;
  }
  Passed passed;
  transport(grid_, flow_, openings_, grains, dt, flow_order(), vessel_, content_, fields_, passed);
  take_pressure();
  for (std::size_t c = 0; c < fields_.taken.size(); ++c)
    for (std::size_t k = 0; k < k_gas_species; ++k)
      if (wanted.source[c][k] < 0) fields_.taken[c][k] *= grains.source[c][k] / wanted.source[c][k];
  for (std::size_t c = 0; c < content_.mass.size(); ++c) {
    double& t = content_.temperature[c];
    if (settings_.combustion)
      t = burn(content_.mass[c], content_.enthalpy[c], t, flow_.pressure[c], dt);
    else
      t = temperature_of(fractions_of(content_.mass[c]), content_.enthalpy[c] / sum(content_.mass[c]), t);
  }
  add(balance_.passed, passed);
  store();
  ++steps_;
  set_fields();
}

/// The flow was solved for the temperatures before the step; in a sealed vessel pressure has followed them since.
void Gas::take_pressure() {
  if (!vessel_.sealed) return;
  double mass = 0, room = 0;
  for (std::size_t c = 0; c < content_.mass.size(); ++c) {
    const double here = fields_.porosity[c] * grid_.volume;
    mass += here * flow_.pressure[c];
    room += here;
  }
  const double factor = vessel_.pressure * room / mass;
  for (auto* of : {&flow_.pressure, &flow_.outer_pressure})
    for (double& p : *of) p *= factor;
}

double Gas::pressure() const noexcept {
  if (vessel_.sealed || !started()) return vessel_.pressure;
  double sum = 0, room = 0;
  for (std::size_t c = 0; c < fields_.porosity.size(); ++c) {
    sum += fields_.porosity[c] * flow_.pressure[c];
    room += fields_.porosity[c];
  }
  return sum / room;
}

void Gas::give(int cell, const GasFractions& mass, double enthalpy) {
  const auto c = static_cast<std::size_t>(cell);
  given_.resize(content_.mass.size(), 0);
  given_[c] = 1;
  add(content_.mass[c], mass);
  content_.enthalpy[c] += enthalpy;
  add(balance_.passed.grains, mass);
  balance_.passed.enthalpy_grains += enthalpy;
}

void Gas::settle() {
  for (std::size_t c = 0; c < given_.size(); ++c) {
    if (given_[c] == 0) continue;
    given_[c] = 0;
    const double whole = sum(content_.mass[c]);
    for (std::size_t k = 0; k < k_gas_species; ++k) {
      double& m = content_.mass[c][k];
      if (m < -k_rounding * whole) fail(c, std::string(species(static_cast<int>(k)).name) + " runs out");
      m = fmax2(m, 0);
    }
    double& t = content_.temperature[c];
    t = temperature_of(fractions_of(content_.mass[c]), content_.enthalpy[c] / sum(content_.mass[c]), t);
    if (!(t > 0.5 * k_coldest && t < 2 * k_hottest)) fail(c, fmt::format("the gas would have {:.4g} K", t));
  }
  store();
  set_fields();
}

void Gas::fail(std::size_t cell, const std::string& what) const {
  const Vec3 x = grid_.middle(static_cast<int>(cell));
  throw Error(ErrorCode::physics,
              fmt::format("{} at ({:.4g}, {:.4g}, {:.4g}) m by what grains take and give", what, x.x, x.y, x.z), "gas",
              "a smaller gas.every, larger cells");
}

void Gas::store() {
  balance_.stored = {};
  balance_.stored_enthalpy = 0;
  for (std::size_t c = 0; c < content_.mass.size(); ++c) {
    add(balance_.stored, content_.mass[c]);
    balance_.stored_enthalpy += content_.enthalpy[c];
  }
}

void Gas::set_fields() {
  for (std::size_t c = 0; c < content_.mass.size(); ++c) {
    const double t = content_.temperature[c];
    const GasFractions y = fractions_of(content_.mass[c]);
    fields_.fractions[c] = y;
    fields_.temperature[c] = t;
    fields_.pressure[c] = flow_.pressure[c];
    fields_.density[c] = flow_.pressure[c] / (specific_gas_constant(y) * t);
    fields_.viscosity[c] = viscosity(t);
    fields_.conductivity[c] = conductivity(y, t);
    fields_.prandtl[c] = k_prandtl;
    fields_.velocity[c] = flow_.velocity[c];
    fields_.gradient[c] = flow_.gradient[c];
  }
}

double Gas::pressure_drop(int axis) const noexcept {
  double low = 0, high = 0;
  int n = 0;
  for (std::size_t k = 0; k < grid_.outer.size(); ++k) {
    const OuterFace& f = grid_.outer[k];
    if (f.axis != axis) continue;
    (f.high ? high : low) += flow_.outer_pressure[k];
    n += f.high;
  }
  return n > 0 ? (low - high) / n : 0;
}

namespace {

template <class T>
void put(std::vector<std::uint8_t>& to, const std::vector<T>& v) {
  const std::size_t old = to.size(), bytes = v.size() * sizeof(T);
  to.resize(old + bytes);
  if (bytes != 0) std::memcpy(to.data() + old, v.data(), bytes);
}

/// Takes as many values as `v` has.
template <class T>
void take(std::span<const std::uint8_t>& from, std::vector<T>& v) {
  std::memcpy(v.data(), from.data(), v.size() * sizeof(T));
  from = from.subspan(v.size() * sizeof(T));
}

}  // namespace

std::vector<std::uint8_t> Gas::save() const {
  std::vector<std::uint8_t> bytes(sizeof balance_ + sizeof steps_);
  std::memcpy(bytes.data(), &balance_, sizeof balance_);
  std::memcpy(bytes.data() + sizeof balance_, &steps_, sizeof steps_);
  put(bytes, std::vector<double>{vessel_.pressure});
  put(bytes, content_.mass);
  put(bytes, content_.enthalpy);
  put(bytes, content_.temperature);
  put(bytes, flow_.pressure);
  put(bytes, flow_.inner);
  put(bytes, flow_.outer);
  put(bytes, flow_.inner_flux);
  put(bytes, flow_.outer_flux);
  put(bytes, flow_.outer_pressure);
  put(bytes, flow_.velocity);
  put(bytes, flow_.gradient);
  put(bytes, fields_.porosity);
  put(bytes, fields_.diameter);
  put(bytes, fields_.exchange_temperature);
  put(bytes, fields_.taken);
  return bytes;
}

void Gas::load(std::span<const std::uint8_t> bytes, const std::string& where) {
  start(FromGrains(grid_.cells()));  // gives everything its size
  if (bytes.size() != save().size())
    throw Error(ErrorCode::io, "the gas of the checkpoint lies on another grid", where,
                "gas.cells, and the version of the program, as they were");
  std::memcpy(&balance_, bytes.data(), sizeof balance_);
  std::memcpy(&steps_, bytes.data() + sizeof balance_, sizeof steps_);
  bytes = bytes.subspan(sizeof balance_ + sizeof steps_);
  std::vector<double> pressure(1);
  take(bytes, pressure);
  vessel_.pressure = pressure[0];
  take(bytes, content_.mass);
  take(bytes, content_.enthalpy);
  take(bytes, content_.temperature);
  take(bytes, flow_.pressure);
  take(bytes, flow_.inner);
  take(bytes, flow_.outer);
  take(bytes, flow_.inner_flux);
  take(bytes, flow_.outer_flux);
  take(bytes, flow_.outer_pressure);
  take(bytes, flow_.velocity);
  take(bytes, flow_.gradient);
  take(bytes, fields_.porosity);
  take(bytes, fields_.diameter);
  take(bytes, fields_.exchange_temperature);
  take(bytes, fields_.taken);
  for (const auto* v :
       {&pressure, &content_.enthalpy, &content_.temperature, &flow_.pressure, &flow_.inner, &flow_.outer})
    for (const double x : *v)
      if (!__builtin_isfinite(x)) throw Error(ErrorCode::io, "the gas of the checkpoint holds no finite number", where);
  set_fields();
}

}  // namespace talus::gas
