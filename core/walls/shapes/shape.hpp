// A wall's shape: everything that differs between a plane, a cylinder, a cone, a box and a mesh. Who uses it:
// core/walls (WallSet), core/grains (which walls enclose). To add a shape, write its file here, its word in WallShape
// and its keys in core/scene, and its line in shapes.cpp. Invariants: a shape rests in the wall's own frame and never
// changes; I4.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/meshes/mesh_file.hpp"
#include "core/scene/scene.hpp"
#include "core/walls/wall_elements.hpp"
#include "core/walls/wall_motion.hpp"
#include "core/walls/walls.hpp"

namespace talus {

/// Element of a shape near a point.
struct NearElement {
  std::int32_t element = 0;
  double distance = 0;  ///< [m]
};

class Shape {
 public:
  virtual ~Shape() = default;

  /// Closest point of one element to b, or false (hit unspecified) where it is plain that the distance is not below
  /// `limit` [m]; a true answer may still exceed it.
  virtual bool closest(std::int32_t element, Vec3 b, double limit, ElementHit& hit) const = 0;
  /// Appends at least the elements within `within` [m] of b, ascending; `reach`: that less what rounding adds.
  virtual void near(Vec3 b, double within, double reach, std::vector<NearElement>& out) const = 0;
  /// Triangles at the pose; what is infinite is cut at the box [lower, upper].
  virtual WallSurface surface(const WallPose& pose, Vec3 lower, Vec3 upper) const = 0;

  /// Largest displacement between two poses of a point that a particle can touch [m]. `domain`: corners of what
  /// particles can reach.
  virtual double travelled(const WallPose& from, const WallPose& to, const std::array<Vec3, 8>& domain) const {
    return talus::travel(from, to, corners);
  }
  /// Fastest speed of such a point at a pose [m/s].
  virtual double speed(const WallPose& pose, const std::array<Vec3, 8>& domain) const { return fastest(pose, corners); }
  /// Distance of the farthest of the shape's own points from the motion's axis of rotation [m]; k_never: no bound.
  virtual double arm(const WallMotion& motion) const = 0;
  virtual std::size_t bytes() const noexcept { return 0; }
  /// An element as bodies that are no spheres meet it, in the wall's own frame: kind and measures of a WallPiece.
  virtual WallPiece piece(std::int32_t) const { return {}; }

  std::int32_t elements = 1;
  double slack = 0;                ///< vertices lie this near to their facet's plane [m]
  std::array<Vec3, 8> corners{};   ///< box around the elements; of what has no bounds one of its points
  bool bounded = true;             ///< it can have images across periodic sides
  bool facets = false;             ///< elements share edges: a contact may lead from one to the next
  std::optional<MeshReport> mesh;  ///< of a file
};

/// What a shape is made from.
struct ShapeRequest {
  const Scene& scene;
  const WallSpec& spec;
  double max_reach, usual_reach;  ///< as WallSet's [m]
  double largest_diameter;        ///< of grains to come [m]; 0: unknown
};

/// The two sides of a shape: how far x is from the surface, negative on one of them, and 0 where it lies on neither,
/// beyond an end [m]; what the negative and the other side are called.
struct ShapeSides {
  double (*of)(const WallSpec&, Vec3 x) = nullptr;
  const char *negative = "", *positive = "";
};

/// The line of a shape: its word, what its measures must be, how it is made, what it encloses, which side of it is
/// which, and how far it keeps from the domain.
struct ShapeKind {
  WallShape shape;
  void (*check)(const WallSpec&);  ///< Error{scene}
  std::unique_ptr<const Shape> (*make)(const ShapeRequest&);
  /// Facets that may enclose space; nullptr: the shape never does. Nothing where a surface has holes.
  std::optional<Mesh> (*enclosing)(const Scene&, const WallSpec&) = nullptr;
  ShapeSides sides = {};
  /// At rest, along axes that are not periodic; 0 where it reaches into the domain [m]. nullptr: not known.
  double (*away)(const Domain&, const WallSpec&) = nullptr;
};
const ShapeKind& shape_kind(WallShape shape);

// The kinds, a file each.
extern const ShapeKind k_plane_shape, k_cylinder_shape, k_cone_shape, k_box_shape, k_mesh_shape;

/// Error{scene} that names the wall unless ok.
void require_of_wall(bool ok, const WallSpec& wall, const std::string& what, const std::string& cure);
std::array<Vec3, 8> box_corners(Vec3 lower, Vec3 upper);
/// ShapeKind::away of what lies within a box.
double away_from(const Domain& domain, Vec3 lower, Vec3 upper);

}  // namespace talus
