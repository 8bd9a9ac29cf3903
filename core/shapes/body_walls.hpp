// Contacts of a superquadric with the walls near it, reduced as those of a sphere are. Who calls it: wall_contact node.
// Invariants: I3 (ordered by wall and element), I4; a function of the body and the walls' poses alone.
#pragma once

#include <span>
#include <vector>

#include "core/shapes/pair_contact.hpp"
#include "core/walls/walls.hpp"

namespace talus::shapes {

/// contact: normal from the wall to the body; distance = bound - overlap, so that the law's bound - distance is the
/// overlap; velocity of the wall at the contact point. arm: from the body's centre to the wall's point, as of spheres
/// [m].
struct BodyWallContact {
  talus::WallContact contact;
  Vec3 arm;
};

/// `bound`: radius of the sphere that holds the body [m]. Appends at most WallSet::k_max_contacts contacts with an
/// overlap > 0; more is Error{physics}. Faces before edges, deeper before shallower; one at or behind the tangent plane
/// of an accepted contact belongs to the same surface, and so does an edge that lies in a facet which is met deeper
/// elsewhere.
void body_wall_contacts(const Body& body, double bound, const WallSet& walls, std::span<const std::int32_t> candidates,
                        const WallSet::Wraps& wraps, std::vector<BodyWallContact>& out);

}  // namespace talus::shapes
