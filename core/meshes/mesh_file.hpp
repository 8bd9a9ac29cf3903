// Triangle meshes from STL, OBJ and PLY files, in double precision, checked before anything else sees them.
// Who calls it: core/walls/walls.cpp, regions inside a mesh. Invariants: vertices that coincide are one vertex; no
// facet of a returned mesh is degenerate or occurs twice; the order is that of the file.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"

namespace talus {

/// What was found in a mesh file. Counts are facets after polygons were cut into triangles.
struct MeshReport {
  std::string file;
  std::int64_t facets_read = 0;
  std::int64_t degenerate = 0;    ///< dropped: lower than the coordinates are known to
  std::int64_t duplicate = 0;     ///< dropped: same three vertices as an earlier facet
  std::int64_t open_edges = 0;    ///< edges with one facet
  std::int64_t forked_edges = 0;  ///< edges with more than two facets
  std::int64_t holes = 0;         ///< rings of three open edges in larger parts: a facet is missing
  std::int64_t flipped = 0;  ///< facets to turn for one winding per connected part (harmless: contact is two-sided)
  std::int64_t parts = 0;    ///< connected through edges
  std::int64_t welded = 0;   ///< vertices joined to one that differs by no more than the coordinates are known to
  bool watertight = false;   ///< every edge has exactly two facets
  double volume = 0;         ///< enclosed, hollows inside taken off; 0 unless watertight [m3]
  Vec3 lower, upper;         ///< bounding box after scale and shift [m]
  double rounding = 0;       ///< one unit in the last place that the file gives of its largest coordinate [m]
  std::vector<std::string> notes;  ///< oddities of the file that were read over

  std::int64_t dropped() const noexcept { return degenerate + duplicate; }
};

struct Mesh {
  std::vector<Vec3> points;                         ///< [m]
  std::vector<std::array<std::int32_t, 3>> facets;  ///< indices into points
  MeshReport report;
  double unit = 0;  ///< one unit in the last place of a coordinate in the file, relative to it
  Vec3 offset;      ///< where the file's origin lies [m]

  std::int64_t size() const noexcept { return static_cast<std::int64_t>(facets.size()); }
  /// How well the file gives a vertex that lies at p [m].
  double rounding_at(Vec3 p) const noexcept;
};

/// From the coordinates of a file to metres: scale * file + shift - corner, as if rounded once.
struct MeshFrame {
  double scale = 1;
  Vec3 shift;   ///< [m]
  Vec3 corner;  ///< origin of the wanted frame [m]
};

/// One use of an edge by a facet; `from` < `to` are point indices.
struct EdgeUse {
  std::int32_t from = 0, to = 0, facet = 0;
  bool reversed = false;  ///< the facet's winding runs to -> from
};

/// All edge uses, sorted by (from, to, facet), so that the facets around an edge are neighbours in the list.
std::vector<EdgeUse> sorted_edges(std::span<const std::array<std::int32_t, 3>> facets);

/// Joins equal vertices, drops degenerate and duplicate facets, fills the report but for file, rounding and notes.
/// `largest_diameter` [m] of the particles; 0: unknown, no size check.
/// Errors: Error{scene} naming file and facet (counted from 1): no facets, index out of range, vertex not finite or
/// beyond 1e12 m, more than half of the facets degenerate, mesh smaller than the largest particle.
void check_mesh(Mesh& mesh, double largest_diameter);

/// Reads a file into the frame and checks it by check_mesh. The format is that of the extension: stl, obj, ply.
/// Errors: as check_mesh and InputFile, Error{scene} with line or byte for everything that the file lacks or that is
/// not understood.
Mesh read_mesh(const std::string& path, const MeshFrame& frame, double largest_diameter);

/// The same from bytes in memory; `name`, with its extension, stands for the file.
Mesh parse_mesh(std::string_view bytes, const std::string& name, const MeshFrame& frame, double largest_diameter);

/// "12 facets, closed, 0.25 m3, 1 x 1 x 0.25 m" and what is wrong with it, for people.
std::string describe(const MeshReport& report);
/// What makes one doubt the mesh: dropped facets, forked edges, holes, notes, coordinates that are not known to 1e-3 of
/// `smallest_radius` [m] (0: unknown). Empty where nothing does; open edges alone do not.
std::string doubts(const MeshReport& report, double smallest_radius);

}  // namespace talus
