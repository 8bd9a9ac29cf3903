// Clumps: rigid bodies made of spheres that may overlap. Mass properties are those of the union. Who calls it: set-up
// of shapes, `talus shape`. Invariants: I4; functions of the spheres and their order alone.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/shapes/quaternion.hpp"

namespace talus::shapes {

struct SubSphere {
  Vec3 x;        ///< [m]
  double r = 0;  ///< [m]
};

/// Of a body of density 1.
struct MassProperties {
  double volume = 0;                ///< [m3]
  Vec3 centre;                      ///< [m]
  std::array<double, 6> inertia{};  ///< about the centre: xx, yy, zz, xy, xz, yz (products with their minus sign) [m5]
  double volume_error = 0;          ///< relative; 0: closed form
  double inertia_error = 0;         ///< largest, relative to the largest moment
};

/// Of the union. Closed form where no two spheres overlap and where all centres lie on a line (a body of revolution:
/// the pair, the rod); otherwise a quadrature over columns whose ends are exact, with its error estimated from half as
/// many columns. Error{scene} naming `where`: no sphere, a radius that is not positive, a value that is not finite.
MassProperties union_properties(std::span<const SubSphere> spheres, const std::string& where);

/// Principal moments, ascending [m5], and the turn from the principal axes (right-handed) to the given frame.
struct PrincipalAxes {
  Vec3 moments;
  Quaternion turn;
};
PrincipalAxes principal_axes(const std::array<double, 6>& inertia) noexcept;

/// Radius of the smallest sphere about `centre` that holds all spheres [m].
double clump_radius(std::span<const SubSphere> spheres, Vec3 centre) noexcept;

/// A table of x, y, z, radius in any dialect of particle files. Error{scene} with file and row.
std::vector<SubSphere> read_clump(const std::string& path);

}  // namespace talus::shapes
