// See doors.hpp.
#include "scheduler/parts/doors.hpp"

#include "core/conversion/around.hpp"

namespace talus {

bool has_shells(const ConversionScene& scene, std::size_t material) {
  return material < scene.grain.size() && !scene.grain[material].empty();
}

double thinned(double conductance, double carried) {
  return carried > 0 && conductance > 0 ? conductance * conversion::blown(carried / conductance) : conductance;
}

}  // namespace talus
