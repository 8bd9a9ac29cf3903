// Six faces along the axes, as a closed surface.
#include "core/walls/shapes/faceted.hpp"
#include "core/walls/wall_mesh.hpp"

namespace talus {
namespace {

void check(const WallSpec& w) {
  require_of_wall(w.lower.x < w.upper.x && w.lower.y < w.upper.y && w.lower.z < w.upper.z, w, "the box is empty",
                  "lower < upper on every axis");
}

std::unique_ptr<const Shape> make(const ShapeRequest& r) {
  Mesh mesh = box_mesh(r.spec.lower, r.spec.upper);
  check_mesh(mesh, 0);
  return std::make_unique<Faceted>(mesh, r);
}

double away(const Domain& d, const WallSpec& w) { return away_from(d, w.lower, w.upper); }

std::optional<Mesh> enclosing(const Scene&, const WallSpec& w) { return box_mesh(w.lower, w.upper); }

}  // namespace

const ShapeKind k_box_shape{WallShape::box, check, make, enclosing, {}, away};

}  // namespace talus
