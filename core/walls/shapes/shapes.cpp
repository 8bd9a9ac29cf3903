// The list of shapes; see shape.hpp.
#include "core/base/error.hpp"
#include "core/walls/shapes/shape.hpp"

namespace talus {

const ShapeKind& shape_kind(WallShape shape) {
  static constexpr const ShapeKind* kinds[] = {&k_plane_shape, &k_cylinder_shape, &k_cone_shape, &k_box_shape,
                                               &k_mesh_shape};
  for (const ShapeKind* k : kinds)
    if (k->shape == shape) return *k;
  throw Error(ErrorCode::scene, "a wall has a shape that is none", "[[wall]]");
}

void require_of_wall(bool ok, const WallSpec& wall, const std::string& what, const std::string& cure) {
  if (!ok) throw Error(ErrorCode::scene, what, "wall \"" + wall.name + "\"", cure);
}

std::array<Vec3, 8> box_corners(Vec3 lower, Vec3 upper) {
  std::array<Vec3, 8> c;
  for (int k = 0; k < 8; ++k)
    c[static_cast<std::size_t>(k)] = {k & 1 ? upper.x : lower.x, k & 2 ? upper.y : lower.y, k & 4 ? upper.z : lower.z};
  return c;
}

double away_from(const Domain& domain, Vec3 lower, Vec3 upper) {
  double gap = 0;
  for (int k = 0; k < 3; ++k)
    if (!domain.periodic(k)) gap = fmax2(gap, fmax2(lower[k] - domain.upper[k], domain.lower[k] - upper[k]));
  return gap;
}

}  // namespace talus
