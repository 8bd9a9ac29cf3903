// Lateral surface of a cone; of length 0 an annulus or a disc.
#include "core/walls/shapes/frustum.hpp"

namespace talus {
namespace {

void check(const WallSpec& w) {
  require_of_wall(norm2(w.axis) > 0, w, "the axis has no length", "e.g. axis = [0, 0, 1]");
  require_of_wall(w.length >= 0 && w.radius >= 0 && w.radius_end >= 0, w, "a cone has a negative length or radius",
                  "length, radius and radius_end are >= 0");
  require_of_wall(w.radius > 0 || w.radius_end > 0, w, "both radii of the cone are 0", "set radius or radius_end");
  require_of_wall(w.length > 0 || w.radius != w.radius_end, w, "a cone of length 0 and equal radii is a circle",
                  "an annulus needs two different radii");
}

std::unique_ptr<const Shape> make(const ShapeRequest& r) {
  return std::make_unique<Frustum>(r.spec, r.spec.radius_end);
}

double side(const WallSpec& w, Vec3 x) { return side_of_tube(w, w.radius_end, x); }

double away(const Domain& d, const WallSpec& w) { return away_of_tube(d, w, w.radius_end); }

}  // namespace

const ShapeKind k_cone_shape{WallShape::cone, check, make, nullptr, {side, "within it", "around it"}, away};

}  // namespace talus
