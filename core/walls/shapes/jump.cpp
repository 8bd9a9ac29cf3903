// See jump.hpp.
#include "core/walls/shapes/jump.hpp"

#include <algorithm>
#include <vector>

#include "core/base/det_math.hpp"
#include "core/walls/wall_elements.hpp"
#include "core/walls/wall_motion.hpp"
#include "core/walls/walls.hpp"

namespace talus {
namespace {

bool same(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

bool same_motion(const WallMotion& a, const WallMotion& b) {
  return same(a.velocity, b.velocity) && same(a.rotation_axis, b.rotation_axis) && a.rotation_rate == b.rotation_rate &&
         same(a.rotation_origin, b.rotation_origin) && same(a.amplitude, b.amplitude) && a.frequency == b.frequency &&
         a.phase == b.phase && a.start == b.start && a.end == b.end;
}

/// `size`: of what a turning plane is as wide as [m].
double distance(const WallSpec& w, const WallPose& old, const WallPose& now, const std::vector<WallSurface>& surfaces,
                double size) {
  double most = 0;
  const auto add = [&](Vec3 body) { most = fmax2(most, norm(to_world(now, body) - to_world(old, body))); };
  switch (w.shape) {
    case WallShape::plane: {
      const Vec3 before = direction_to_world(old, unit(w.normal)), after = direction_to_world(now, unit(w.normal));
      return __builtin_fabs(dot(to_world(now, w.point) - to_world(old, w.point), before)) + size * norm(after - before);
    }
    case WallShape::cylinder:
    case WallShape::cone:
      add(w.point);
      add(w.point + w.length * unit(w.axis));
      return most;
    default:
      for (const WallSurface& s : surfaces)
        for (const Vec3 x : s.points)
          if (s.name == w.name) add(to_body(now, x));
      return most;
  }
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
  WallSet walls(after, size);
  walls.set_step(step, after.dt);
  const std::vector<WallSurface> surfaces = walls.surfaces();
  for (const WallSpec& w : after.walls) {
    if (!moved(w)) continue;
    const double d = distance(w, pose_at(old_of(w)->motion, w.appear, w.vanish, step, after.dt),
                              pose_at(w.motion, w.appear, w.vanish, step, after.dt), surfaces, size);
    if (d > jump.distance) jump = {w.name, d};
  }
  return jump;
}

}  // namespace talus
