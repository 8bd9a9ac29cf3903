// Matter and surroundings for the tests of one grain. Called by tests/conversion/*_test.cpp.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/conversion/grain.hpp"

namespace talus::conversion::test {

/// One solid with constant properties [SI].
inline Matter inert(double density, double c, double k) {
  Matter m;
  m.density = density;
  m.solids = {{"solid", Kind::fuel, 1, {}}};
  for (auto& x : m.heat_capacity) x = Property::constant(c);
  for (auto& x : m.conductivity) x = Property::constant(k);
  m.conductivity_wet = Property::constant(k);
  m.gas_heat_capacity = Property::constant(1100);
  return m;
}

inline Matter checked(Matter m) {
  check_matter(m);
  return m;
}

inline Surroundings<double> gas_at(double T, double film) {
  Surroundings<double> s;
  s.film = film;
  s.gas_temperature = T;
  return s;
}

inline Surroundings<double> surface_at(double T) {
  Surroundings<double> s;
  s.given_surface = true;
  s.surface_temperature = T;
  s.gas_temperature = T;
  return s;
}

inline void run(Grain<double>& g, const Surroundings<double>& s, double dt, int steps,
                const GasAround<double>& gas = {}) {
  g.begin(s);
  for (int k = 0; k < steps; ++k) g.advance(dt, s, s, gas);
}

/// The order of convergence between two errors at half the size.
inline double order(double coarse, double fine) { return std::log2(coarse / fine); }

}  // namespace talus::conversion::test
