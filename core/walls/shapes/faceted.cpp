// See faceted.hpp.
#include "core/walls/shapes/faceted.hpp"

#include "core/walls/wall_mesh.hpp"
#include "core/walls/wall_surface.hpp"

namespace talus {

Faceted::Faceted(const Mesh& mesh, const ShapeRequest& r) : facets_(make_facets(mesh)) {
  slack = flatness(facets_);
  grid_ = FacetGrid(facets_, r.max_reach, slack);
  if (r.usual_reach > 0 && r.usual_reach < r.max_reach) usual_grid_ = FacetGrid(facets_, r.usual_reach, slack);
  elements = static_cast<std::int32_t>(facets_.size());
  corners = box_corners(mesh.report.lower, mesh.report.upper);
  facets = true;
}

void Faceted::near(Vec3 b, double within, double reach, std::vector<NearElement>& out) const {
  const auto test = [&](std::int32_t f) {
    ElementHit hit;
    if (closest(f, b, within, hit)) out.push_back({f, hit.distance});
  };
  // a grid was built with the slack on top of its reach
  const auto covers = [&](const FacetGrid& g) { return reach - slack <= g.reach() * (1 + 0.5e-6); };
  if (covers(usual_grid_)) {
    for (const std::int32_t f : usual_grid_.near(b)) test(f);
  } else if (covers(grid_)) {
    for (const std::int32_t f : grid_.near(b)) test(f);
  } else {  // more than the grid was built for: slower, never incomplete
    for (std::int32_t f = 0; f < elements; ++f) test(f);
  }
}

WallSurface Faceted::surface(const WallPose& pose, Vec3, Vec3) const {
  WallSurface s = tessellated(facets_);
  for (Vec3& p : s.points) p = to_world(pose, p);
  return s;
}

double Faceted::arm(const WallMotion& m) const {
  double arm = 0;
  for (const TriangleElement& t : facets_)
    arm = fmax2(arm, farthest_from_axis(m.rotation_origin, m.rotation_axis, t.v));
  return arm;
}

std::size_t Faceted::bytes() const noexcept {
  return facets_.size() * sizeof(TriangleElement) + grid_.bytes() + usual_grid_.bytes();
}

}  // namespace talus
