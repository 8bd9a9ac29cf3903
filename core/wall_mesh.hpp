// Facets of a mesh wall with the planes they share. Who calls it: core/walls.cpp.
// Invariant: facets that are coplanar to the mesh's own rounding and connected through edges carry one and the same
// plane, so that a particle crossing from one to the next sees the same normal and distance to the bit, and a needle
// facet does not take its normal from the rounding of its vertices.
#pragma once

#include <vector>

#include "core/io/mesh_file.hpp"
#include "core/wall_elements.hpp"

namespace talus {

/// Distance within which vertices count as lying in a plane [m]: twice the coordinate rounding of the mesh.
double coplanarity(const Mesh& mesh);

/// One element per facet, in mesh order. Planes are taken from the largest facet of each coplanar patch.
std::vector<TriangleElement> make_facets(const Mesh& mesh);

/// Closed surface of an axis-aligned box: 8 points, 12 facets with outward winding.
Mesh box_mesh(Vec3 lower, Vec3 upper);

}  // namespace talus
