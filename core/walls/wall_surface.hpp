// Triangulated pictures of wall elements for output files and reports. Who calls it: core/walls/walls.cpp (surfaces()).
// Invariant: output only; nothing here feeds the trajectory.
#pragma once

#include <span>

#include "core/walls/wall_elements.hpp"
#include "core/walls/walls.hpp"

namespace talus {

/// Convex polygon plane ∩ box [lower, upper] as a triangle fan; empty where they do not meet.
WallSurface clipped_plane(Vec3 point, Vec3 normal, Vec3 lower, Vec3 upper);
/// Lateral surface with 64 segments around the axis.
WallSurface tessellated(const FrustumElement& frustum);
/// The facets themselves; equal vertices of neighbouring facets are joined.
WallSurface tessellated(std::span<const TriangleElement> facets);

}  // namespace talus
