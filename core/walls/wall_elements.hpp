// Wall elements: infinite plane, lateral surface of revolution, triangle; the exact closest point of each to a centre.
// Who calls it: core/walls/walls.cpp (contacts, candidates) and core/walls/facet_grid.cpp (pruning).
// Invariants: I4 (+ - * / sqrt only); a normal is always finite and of unit length, also for a centre on the surface or
// on the axis; the distance to a face is measured along the stored unit normal, so that coplanar facets, which share
// their plane, agree to the bit.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/types.hpp"

namespace talus {

/// Part of an element that holds the closest point, in the order of precedence.
enum class Feature : std::uint8_t { face = 0, edge = 1, vertex = 2 };

/// Closest point of one element: it lies at centre - distance * normal.
struct ElementHit {
  Vec3 normal;          ///< unit, from the element to the centre
  double distance = 0;  ///< [m], >= 0
  Feature feature = Feature::face;
};

struct PlaneElement {
  Vec3 point, normal;  ///< [m], unit
};

/// Segment (radius_start, 0)-(radius_end, length) in the (rho, z) half plane, turned about the axis: cylinder, cone,
/// and for length 0 an annulus or a disc.
struct FrustumElement {
  Vec3 base, axis, side;  ///< [m]; unit axis; fixed unit vector across it (the azimuth of a centre on the axis)
  double radius_start = 0, radius_end = 0, length = 0;  ///< [m]
  double normal_rho = 1, normal_z = 0;                  ///< unit normal of the segment; outwards for a cylinder
};

/// `point` and `normal` describe the plane that the facet shares with its coplanar neighbours; the vertices run
/// counter-clockwise about that normal.
struct TriangleElement {
  Vec3 point, normal;  ///< [m], unit
  /// Ball around the vertices [m]: a point farther from it than a limit is farther from the facet, too. Single
  /// precision: what decides about most candidates is one cache line.
  std::array<float, 3> ball_centre{};
  float ball_radius = 0;
  std::array<Vec3, 3> v;  ///< [m]
};

/// a / |a|; the zero vector is returned unchanged.
Vec3 unit(Vec3 a) noexcept;
/// Some unit vector at right angles to the unit vector n; a function of n alone.
Vec3 any_perpendicular(Vec3 n) noexcept;

/// Elements with normalised directions; the caller has checked that they are not zero.
PlaneElement make_plane(Vec3 point, Vec3 normal) noexcept;
FrustumElement make_frustum(Vec3 base, Vec3 axis, double length, double radius_start, double radius_end) noexcept;
/// Triangle with its own plane; the normal comes from the best conditioned corner.
TriangleElement make_triangle(Vec3 a, Vec3 b, Vec3 c) noexcept;

ElementHit closest(const PlaneElement& plane, Vec3 c) noexcept;
ElementHit closest(const FrustumElement& frustum, Vec3 c) noexcept;
ElementHit closest(const TriangleElement& triangle, Vec3 c) noexcept;
/// The same hit, or false (hit unspecified) where it is plain that the distance is not below `limit` [m]; a true answer
/// may still exceed the limit. Most candidates of a skin do not touch: they leave before any division.
bool closest_within(const TriangleElement& triangle, Vec3 c, double limit, ElementHit& hit) noexcept;

/// Signed distance of c to the facet's plane [m]; up to the coplanarity tolerance a lower bound of |closest distance|.
inline double plane_distance(const TriangleElement& t, Vec3 c) noexcept { return dot(c - t.point, t.normal); }

}  // namespace talus
