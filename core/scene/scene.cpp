// Small functions of the scene's plain data.
#include "core/scene/scene.hpp"

#include "core/scene/duration.hpp"

namespace talus {

ListPolicy Scene::fitting_policy() const noexcept {
  bool driven = false, open = false;
  for (int k = 0; k < 3; ++k) {
    driven = driven || (domain.periodic(k) && gravity[k] != 0);
    open = open || !domain.periodic(k);
    for (const Boundary side : domain.boundary[static_cast<std::size_t>(k)])
      if (side == Boundary::wall) return ListPolicy::local;
  }
  return driven && open && walls.empty() ? ListPolicy::velocity_profile : ListPolicy::local;
}

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

double end_of(const Scene& scene) {
  return scene.steps > 0 && scene.dt > 0 ? scene.dt * static_cast<double>(scene.steps) : k_never;
}

}  // namespace talus
