// Enthalpy of a material that may melt: that of its capacity, and between solidus and liquidus the latent heat, spread
// evenly over the sensible heat there (with a constant capacity: linear in temperature; with equal ends: a plateau).
// Who calls it: scheduler/parts/heat. Invariant: the enthalpy is the state, temperature and molten fraction follow from
// it, so that melting and freezing keep energy to rounding (the enthalpy method, Voller and Cross 1981).
#pragma once

#include <utility>

#include "core/heat/property.hpp"

namespace talus::heat {

class Enthalpy {
 public:
  Enthalpy() = default;
  explicit Enthalpy(Property capacity) : capacity_(std::move(capacity)) {}
  /// It melts from `solidus` to `liquidus` [K], not descending, and takes `latent` [J/kg].
  Enthalpy(Property capacity, double solidus, double liquidus, double latent)
      : capacity_(std::move(capacity)),
        begin_(capacity_.integral(solidus)),
        end_(capacity_.integral(liquidus)),
        latent_(latent) {}

  const Property& capacity() const noexcept { return capacity_; }
  bool melts() const noexcept { return latent_ > 0; }
  /// At T [K], per mass [J/kg].
  double at(double T) const {
    const double sensible = capacity_.integral(T);
    return melts() ? sensible + latent_ * share(sensible, begin_, end_) : sensible;
  }
  /// Share that is molten of matter that holds `per_mass` [J/kg].
  double molten(double per_mass) const { return melts() ? share(per_mass, begin_, end_ + latent_) : 0.0; }
  /// Temperature of matter that holds `per_mass` [J/kg], from one that is near [K].
  double temperature(double per_mass, double near) const {
    const double sensible = melts() ? per_mass - latent_ * molten(per_mass) : per_mass;
    if (!capacity_.varies()) return sensible / capacity_.at(0.0);
    double T = near;
    for (int k = 0; k < 60; ++k) {
      const double step = (sensible - capacity_.integral(T)) / capacity_.at(T);
      T = T + step;
      if (step * step <= 1e-30 * (T * T)) break;
    }
    return T;
  }

 private:
  /// Of the way from low to high that x has gone; a step behind `low` where they are equal.
  static double share(double x, double low, double high) {
    if (!(x > low)) return 0;
    return x < high ? (x - low) / (high - low) : 1.0;
  }

  Property capacity_;
  double begin_ = 0, end_ = 0;  ///< sensible heats at solidus and liquidus [J/kg]
  double latent_ = 0;
};

}  // namespace talus::heat
