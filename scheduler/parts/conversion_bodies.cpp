// See conversion_bodies.hpp.
#include "scheduler/parts/conversion_bodies.hpp"

#include "core/base/det_math.hpp"
#include "core/grains/body_shape.hpp"
#include "core/shapes/surface_area.hpp"

namespace talus {

std::vector<EqualSpheres> equal_spheres(const Scene& scene) {
  std::vector<EqualSpheres> all;
  for (const ShapeSpec& s : scene.shapes) {
    const BodyShape& body = *s.body;
    const double area = body.quadric ? shapes::surface_area(body.quadric->surface) : shapes::surface_area(body.spheres),
                 volume = body.volume;
    all.push_back({3 * volume / area, area * area * area / (36 * det::k_pi * (volume * volume))});
  }
  return all;
}

double smallest_of_equal_spheres(const Scene& scene, const std::vector<EqualSpheres>& shapes, double smallest_row) {
  double share = k_never;
  for (const Source& s : scene.sources)
    if (s.shape < 0) share = 1;  // spheres, or a file, which may hold any shape
  for (std::size_t k = 0; k < shapes.size(); ++k)
    share = fmin2(share, shapes[k].radius / scene.shapes[k].body->smallest);
  return share < k_never ? share * smallest_row : smallest_row;
}

}  // namespace talus
