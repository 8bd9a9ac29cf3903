// Contact of a superquadric with walls: plane, triangle, lateral surface of a cylinder or cone. Who calls it: wall
// contacts of bodies. Invariants: I4; overlaps are those of pair_contact.hpp with the wall as the partner.
#pragma once

#include "core/shapes/pair_contact.hpp"

namespace talus::shapes {

/// Normal from the body into the wall; overlap < 0: apart by at least so much [m]. The point is midway between the
/// body's surface and the wall.
struct WallContact {
  Vec3 normal;
  double overlap = 0;
  Vec3 point;
};

/// Half space behind the plane through `on` with the unit normal out of the wall. Closed form: the support function.
WallContact plane_contact(const Body& body, Vec3 on, Vec3 out) noexcept;

/// Edge from a to b, solved from the line of centres. The order of the ends is the caller's: facets that share an edge
/// find the same bits where it is the same.
WallContact edge_contact(const Body& body, Vec3 a, Vec3 b, PairCount& count) noexcept;

/// Both sides of a triangle count: the side on which the body's centre lies. The overlap is that of the deepest point
/// of the triangle: the largest, over the points of the facet, of the least distance that frees them. Memories: one per
/// edge.
WallContact triangle_contact(const Body& body, const Vec3 (&corner)[3], PairMemory (&memory)[3],
                             PairCount& count) noexcept;

/// `c`: of the plane of a facet, whose foot lies in the facet. False: the body meets the facet nowhere, or is freed
/// from it by a shorter way over an edge: its deepest point hangs beyond a rim that the body does not reach.
bool freed_by_face(const Body& body, const Vec3 (&corner)[3], const WallContact& c, PairCount& count) noexcept;

/// Lateral surface of a cylinder or cone: its outward normals are n(phi) = cosine radial(phi) + sine axis, and it is
/// where n . (x - apex) = reach. Cylinder: cosine 1, sine 0, reach its radius. A cone of half angle alpha that opens
/// along the axis: cosine = cos alpha, sine = - sin alpha, reach 0.
struct ConeWall {
  Vec3 apex, axis;                         ///< a point of the axis; unit
  double cosine = 1, sine = 0, reach = 0;  ///< reach [m]
};
/// Places where the body reaches farthest through the wall from inside, deepest first: a long body touches in two.
/// Returns their number; contacts have overlap > 0. Local maxima over the turn about the axis, from 48 directions,
/// refined to 1e-12.
int cone_contacts_inside(const Body& body, const ConeWall& wall, WallContact (&contact)[2]) noexcept;
/// From outside of a cylinder (sine 0): the least over the turn of h + reach - distance.
WallContact cylinder_contact_outside(const Body& body, const ConeWall& wall) noexcept;

}  // namespace talus::shapes
