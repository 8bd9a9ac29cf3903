// Construction of properties; see property.hpp.
#include "core/heat/property.hpp"

#include "core/base/error.hpp"

namespace talus::heat {

Property Property::constant(double value) {
  Property p;
  p.first_ = value;
  return p;
}

Property Property::polynomial(std::vector<double> coefficients, double origin, double low, double high) {
  if (coefficients.empty()) throw Error(ErrorCode::scene, "a polynomial needs at least one coefficient");
  if (!(low < high)) throw Error(ErrorCode::scene, "the range of a polynomial must ascend");
  // Moved to the lower end by Horner's scheme, so that a piece vanishes there.
  const double shift = low - origin;
  for (std::size_t i = 0; i + 1 < coefficients.size(); ++i)
    for (std::size_t k = coefficients.size() - 1; k > i; --k) coefficients[k - 1] += shift * coefficients[k];
  Property p;
  p.first_ = coefficients.front();
  if (coefficients.size() > 1)
    p.pieces_.push_back({low, high, std::vector<double>(coefficients.begin() + 1, coefficients.end())});
  return p;
}

Property Property::table(const std::vector<double>& temperatures, const std::vector<double>& values) {
  if (temperatures.size() < 2 || temperatures.size() != values.size())
    throw Error(ErrorCode::scene, "a table needs two or more pairs [temperature, value]");
  Property p;
  p.first_ = values.front();
  for (std::size_t k = 0; k + 1 < values.size(); ++k) {
    const double width = temperatures[k + 1] - temperatures[k];
    if (!(width > 0)) throw Error(ErrorCode::scene, "the temperatures of a table must ascend");
    p.pieces_.push_back({temperatures[k], temperatures[k + 1], {(values[k + 1] - values[k]) / width}});
  }
  return p;
}

Property Property::of(const Curve& curve) {
  if (!curve.at.empty()) return table(curve.at, curve.value);
  return polynomial(curve.coefficients, curve.origin, curve.low, curve.high);
}

double Property::least_on(double low, double high) const {
  double least_value = at(low);
  for (int k = 1; k <= 256; ++k) least_value = least(least_value, at(low + (high - low) * k / 256));
  return least_value;
}

}  // namespace talus::heat
