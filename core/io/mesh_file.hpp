// Triangle meshes from STL, OBJ and PLY files, checked before anything else sees them.
// Who calls it: core/walls.cpp, `talus check`. Invariants: the only unit that includes assimp; vertices that coincide
// are one vertex; no facet of a returned mesh is degenerate or occurs twice; the order is that of the file.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace talus {

/// What was found in a mesh file. Counts are facets after polygons were cut into triangles.
struct MeshReport {
  std::string file;
  std::int64_t facets_read = 0;
  std::int64_t degenerate = 0;    ///< dropped: lower than the file's coordinate rounding
  std::int64_t duplicate = 0;     ///< dropped: same three vertices as an earlier facet
  std::int64_t open_edges = 0;    ///< edges with one facet
  std::int64_t forked_edges = 0;  ///< edges with more than two facets
  std::int64_t flipped = 0;  ///< facets to turn for one winding per connected part (harmless: contact is two-sided)
  bool watertight = false;   ///< every edge has exactly two facets
  Vec3 lower, upper;         ///< bounding box after scale and shift [m]
  double rounding = 0;       ///< one unit in the last place of the largest coordinate as read [m]
};

struct Mesh {
  std::vector<Vec3> points;                         ///< [m]
  std::vector<std::array<std::int32_t, 3>> facets;  ///< indices into points
  MeshReport report;
};

/// One use of an edge by a facet; `from` < `to` are point indices.
struct EdgeUse {
  std::int32_t from = 0, to = 0, facet = 0;
  bool reversed = false;  ///< the facet's winding runs to -> from
};

/// All edge uses, sorted by (from, to, facet), so that the facets around an edge are neighbours in the list.
std::vector<EdgeUse> sorted_edges(std::span<const std::array<std::int32_t, 3>> facets);

/// Joins equal vertices, drops degenerate and duplicate facets, fills the report. `mesh.report.file` and
/// `mesh.report.rounding` are set by the caller. `largest_diameter` [m] of the particles; 0: unknown, no size check.
/// Errors: Error{scene} naming file and facet (counted from 1): no facets, index out of range, non-finite vertex, more
/// than half of the facets degenerate, mesh smaller than the largest particle.
void check_mesh(Mesh& mesh, double largest_diameter);

/// Reads a file and returns it as point = scale * file + shift [m], checked by check_mesh.
/// Errors: as check_mesh, and Error{scene} for an unknown extension and for a missing, empty or unreadable file.
Mesh read_mesh(const std::string& path, double scale, Vec3 shift, double largest_diameter);

}  // namespace talus
