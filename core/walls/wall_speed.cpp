// The fastest point of each wall, over a run and in a step: what the time step is judged by. Who calls it:
// core/rules/timestep.cpp, scheduler/nodes/monitor.cpp. Nothing here feeds the trajectory.
#include <cmath>

#include "core/base/det_math.hpp"
#include "core/grains/population.hpp"
#include "core/walls/wall_motion.hpp"
#include "core/walls/wall_set.hpp"

namespace talus {
namespace {

/// Points of both ends of a surface of revolution, 360 on each, outside by what lies between them.
std::vector<Vec3> rims(const FrustumElement& f) {
  std::vector<Vec3> points;
  const Vec3 other = cross(f.axis, f.side);
  for (int end = 0; end < 2; ++end) {
    const Vec3 centre = f.base + (end * f.length) * f.axis;
    const double r = (end == 0 ? f.radius_start : f.radius_end) * 1.00004;  // 1 / cos(1/2 degree)
    for (int k = 0; k < 360; ++k) {
      const auto [s, c] = det::sincos_turns(k / 360.0);
      points.push_back(centre + (r * c) * f.side + (r * s) * other);
    }
  }
  return points;
}

/// Distance from the axis of rotation of the farthest of the wall's own points [m].
double own_arm(const Wall& w) {
  const WallMotion& m = w.spec.motion;
  if (const auto* f = std::get_if<FrustumElement>(&w.shape))
    return farthest_from_axis(m.rotation_origin, m.rotation_axis, rims(*f));
  double arm = 0;
  for (const TriangleElement& t : std::get<FacetMesh>(w.shape).facets)
    arm = fmax2(arm, farthest_from_axis(m.rotation_origin, m.rotation_axis, t.v));
  return arm;
}

}  // namespace

/// A plane is as large as the domain. What else lies outside the domain touches nothing, unless an image of it does.
void WallSet::Impl::judge_speed(const Scene& scene, Wall& w) const {
  const WallMotion& m = w.spec.motion;
  const MovingTime time = moving_time(m, w.spec.appear, w.spec.vanish, end_of(scene));
  if (m.rotation_rate != 0) {
    // the axis moves along with the wall
    const double path = norm(m.amplitude) + norm(m.velocity) * (time.to < k_never ? fmax2(0, time.to - m.start) : 0);
    const double reach = farthest_from_axis(m.rotation_origin, m.rotation_axis, domain) + path;
    bool everywhere = norm2(m.velocity) > 0 && time.to == k_never;
    for (int k = 0; k < 3; ++k) everywhere = everywhere || scene.domain.periodic(k);
    if (std::holds_alternative<PlaneElement>(w.shape))
      w.arm = reach;
    else
      w.arm = everywhere ? own_arm(w) : fmin2(own_arm(w), reach);
  }
  w.fastest = time.any() ? peak_speed(m, w.arm) : 0;
}

double WallSet::fastest_point(int wall) const { return impl_->walls.at(wall).fastest; }

WallSet::StepTravel WallSet::step_travel() const {
  StepTravel t;
  for (int k = 0; k < size(); ++k) {
    const Wall& w = impl_->walls[k];
    if (!w.pose.moving || !w.pose.active) continue;
    const double distance = impl_->dt * peak_speed(w.pose.velocity, w.pose.omega, w.arm);
    if (distance > t.distance) t = {distance, k};
  }
  return t;
}

}  // namespace talus
