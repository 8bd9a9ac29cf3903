// Inverse of the cumulative size distribution: one uniform number in, one diameter out. Who calls it:
// core/grains/insertion.cpp. Invariants: I4 (own log and exp, + - * / sqrt); a diameter lies within [smallest, largest]
// of the distribution.
#pragma once

#include <vector>

#include "core/scene/scene.hpp"

namespace talus {

/// Draws so that the *number* of particles follows the distribution, or their *mass* where it is stated by mass (then
/// a diameter is drawn with a probability density proportional to the mass density / d^3).
class SizeSampler {
 public:
  explicit SizeSampler(const SizeDistribution& size);
  /// Diameter [m] at the cumulative number fraction u in [0, 1).
  double diameter(double u) const noexcept;

 private:
  /// Piece [a, b] of the support that holds the number fraction (low, high] of the particles.
  struct Piece {
    double a, b;  ///< [m]
    double low, high;
    double p, q;  ///< density at a and b in any common unit; unused where inverse_square
  };
  void add_class(double a, double b, double weight, bool by_mass);
  void add_density(const SizeDistribution& size);
  void normalise() noexcept;

  std::vector<Piece> pieces_;
  bool inverse_square_ = false;  ///< uniform in mass within a piece: 1/d^2 is uniform
};

}  // namespace talus
