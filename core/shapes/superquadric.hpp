// The superquadric (|x/a|^n2 + |y/b|^n2)^(n1/n2) + |z/c|^n1 = 1: mass properties, sizes, inside and outside.
// Who calls it: contacts (pair_contact.hpp, wall_contact.hpp), set-up of shapes. Invariants: I4; functions of the shape
// alone.
#pragma once

#include "core/base/types.hpp"
#include "core/shapes/support.hpp"

namespace talus::shapes {

inline constexpr double k_exponent_least = 2, k_exponent_most = 20, k_aspect_most = 100;

struct Superquadric {
  Vec3 axes{1, 1, 1};     ///< semi-axes a, b, c [m]
  double n1 = 2, n2 = 2;  ///< exponents: n1 along z, n2 in the plane of x and y; 2 to 20
};

/// Error{scene} naming `where`: semi-axes not positive and finite, or too different; exponents outside 2 ... 20.
void check(const Superquadric& s, const char* where);

/// [m3]; Beta functions, within 1e-13 relative (Jaklic, Leonardis, Solina 2000).
double volume(const Superquadric& s);
/// Principal moments about the centre for a density of 1 [m5], within 1e-13 relative.
Vec3 inertia(const Superquadric& s);
/// Largest distance of the surface from the centre [m]; closed form (Hoelder).
double bounding_radius(const Superquadric& s);
/// Smallest principal radius of curvature of the surface [m], from below, within 15 %. Overlaps that are not deeper
/// than the sum over both partners have one minimum (Blaschke's rolling theorem).
double smallest_radius(const Superquadric& s);

/// F(x) of a point in the body's frame [-]: negative inside, 0 on the surface. Error below 1e-14 (F + 1).
double inside_outside(const Superquadric& s, Vec3 x) noexcept;

/// What contacts need of the shape.
DualForm<Plain> dual_form(const Superquadric& s) noexcept;

/// Support point of unit direction m (body frame) on the body as contacts see it (rounded by k_eta).
struct SupportPoint {
  double h = 0;  ///< [m]
  Vec3 point;    ///< [m]
};
SupportPoint support_point(const Superquadric& s, Vec3 m) noexcept;

/// Principal radii of curvature where the outer normal is m, smaller first [m].
struct Radii {
  double small = 0, large = 0;
};
Radii radii_of_curvature(const Superquadric& s, Vec3 m) noexcept;

/// Radius for Hertz [m]: the geometric mean of the principal radii (that of the Gaussian curvature). Beyond `flat` it
/// rises ever more slowly to at most 5 `flat`, once continuously differentiable, so that a flat face has a finite
/// stiffness; up to `flat` it is the mean itself. `flat`: 2 times the radius of the sphere of equal volume does well.
double hertz_radius(Radii r, double flat) noexcept;

}  // namespace talus::shapes
