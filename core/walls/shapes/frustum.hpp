// Surfaces of revolution about an axis: the shape behind cylinder and cone. Who uses it: their files.
#pragma once

#include "core/walls/shapes/shape.hpp"

namespace talus {

/// ShapeSides::of and ShapeKind::away of a tube whose radius goes from spec.radius to `radius_end`.
double side_of_tube(const WallSpec& spec, double radius_end, Vec3 x);
double away_of_tube(const Domain& domain, const WallSpec& spec, double radius_end);

class Frustum final : public Shape {
 public:
  /// Radius spec.radius at spec.point, `radius_end` at the other end [m].
  Frustum(const WallSpec& spec, double radius_end);
  bool closest(std::int32_t, Vec3 b, double, ElementHit& hit) const override {
    hit = talus::closest(frustum_, b);
    return true;
  }
  void near(Vec3 b, double, double, std::vector<NearElement>& out) const override {
    out.push_back({0, talus::closest(frustum_, b).distance});
  }
  WallSurface surface(const WallPose& pose, Vec3 lower, Vec3 upper) const override;
  double travelled(const WallPose& from, const WallPose& to, const std::array<Vec3, 8>& domain) const override;
  double speed(const WallPose& pose, const std::array<Vec3, 8>& domain) const override;
  double arm(const WallMotion& motion) const override;
  WallPiece piece(std::int32_t) const override;

 private:
  FrustumElement frustum_;
  bool turns_in_place_;  ///< rotation maps the surface onto itself
};

}  // namespace talus
