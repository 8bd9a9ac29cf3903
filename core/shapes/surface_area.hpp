// Surface areas of bodies that are no spheres: what gas and radiation see of them. Who calls it: parts that exchange
// heat. Invariants: I4; functions of the shape alone.
#pragma once

#include <span>

#include "core/shapes/clump.hpp"
#include "core/shapes/superquadric.hpp"

namespace talus::shapes {

/// Of the union of spheres [m2], within 1e-4 relative: what each sphere shows is integrated over slices of equal area,
/// the arcs of each slice being exact.
double surface_area(std::span<const SubSphere> spheres);

/// [m2], within 1e-6 relative.
double surface_area(const Superquadric& s);

}  // namespace talus::shapes
