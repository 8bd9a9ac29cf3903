// What lies in a region of space: the one answer for sources, groups and averages. Who calls it: core/insertion*.cpp,
// scheduler/ (events), core/frame/averages.cpp, core/scene/scene_file.cpp. Invariants: I4; on a periodic axis a region
// that reaches beyond the domain continues at the other side.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/scene/scene.hpp"

namespace talus {

/// x lies in the region or on its border; `x` as it is, no periodic images.
bool inside(const Region& region, Vec3 x) noexcept;
/// The same for x and its periodic images.
bool inside(const Domain& domain, const Region& region, Vec3 x) noexcept;

/// The region covers a periodic axis as a whole and closes on itself there: spheres may stick out through its ends.
bool spans(const Domain& domain, const Region& region, int axis) noexcept;

/// A sphere whose centre lies at least r from every side of the box [lower, upper] that the region does not span is in
/// the region as a whole.
bool holds(const Domain& domain, const Region& region, Vec3 x, double r) noexcept;

/// Share of the sphere's volume that lies inside, summed over its periodic images: of cylinders and balls the volume;
/// of boxes the product of one spherical-cap fraction per face, exact where one face cuts the sphere, close at edges and
/// corners; of meshes as if the nearest facet were an endless plane.
double share_inside(const Domain& domain, const Region& region, Vec3 x, double r) noexcept;

double volume(const Region& region) noexcept;  ///< [m3]

/// Sets lower and upper of a cylinder or sphere from its measures; makes the axis a unit vector.
void set_bounds(Region& region) noexcept;

/// Reads the mesh of a region and sets surface and bounds; does nothing for other shapes. `where` names the region in
/// messages. Error{scene} for a broken mesh or one with holes.
void load_region(Region& region, const std::string& directory, const std::string& where);
/// Of all regions of the scene: sources, groups, averages; and the files of its shapes. Error{scene} also where a mesh
/// turns out not to fit into the domain.
void load_regions(Scene& scene);
/// Error{scene} for a region or shape whose file has not been read: a scene that was put together or parsed, but not
/// loaded.
void require_loaded(const Scene& scene);

/// What keeps a region from being used, and the key at which that is said.
struct RegionFault {
  std::string_view key;
  std::string text;
};
/// On a periodic axis a region may be as long as the domain and must have its middle in it, else images would count
/// twice; `within`: on the other axes it must not reach beyond the domain (sources).
std::optional<RegionFault> region_fault(const Domain& domain, const Region& region, bool within);

}  // namespace talus
