// How much of a body that is no sphere lies in a region or in the cells of a grid. Who calls it: averages. A body is
// cut into rays from centres within it: a superquadric from its own; of a clump each sphere holds the points that are
// deepest in it, so that spheres which overlap count once. Along a ray all is exact: where it leaves the body, the
// cells and the region. Between rays the error is some 1e-3 of a body where a side passes its centre (7e-5 rms over
// all planes). Spheres of a clump that no other overlaps need no rays: their shares are those of spheres. Invariants:
// I4; shares of a body over all cells sum to 1; a body as a whole within counts 1.
#pragma once

#include <array>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/scene/scene.hpp"
#include "core/shapes/quaternion.hpp"

namespace talus {

/// Cells along which a body lies, numbered from the grid's lower corner, also beyond the grid.
struct CellShare {
  std::array<int, 3> at;
  double share;
};

/// A grid, and the cells beyond it that are told apart: what lies further is put into the last of them.
struct ShareGrid {
  Vec3 lower, spacing;  ///< [m]
  std::array<int, 3> least, most;
};

class BodyShares {
 public:
  explicit BodyShares(const Scene& scene);  ///< rays of its shapes; none without bodies

  double volume(const BodyRecord& b) const;  ///< [m3]
  int spheres(const BodyRecord& b) const;    ///< particles of a frame that it is made of
  /// Over all periodic images. Of meshes by points: within some 1 %.
  double inside(const Domain& domain, const Region& region, const BodyRecord& b) const;
  /// A cell may stand there more than once.
  void cells(const ShareGrid& grid, const BodyRecord& b, std::vector<CellShare>& out) const;

 private:
  /// From the centre of its piece in the principal axes at scale 1: t `way` [m] with t from `from` to 1.
  struct Ray {
    Vec3 way;
    double from, share;  ///< share of the body's volume, times t^3
  };
  struct Piece {
    Vec3 centre;           ///< [m]
    double radius, share;  ///< radius of the sphere that holds it [m]; share of the body's volume
    std::vector<Ray> rays;
    bool ball = false;  ///< a whole sphere, without rays
  };
  struct Placed;

  static std::vector<Piece> pieces_of(const BodyShape& shape);
  static Piece superquadric(const BodyShape& shape);
  static Piece part_of_clump(const BodyShape& shape, std::size_t k);
  static double rays_inside(const Domain& domain, const Region& region, const Placed& p);
  static double points_inside(const Domain& domain, const Region& region, const Placed& p);
  static void ray_cells(const ShareGrid& grid, const Placed& p, std::vector<CellShare>& out);
  template <class Visit>
  void each_piece(const BodyRecord& b, Visit visit) const;

  const Scene* scene_;
  std::vector<std::vector<Piece>> kinds_;  ///< by shape of the scene
};

}  // namespace talus
