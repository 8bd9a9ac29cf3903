// Triangles with the planes they share: the shape behind box and mesh. Who uses it: their files.
#pragma once

#include "core/walls/facet_grid.hpp"
#include "core/walls/shapes/shape.hpp"

namespace talus {

class Faceted final : public Shape {
 public:
  Faceted(const Mesh& mesh, const ShapeRequest& r);
  bool closest(std::int32_t element, Vec3 b, double limit, ElementHit& hit) const override {
    return closest_within(facets_[static_cast<std::size_t>(element)], b, limit, hit);
  }
  void near(Vec3 b, double within, double reach, std::vector<NearElement>& out) const override;
  WallSurface surface(const WallPose& pose, Vec3 lower, Vec3 upper) const override;
  WallPiece piece(std::int32_t element) const override {
    const std::array<Vec3, 3>& v = facets_[static_cast<std::size_t>(element)].v;
    WallPiece p;
    p.kind = WallPiece::Kind::triangle;
    for (std::size_t k = 0; k < 3; ++k) p.corner[k] = v[k];
    return p;
  }
  double arm(const WallMotion& motion) const override;
  std::size_t bytes() const noexcept override;

 private:
  std::vector<TriangleElement> facets_;
  FacetGrid grid_;        ///< for the largest reach there can be
  FacetGrid usual_grid_;  ///< for the reach of nearly all grains: shorter lists; empty where none was asked for
};

}  // namespace talus
