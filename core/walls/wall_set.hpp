// What a WallSet holds. Who includes it: core/walls/walls.cpp (set-up, motion, surfaces), core/walls/wall_contacts.cpp
// (candidates, contacts) and core/walls/wall_speed.cpp (fastest points) alone.
#pragma once

#include <memory>
#include <vector>

#include "core/walls/shapes/shape.hpp"
#include "core/walls/wall_images.hpp"
#include "core/walls/walls.hpp"

namespace talus {

struct Wall {
  WallSpec spec;
  std::int32_t first = 0, count = 0;  ///< global element ids [first, first + count)
  /// Candidates have the codes [first_code, end_code): first_code + slot of the image * count + element - first.
  std::int32_t first_code = 0, end_code = 0;
  WallImages images;
  std::shared_ptr<const Shape> shape;
  double slack = 0;    ///< of the shape
  double extent = 0;   ///< largest body coordinate, for rounding bounds [m]
  bool moves = false;  ///< at some time
  int surface = 0;     ///< the first wall that it forms one surface with
  WallPose pose, marked;
  double skin = 0;     ///< [m]
  double arm = 0;      ///< largest distance from the axis of rotation of a point that a particle can touch [m]
  double fastest = 0;  ///< of its points, over the whole run [m/s]
};

struct WallSet::Impl {
  std::vector<Wall> walls;
  std::int64_t elements = 0;
  double dt = 0;
  double largest_travel = 0;   ///< largest travelled() since mark() [m]
  std::array<Vec3, 8> domain;  ///< corners of the domain, widened by max_reach
  Vec3 lower, upper;           ///< the domain itself [m]

  Wall build(const Scene& scene, const WallSpec& spec, double max_reach, double usual_reach,
             double largest_diameter) const;
  double travelled(const Wall& w) const;
  double speed(const Wall& w) const;
  void place_images(Wall& w) const;
  int first_of_surface(std::size_t wall) const;
  void judge_speed(const Scene& scene, Wall& w) const;
  double generous(const Wall& w, Vec3 c, double reach) const;
  void list(const Wall& w, Vec3 c, double reach, std::int32_t slot, Vec3 shift, std::vector<std::int32_t>& out,
            std::vector<float>* distance) const;
};

}  // namespace talus
