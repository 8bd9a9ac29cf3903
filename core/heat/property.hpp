// A property of matter as a function of temperature: constant, polynomial or table, with its integral. Who calls it:
// the grain solvers (heat capacity and its enthalpy, conductivity), readers of grain files. Invariants: integral() is
// the exact antiderivative of at(), so that enthalpy and heat capacity never disagree; outside its range a property
// keeps the value of the nearer end.
#pragma once

#include <vector>

#include "core/base/curve.hpp"
#include "core/heat/value.hpp"

namespace talus::heat {

class Property {
 public:
  Property() = default;  ///< zero
  static Property constant(double value);
  /// Sum of coefficients[k] (T - origin)^k for T in [low, high] [K]. Error{scene}: no coefficient, low >= high.
  static Property polynomial(std::vector<double> coefficients, double origin = 0, double low = 0, double high = 1e5);
  /// Straight lines through (temperatures[k], values[k]). Error{scene}: fewer than 2 nodes, other lengths, not
  /// ascending.
  static Property table(const std::vector<double>& temperatures, const std::vector<double>& values);

  /// Of a scene.
  static Property of(const Curve& curve);

  /// The value at T [K].
  template <class V>
  V at(V T) const {
    V sum = V(first_);
    for (const Piece& p : pieces_) {
      const V x = clamped(T, V(p.low), V(p.high)) - V(p.low);
      V slope = V(p.power.back());
      for (std::size_t k = p.power.size() - 1; k > 0; --k) slope = slope * x + V(p.power[k - 1]);
      sum = sum + slope * x;
    }
    return sum;
  }
  /// Its integral over temperature from a fixed lower end [unit K].
  template <class V>
  V integral(V T) const {
    V sum = V(first_) * T;
    for (const Piece& p : pieces_) {
      const V inside = clamped(T, V(p.low), V(p.high));
      const V x = inside - V(p.low), beyond = most(T, V(p.high)) - V(p.high);
      V area = V(0), slope = V(0);
      for (std::size_t k = p.power.size(); k > 0; --k) {
        area = area * x + V(p.power[k - 1] / static_cast<double>(k + 1));
        slope = slope * x + V(p.power[k - 1]);
      }
      sum = sum + area * x * x + slope * x * beyond;
    }
    return sum;
  }
  double first() const { return first_; }         ///< value below all pieces
  const auto& pieces() const { return pieces_; }  ///< ascending; see Piece
  /// Least value on [low, high] [K], by sampling.
  double least_on(double low, double high) const;

  bool varies() const noexcept { return !pieces_.empty(); }

 private:
  /// From low on the value grows by sum of power[k] (T - low)^(k + 1); beyond high it stays.
  struct Piece {
    double low, high;
    std::vector<double> power;
  };
  double first_ = 0;  ///< value at and below the lowest end
  std::vector<Piece> pieces_;
};

}  // namespace talus::heat
