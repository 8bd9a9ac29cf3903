// Small functions of the scene's plain data.
#include "core/scene.hpp"

namespace talus {

double SizeDistribution::smallest() const noexcept {
  switch (kind) {
    case Kind::constant:
      return diameter;
    case Kind::sieve:
      return edges.empty() ? 0 : edges.front();
    default:
      return min;
  }
}

double SizeDistribution::largest() const noexcept {
  switch (kind) {
    case Kind::constant:
      return diameter;
    case Kind::sieve:
      return edges.empty() ? 0 : edges.back();
    default:
      return max;
  }
}

}  // namespace talus
