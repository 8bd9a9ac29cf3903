// An infinite plane. Only the part of it in the domain matters, and sliding along itself moves no point of it towards a
// particle.
#include <cmath>

#include "core/walls/shapes/shape.hpp"
#include "core/walls/wall_images.hpp"
#include "core/walls/wall_surface.hpp"

namespace talus {
namespace {

class Plane final : public Shape {
 public:
  explicit Plane(const WallSpec& spec) : plane_(make_plane(spec.point, spec.normal)) {
    corners.fill(spec.point);
    bounded = false;
  }
  bool closest(std::int32_t, Vec3 b, double, ElementHit& hit) const override {
    hit = talus::closest(plane_, b);
    return true;
  }
  void near(Vec3 b, double, double, std::vector<NearElement>& out) const override {
    out.push_back({0, talus::closest(plane_, b).distance});
  }
  WallSurface surface(const WallPose& pose, Vec3 lower, Vec3 upper) const override {
    return clipped_plane(to_world(pose, plane_.point), direction_to_world(pose, plane_.normal), lower, upper);
  }
  double travelled(const WallPose& from, const WallPose& to, const std::array<Vec3, 8>& domain) const override {
    if (!from.rotated && !to.rotated) return std::abs(dot(to.translation - from.translation, plane_.normal));
    std::array<Vec3, 16> body;  // of the part in the domain, then and now
    for (std::size_t k = 0; k < 8; ++k) body[k] = to_body(from, domain[k]), body[8 + k] = to_body(to, domain[k]);
    return talus::travel(from, to, body);
  }
  double speed(const WallPose& pose, const std::array<Vec3, 8>& domain) const override {
    if (norm2(pose.omega) == 0) return std::abs(dot(pose.velocity, direction_to_world(pose, plane_.normal)));
    std::array<Vec3, 8> body;
    for (std::size_t k = 0; k < 8; ++k) body[k] = to_body(pose, domain[k]);
    return fastest(pose, body);
  }
  double arm(const WallMotion&) const override { return k_never; }
  WallPiece piece(std::int32_t) const override {
    WallPiece p;
    p.kind = WallPiece::Kind::plane;
    p.corner[0] = plane_.point;
    p.normal = plane_.normal;
    return p;
  }

 private:
  PlaneElement plane_;
};

void check(const WallSpec& w) {
  require_of_wall(norm2(w.normal) > 0, w, "the normal has no length", "e.g. normal = [0, 0, 1]");
}

std::unique_ptr<const Shape> make(const ShapeRequest& r) {
  require_periodic_plane(r.scene.domain, r.spec);
  return std::make_unique<Plane>(r.spec);
}

double side(const WallSpec& w, Vec3 x) { return dot(x - w.point, unit(w.normal)); }

double away(const Domain& d, const WallSpec& w) {
  double low = k_never, high = -k_never;
  for (const Vec3 x : box_corners(d.lower, d.upper)) {
    const double s = side(w, x);
    low = fmin2(low, s), high = fmax2(high, s);
  }
  return fmax2(0.0, fmax2(low, -high));
}

}  // namespace

const ShapeKind k_plane_shape{WallShape::plane, check, make, nullptr, {side, "behind it", "before it"}, away};

}  // namespace talus
