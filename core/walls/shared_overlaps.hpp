// What a grain that touches several facets overlaps with each, so that neighbouring facets do not push twice.
// Who calls it: core/walls/wall_contacts.cpp, core/shapes/body_walls.cpp. Invariants: I4 (+ - * / sqrt only); rounding
// depends on the order of the touches, so callers hand them over in a fixed order.
//
// Why: where a mesh folds inwards at a shallow angle, a grain meets the second facet first where it already overlaps
// with its plane. Two springs would begin and end there at a finite force: every fold would add or take energy.
//
// How: the places of the grain at which it touches none of a few facets are an intersection of half spaces. Its
// distance is their joint overlap, its direction their joint normal: a potential without jumps. What lies at or behind
// the tangent plane of another touch has no part in it (below half a radius of overlap), so touches come and go without
// a force. A finer mesh of the same surface gives the same force.
#pragma once

#include <limits>
#include <span>

#include "core/base/types.hpp"

namespace talus {

// Facets that meet at a larger angle, without others between them that are touched too, are springs of their own: a
// groove holds a grain in two places. They begin at overlap 0 as long as overlaps stay below 0.15 radii. A grain that
// is pressed from opposite sides, as in a tube that it fills, has a spring at each touch.

/// Cosine (32 degrees): touches of one surface whose normals are nearer than this are one contact. Its spring of
/// friction goes along from facet to facet. Judged without the overlaps, so that a pair of facets or corners never
/// changes sides.
inline constexpr double k_one_contact = 0.85;

struct Touch {
  Vec3 normal;         ///< unit, from the wall to the grain
  double overlap = 0;  ///< [m], > 0
  int surface = 0;
  Vec3 foot;          ///< the wall's point, from some centre [m]
  double radius = 0;  ///< of a sphere that touches an edge or a corner: the feet tell the angle [m]. 0: normals do
  /// Largest radius of curvature of a body that is no sphere [m]: feet farther apart than such a curve turns between
  /// the normals are two contacts, as the two ends of a rod.
  double curve = std::numeric_limits<double>::infinity();
  double share = 0;  ///< out [m], >= 0
  int group = 0;     ///< out: the first touch of the same contact
};

/// Sets shares and groups. With overlaps d and cosines G of the angles between the normals, the joint overlap squared
/// is the largest 2 d.s - s.G s of all shares s >= 0; three of them are enough in space. False, and nothing set, if
/// each touch is a contact of its own with all of its overlap.
bool share_overlaps(std::span<Touch> touches);

/// One contact out of a group.
struct JointContact {
  Vec3 normal;         ///< unit
  double overlap = 0;  ///< [m]; 0: no share
  int bearing = 0;     ///< the touch with the largest share
  int members = 0;     ///< touches that share
};
JointContact joint_contact(std::span<const Touch> touches, int group);

}  // namespace talus
