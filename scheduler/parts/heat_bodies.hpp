// Heat of bodies that are no spheres: one temperature per body, which all its rows show; its first row keeps enthalpy
// and flows of all. Contacts are those of its rows, gas and enclosure see the surface of the body. Who uses it: heat.
// Invariants: I3 (flows of a body are summed in row order), the same bits from both owners of a pair.
#pragma once

#include <optional>
#include <vector>

#include "scheduler/part.hpp"

namespace talus {

/// [m2] of each shape of the scene, at scale 1.
std::vector<double> areas_of_shapes(const Scene& scene);

/// A superquadric that is no ball. For all other rows the sphere is the surface.
const BodyShape* shaped_body(const PartView& w, Row i);

/// Rows of the grain that row i leads, [i, end).
Row end_of_grain(const PartView& w, Row i);
bool same_body(const PartView& w, Row i, Row j);

/// Of the sphere, or of the sphere of the body's volume [m].
double heat_size(const PartView& w, Row i);

/// Radius that a contact with the outer unit normal n has at row i, as the law sees it [m].
double contact_radius(const PartView& w, Row i, Vec3 n);

/// Contact of two rows of which one is a superquadric: overlap, and the normal from i to j.
struct ShapedMeeting {
  double overlap = 0;  ///< [m]
  Vec3 normal;
};
/// Slot `q` of the chunk's contacts in the step that ends; nothing where both are spheres.
std::optional<ShapedMeeting> shaped_contact(const PartView& w, const Chunk& c, std::int64_t q);
/// The same of any two rows, solved anew.
std::optional<ShapedMeeting> shaped_contact(const PartView& w, Row i, Row j);

}  // namespace talus
