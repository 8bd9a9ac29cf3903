// See jump.hpp.
#include "core/walls/shapes/jump.hpp"

#include <algorithm>
#include <array>

#include "core/walls/shapes/shape.hpp"
#include "core/walls/wall_motion.hpp"

namespace talus {
namespace {

bool same(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

bool same_motion(const WallMotion& a, const WallMotion& b) {
  return same(a.velocity, b.velocity) && same(a.rotation_axis, b.rotation_axis) && a.rotation_rate == b.rotation_rate &&
         same(a.rotation_origin, b.rotation_origin) && same(a.amplitude, b.amplitude) && a.frequency == b.frequency &&
         a.phase == b.phase && a.start == b.start && a.end == b.end;
}

}  // namespace

WallJump largest_jump(const Scene& before, const Scene& after, std::int64_t step) {
  const auto old_of = [&](const WallSpec& w) {
    return std::find_if(before.walls.begin(), before.walls.end(),
                        [&](const WallSpec& o) { return o.name == w.name && o.shape == w.shape; });
  };
  const auto moved = [&](const WallSpec& w) {
    const auto old = old_of(w);
    return old != before.walls.end() && !same_motion(old->motion, w.motion);
  };
  WallJump jump;
  if (std::none_of(after.walls.begin(), after.walls.end(), moved)) return jump;
  const double size = norm(after.domain.upper - after.domain.lower);
  const std::array<Vec3, 8> domain = box_corners(after.domain.lower, after.domain.upper);
  for (const WallSpec& w : after.walls) {
    if (!moved(w)) continue;
    const auto shape = shape_kind(w.shape).make({after, w, size, size, 0});
    const double d = shape->travelled(pose_at(old_of(w)->motion, w.appear, w.vanish, step, after.dt),
                                      pose_at(w.motion, w.appear, w.vanish, step, after.dt), domain);
    if (d > jump.distance) jump = {w.name, d};
  }
  return jump;
}

}  // namespace talus
