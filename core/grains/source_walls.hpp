// Walls as sources see them: does a sphere reach into one, on which side of a closed one does it lie. Who calls it:
// core/insertion*.cpp, core/grains/source_notes.cpp. Invariants: walls count that act at the step to which the WallSet
// is set, where they then are; I4.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/scene/scene.hpp"
#include "core/shapes/pair_contact.hpp"
#include "core/walls/closed_surface.hpp"
#include "core/walls/walls.hpp"

namespace talus {

/// Walls that enclose a volume: boxes, and meshes without holes.
class ClosedWalls {
 public:
  /// Reads the meshes of the scene. Error{scene} for one that cannot be read.
  explicit ClosedWalls(const Scene& scene);
  /// x lies inside the wall (an index into scene.walls) at its pose in `walls`; false for walls that enclose nothing or
  /// do not act. Periodic images of the wall count.
  bool inside(const WallSet& walls, int wall, Vec3 x) const;
  bool inside_any(const WallSet& walls, Vec3 x) const;
  bool any() const;
  bool closed(int wall) const { return surfaces_[static_cast<std::size_t>(wall)] != nullptr; }
  /// Points all over the surface of a closed wall at its pose [m].
  std::vector<Vec3> points(const WallSet& walls, int wall) const;

 private:
  Domain domain_;
  std::vector<std::unique_ptr<const ClosedSurface>> surfaces_;  ///< in the body frame; nullptr: not closed
};

class SourceWalls {
 public:
  /// `walls`: in the frame of the domain's lower corner, as the engine keeps them; nullptr: there are none.
  SourceWalls(const Domain& domain, const WallSet* walls);

  struct Overlap {
    int wall = -1;
    double depth = 0;  ///< [m]
  };
  /// The deepest overlap of a sphere with a wall, or nothing where none is deeper than `forgiven` [m].
  std::optional<Overlap> deepest(Vec3 x, double r, double forgiven) const;
  /// The same of a superquadric within a sphere of radius `bound` [m].
  std::optional<Overlap> deepest(shapes::Body body, double bound, double forgiven) const;
  /// The sphere keeps clear of every wall, to the rounding of coordinates in mesh files.
  bool clear(Vec3 x, double r) const { return walls_ == nullptr || !deepest(x, r, rounding(r)); }
  double rounding(double r) const noexcept;  ///< overlap that counts as none [m]
  const WallSet* walls() const noexcept { return walls_; }

 private:
  Domain domain_;
  const WallSet* walls_;
  double size_ = 0;  ///< largest coordinate [m]
  mutable std::vector<std::int32_t> near_;
};

}  // namespace talus
