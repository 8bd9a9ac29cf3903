// The fastest point of each wall, over a run and in a step: what the time step is judged by. Who calls it:
// core/rules/timestep.cpp, scheduler/nodes/monitor.cpp. Nothing here feeds the trajectory.
#include <cmath>

#include "core/scene/duration.hpp"
#include "core/walls/wall_motion.hpp"
#include "core/walls/wall_set.hpp"

namespace talus {

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
    const double own = w.shape->arm(m);
    w.arm = own == k_never ? reach : everywhere ? own : fmin2(own, reach);
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
