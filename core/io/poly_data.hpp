// PolyData: points, cells and named columns, the common input of the VTKHDF and .vtp writers. Built from a Frame here,
// so that both formats show the same columns under the same names. Who calls it: core/io/vtkhdf, core/io/vtp, cases/.
// Invariant: which columns exist follows from ParticleColumns alone, so that a frame without particles fits its file.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/frame/frame.hpp"

namespace talus {

struct Scene;

struct PolyColumn {
  std::string name;
  int components = 1;
  std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::int32_t>, std::vector<std::uint8_t>>
      values;  ///< rows * components, row by row
};

struct PolyData {
  std::vector<Vec3> points;                            ///< [m]
  bool vertices = false;                               ///< one vertex cell per point, so that viewers show points
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< polygon cells
  std::vector<PolyColumn> point_data, cell_data;       ///< cell_data: rows follow vertices, then triangles
  std::size_t cells() const noexcept { return (vertices ? points.size() : 0) + triangles.size(); }
};

/// Optional particle columns; id, velocity, radius and diameter are always there.
struct ParticleColumns {
  bool omega = false, material = false, fixed = false, coordination = false, stress = false;
  /// What this scene has: omega with friction, material with several, fixed if groups or files may hold particles,
  /// coordination and stress if asked for.
  static ParticleColumns of(const Scene& scene);
};

/// id, velocity [m/s], radius [m], diameter [m] and the asked columns: omega [rad/s], material, fixed, coordination,
/// stress [Pa] as XX YY ZZ XY YZ XZ (the order in which VTK reads 6 components as a symmetric tensor).
/// Error{io} if the frame lacks an asked column.
PolyData particle_poly(const Frame& frame, const ParticleColumns& columns);
/// Triangles of all walls at their present pose; cell column "wall" = index of the wall.
PolyData wall_poly(const Frame& frame);
/// One point per contact: particle_a, particle_b (-1 - wall for walls), normal_force, tangential_force [N], overlap
/// [m].
PolyData contact_poly(const Frame& frame);

}  // namespace talus
