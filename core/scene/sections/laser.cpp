// [[laser]]: keys of the part in scheduler/parts/laser.cpp.
#include "core/scene/sections/parts.hpp"

namespace talus {
namespace {

constexpr std::string_view k_with = "[heat]\ntemperature = 300\ncapacity = 800\nconductivity = 1\n";
constexpr std::string_view k_speed = "speed = 0.02";
constexpr double k_least_rays = 4, k_most_rays = 1000;

const Keys<Laser> k_laser(
    {"laser", true,
     "a beam from above, along -z, that heats the grains it meets; needs [heat]. Its power is shared among rays, and a "
     "ray ends at the first grain below it: others lie in the shade. Walls do not stop it. The series gain "
     "laser.power, "
     "laser.emitted = laser.absorbed + laser.reflected + laser.passed (past all grains)"},
    k_acts,
    {
        key("power", &Laser::power, "W", k_not_negative, "of the beam while it is on", "100")
            .required()
            .with(k_with)
            .beside(k_speed),
        key("radius", &Laser::radius, "m", k_size,
            "at which the intensity is 1/e2 of that on the axis: 2 P/(pi w2) exp(-2 r2/w2). Rays fill a square of four "
            "radii; the 1e-4 of the power that lies beyond is shared among them",
            "5e-5")
            .required()
            .with(k_with)
            .beside(k_speed),
        key("absorptivity", &Laser::absorptivity, "-", {0, 1},
            "share that a grain takes of the rays that meet it; the rest is lost. That of a bed is higher than that of "
            "a surface, since grains reflect onto each other",
            "0.6")
            .required()
            .with(k_with)
            .beside(k_speed),
        key("x", &Laser::x, "m", k_coordinate, "of the way points of its axis", "[0.001, 0.003]")
            .required()
            .with(k_with)
            .beside(k_speed),
        key("y", &Laser::y, "m", k_coordinate, "of the way points, as many as of x", "[0, 0]")
            .required()
            .with(k_with)
            .beside(k_speed),
        key("speed", &Laser::speed, "m/s", k_positive, "along straight lines between them; needed where there are two",
            "0.02")
            .absent("(it stands)")
            .with(k_with),
        key("start", &Laser::start, "s", k_not_negative, "it is switched on and leaves the first way point", "0.01")
            .with(k_with)
            .beside(k_speed),
        key("stop", &Laser::stop, "s", k_positive, "it is switched off, if its way has not ended before", "0.02")
            .absent("(at the last way point; one that stands: never)")
            .with(k_with)
            .beside(k_speed),
        key("rays", &Laser::rays, "-", {k_least_rays, k_most_rays},
            "along each side of their square: 12 times radius over grain radius is fine enough", "48")
            .with(k_with)
            .beside(k_speed),
    });

constexpr double k_most_travel = 0.5;  // of the radius, per heat step

double way_of(const Laser& l) {
  double way = 0;
  for (std::size_t k = 1; k < l.x.size(); ++k)
    way += __builtin_fabs(l.x[k] - l.x[k - 1]) + __builtin_fabs(l.y[k] - l.y[k - 1]);
  return way;
}

void read_laser(const SceneTable& r, Scene& scene) {
  Laser l;
  l.stop = k_never;
  k_laser.read(r, l);
  if (l.x.empty()) r.fail("x", "needs one way point or more");
  if (l.y.size() != l.x.size()) r.fail("y", fmt::format("must have as many numbers as x, {}", l.x.size()));
  if (l.x.size() > 1 && !r.has("speed")) r.missing("speed", "since there are several way points");
  if (l.x.size() == 1 && r.has("speed")) r.fail("speed", "has no effect with one way point");
  if (l.x.size() > 1 && way_of(l) == 0)
    r.fail("x", "all way points are one place: the way ends where it begins, give one point");
  if (!(l.stop > l.start)) r.fail("stop", "must be later than start");
  const double travel = l.speed * scene.dt * static_cast<double>(scene.heat.every);
  const double most = k_most_travel * l.radius / (l.speed * scene.dt), steps = __builtin_floor(most);
  if (travel > k_most_travel * l.radius)
    r.fail("speed", fmt::format("moves the beam by {:.2g} of its radius per heat step, {} at most: {}",
                                travel / l.radius, k_most_travel,
                                steps >= 1 ? fmt::format("heat.every = {:.0f}", steps)
                                           : fmt::format("heat.every = 1 and time.step = {:.3g}", most * scene.dt)));
  const Vec3 size = scene.domain.upper - scene.domain.lower;
  for (int k = 0; k < 2; ++k)
    if (scene.domain.periodic(k) && 4 * l.radius > size[k])
      r.fail("radius", "must not exceed a quarter of a periodic side: the beam would meet itself");
  scene.heat.lasers.push_back(l);
}

void read(const SceneTable& root, Scene& scene) {
  for (const SceneTable& r : root.sections("laser")) {
    if (!scene.heat.on) root.fail("laser", "has no effect without a [heat] section");
    read_laser(r, scene);
  }
}

}  // namespace

const PartSections& laser_sections() {
  static const PartSections all{{&k_laser}, read};
  return all;
}

}  // namespace talus
