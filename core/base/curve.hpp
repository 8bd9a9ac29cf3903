// A value as a function of one argument, as scenes give it: constant, polynomial or straight lines through points.
// Plain data; core/heat/property.hpp evaluates one together with its integral. Who uses it: core/scene and its readers.
#pragma once

#include <cstddef>
#include <vector>

namespace talus {

/// Of temperature [K], mostly. Outside its range it keeps the value of the nearer end.
struct Curve {
  std::vector<double> coefficients;  ///< sum of coefficients[k] (x - origin)^k; empty: the points hold
  double origin = 0, low = 250, high = 2000;
  std::vector<double> at, value;  ///< points, ascending

  static Curve constant(double value) { return {{value}, 0, 250, 2000, {}, {}}; }
  bool given() const noexcept { return !coefficients.empty() || !at.empty(); }
  bool varies() const noexcept { return coefficients.size() > 1 || !at.empty(); }
};

/// Of time: straight lines through points, constant beyond the ends.
struct TimeTable {
  std::vector<double> time, value;  ///< [s], ascending; one point: a constant

  static TimeTable constant(double value) { return {{0}, {value}}; }
  bool given() const noexcept { return !value.empty(); }
  double operator()(double t) const noexcept {
    std::size_t k = 0;
    while (k < time.size() && time[k] <= t) ++k;
    if (k == 0) return value.front();
    if (k == time.size()) return value.back();
    return value[k - 1] + (value[k] - value[k - 1]) * ((t - time[k - 1]) / (time[k] - time[k - 1]));
  }
  /// Mean over [middle - width/2, middle + width/2], exact; the value in the middle where no point lies within.
  double mean(double middle, double width) const noexcept {
    const double from = middle - 0.5 * width, to = middle + 0.5 * width;
    double sum = 0, t = from, x = (*this)(from);
    std::size_t k = 0;
    while (k < time.size() && time[k] <= from) ++k;
    if (k == time.size() || time[k] >= to) return (*this)(middle);
    for (; k < time.size() && time[k] < to; ++k) {
      sum = sum + 0.5 * (x + value[k]) * (time[k] - t);
      t = time[k], x = value[k];
    }
    const double end = k < time.size() ? x + (value[k] - x) * ((to - t) / (time[k] - t)) : x;
    return (sum + 0.5 * (x + end) * (to - t)) / (to - from);
  }
  double least() const noexcept {
    double x = value.front();
    for (const double v : value) x = v < x ? v : x;
    return x;
  }
  double most() const noexcept {
    double x = value.front();
    for (const double v : value) x = v > x ? v : x;
    return x;
  }
};

}  // namespace talus
