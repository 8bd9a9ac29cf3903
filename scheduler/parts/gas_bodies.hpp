// Grains as the gas sees them: spheres, and bodies that are no spheres by their volume, surface and sphericity. Who
// uses it: gas. Invariant: a body that is a ball is what a sphere is, with the same operations.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/gas/drag.hpp"
#include "core/gas/grid.hpp"
#include "core/scene/scene.hpp"
#include "scheduler/state/rows.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

/// A sphere, or the body that a row leads.
struct GasGrain {
  double diameter;              ///< of the sphere of its volume [m]
  const gas::DragShape* shape;  ///< its surface is that of this sphere over the sphericity
};

class GasGrains {
 public:
  explicit GasGrains(const Scene& scene);
  GasGrain of(const Rows& rows, Row i) const;
  GasGrain of(const Source& s, double diameter) const;  ///< of its grains of this size
  /// Cells and volumes in them of the grain that row i leads: a clump's by its spheres, a superquadric's by the
  /// ellipsoid along the axes of the grid that reaches as far, both scaled to the body's volume. So no cell beyond a
  /// wall gets what the body does not put there.
  void share(const Rules& rules, const Rows& rows, const gas::Grid& grid, Row i,
             std::vector<std::pair<int, double>>& parts) const;
  std::vector<std::string> advice() const;  ///< lines of `talus check`

 private:
  /// Of scale 1.
  struct Kind {
    gas::DragShape drag;
    bool ball = false;  ///< one sphere
    double fill = 1;    ///< of a clump: its volume over those of its spheres
  };
  static void share_clump(const Rules& rules, const Rows& rows, const gas::Grid& grid, Row i, double fill,
                          std::vector<std::pair<int, double>>& parts);
  static void share_superquadric(const Rules& rules, const Rows& rows, const gas::Grid& grid, Row i,
                                 std::vector<std::pair<int, double>>& parts);

  const Scene& scene_;
  gas::DragShape sphere_;
  std::vector<Kind> kinds_;  ///< by shape of the scene; none without bodies
};

/// From the centre of body b to its first sphere [m].
Vec3 arm_of_first(const Rules& rules, const Bodies& bodies, std::int32_t b);

}  // namespace talus
