// Lateral surface of a cylinder.
#include "core/walls/shapes/frustum.hpp"

namespace talus {
namespace {

void check(const WallSpec& w) {
  require_of_wall(norm2(w.axis) > 0, w, "the axis has no length", "e.g. axis = [0, 0, 1]");
  require_of_wall(w.length > 0 && w.radius > 0, w, "a cylinder needs length > 0 and radius > 0", "set both");
}

std::unique_ptr<const Shape> make(const ShapeRequest& r) { return std::make_unique<Frustum>(r.spec, r.spec.radius); }

double side(const WallSpec& w, Vec3 x) { return side_of_tube(w, w.radius, x); }

double away(const Domain& d, const WallSpec& w) { return away_of_tube(d, w, w.radius); }

}  // namespace

const ShapeKind k_cylinder_shape{WallShape::cylinder, check, make, nullptr, {side, "within it", "around it"}, away};

}  // namespace talus
