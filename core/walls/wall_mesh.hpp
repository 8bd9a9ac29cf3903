// Facets of a mesh wall with the planes they share. Who calls it: core/walls/walls.cpp.
// Invariant: facets that are coplanar to the rounding of their own vertices and connected through edges carry one and
// the same plane, so that a particle crossing from one to the next sees the same normal and distance to the bit, and a
// needle facet does not take its normal from the rounding of its vertices.
#pragma once

#include <span>
#include <vector>

#include "core/meshes/mesh_file.hpp"
#include "core/walls/wall_elements.hpp"

namespace talus {

/// How far some vertex lies off the plane that its facet shares, with the rounding of a distance [m].
double flatness(std::span<const TriangleElement> facets);

/// One element per facet, in mesh order. Planes are taken from the largest facet of each coplanar patch.
std::vector<TriangleElement> make_facets(const Mesh& mesh);

/// Closed surface of an axis-aligned box: 8 points, 12 facets with outward winding.
Mesh box_mesh(Vec3 lower, Vec3 upper);

}  // namespace talus
