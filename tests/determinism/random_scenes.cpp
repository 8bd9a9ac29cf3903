// Random scenes. Stiffness and time step follow from the speed, so that the fastest grains cross a few percent of a
// radius per step and overlap little; slower sources and gravity spread the speeds within each scene.
#include "tests/determinism/random_scenes.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/rng.hpp"
#include "kernels/kernel_table.hpp"
#include "tests/determinism/scenes.hpp"

namespace talus::determinism {
namespace {

constexpr double k_largest = 2e-3;  ///< diameter [m]

/// Sequential draws of one scene.
class Draw {
 public:
  Draw(std::uint64_t stream, int index) : rng_(20240601, stream, static_cast<std::uint64_t>(index)) {}
  double real(double low, double high) { return rng_.uniform(n_++, low, high); }
  bool chance(double p) { return real(0, 1) < p; }
  int below(int n) { return static_cast<int>(rng_.bits(n_++) % static_cast<std::uint64_t>(n)); }
  Vec3 direction() {
    Vec3 d{real(-1, 1), real(-1, 1), real(-1, 1)};
    return (1 / fmax2(norm(d), 0.1)) * d;
  }

 private:
  CounterRng rng_;
  std::uint64_t n_ = 0;
};

void add_motion(WallSpec& w, Draw& draw, Vec3 centre, double size, double speed, double duration) {
  WallMotion& m = w.motion;
  const double wall_speed = speed * std::pow(10, draw.real(-2, 0));
  switch (draw.below(4)) {
    case 0:
      break;  // fixed
    case 1:
      m.velocity = wall_speed * draw.direction();
      break;
    case 2:
      m.rotation_axis = draw.direction();
      m.rotation_origin = centre;
      m.rotation_rate = wall_speed / size;
      break;
    default:
      m.amplitude = draw.real(0.05, 0.4) * k_largest * draw.direction();
      m.frequency = wall_speed / (6.3 * norm(m.amplitude));
      m.phase = draw.real(0, 1);
  }
  if (draw.chance(0.4)) m.start = draw.real(0, 0.5) * duration;
  if (draw.chance(0.3)) m.end = draw.real(0.5, 1) * duration;
  if (draw.chance(0.15)) w.vanish = draw.real(0.3, 0.9) * duration;
}

/// Makes a plane its own image along all periodic axes: a box where there are three of them.
void fit_plane(WallSpec& w, const Domain& d, Vec3 centre, double half) {
  int open = -1, periodic = 0;
  for (int k = 0; k < 3; ++k)
    if (d.periodic(k)) {
      w.normal[k] = 0;
      w.motion.rotation_axis = Vec3{};
      w.motion.rotation_axis[k] = 1;
      ++periodic;
    } else {
      open = k;
    }
  if (periodic > 1) w.motion.rotation_rate = 0;
  if (open < 0) {
    w.shape = WallShape::box;
    w.lower = centre - Vec3{half, half, half};
    w.upper = centre + Vec3{half, half, half};
  } else if (d.periodic(2)) {
    w.normal[open] = 1;  // through the lower corner, where the domain ends
    w.point[open] = d.lower[open];
  }
}

/// Moves a wall along the periodic axes: it crosses a side, or lies beyond it.
void shift_wall(WallSpec& w, const Domain& d, Draw draw) {
  for (int k = 0; k < 2; ++k) {
    if (!d.periodic(k)) continue;
    const double by = draw.real(-1.5, 1.5) * (d.upper[k] - d.lower[k]);
    for (Vec3* at : {&w.point, &w.lower, &w.upper, &w.shift, &w.motion.rotation_origin}) (*at)[k] += by;
  }
}

/// Obstacles in the lowest third of the domain; no source fills it.
void add_walls(RandomScene& r, Draw& draw, double duration) {
  Scene& s = r.scene;
  const Vec3 lower = s.domain.lower, size = s.domain.upper - lower;
  const double height = 0.28 * size.z;
  const int count = draw.below(4);
  for (int k = 0; k < count; ++k) {
    WallSpec w;
    w.name = "wall" + std::to_string(k);
    const Vec3 centre = lower + Vec3{draw.real(0.2, 0.8) * size.x, draw.real(0.2, 0.8) * size.y, 0.5 * height};
    const double half = 0.4 * height;
    switch (draw.below(5)) {
      case 0:
        w.shape = WallShape::plane;
        w.point = lower + Vec3{0, 0, draw.real(0, 1) * height};
        w.normal = {draw.real(-0.05, 0.05), draw.real(-0.05, 0.05), 1};
        break;
      case 1:
        w.shape = WallShape::box;
        w.lower = centre - Vec3{draw.real(0.3, 1) * half, draw.real(0.3, 1) * half, half};
        w.upper = centre + Vec3{draw.real(0.3, 1) * half, draw.real(0.3, 1) * half, half};
        break;
      case 2:
      case 3:
        w.shape = draw.chance(0.5) ? WallShape::cylinder : WallShape::cone;
        w.axis = {1, 0, 0};
        w.length = draw.real(0.2, 0.9) * size.x;
        w.point = centre - Vec3{0.5 * w.length, 0, 0};
        w.radius = draw.real(0.5, 1) * half;
        if (w.shape == WallShape::cone) w.radius_end = draw.real(0.1, 1) * half;
        break;
      default:
        // A surface that covers the floor and continues beyond every side; its images overlap it.
        w.shape = WallShape::mesh;
        w.file = bumpy_mesh(3 + draw.below(6), 0.05);
        w.scale = 1.3 * fmax2(size.x, size.y);
        w.shift = lower + Vec3{-0.1 * size.x, -0.1 * size.y, 0.3 * height};
        r.mesh = true;
    }
    add_motion(w, draw, centre, fmax2(size.x, size.y), r.speed, duration);
    if (w.shape == WallShape::plane) fit_plane(w, s.domain, centre, half);
    shift_wall(w, s.domain, Draw(70 + static_cast<std::uint64_t>(k), static_cast<int>(s.seed)));
    r.moving_walls = r.moving_walls || w.motion.any();
    s.walls.push_back(w);
  }
}

Source fill_source(const RandomScene& r, Draw& draw, Vec3 lower, Vec3 upper, double factor) {
  Source q;
  q.kind = Source::Kind::random;
  q.name = "source";
  q.region.lower = lower;
  q.region.upper = upper;
  q.size.kind = r.ratio > 1 ? SizeDistribution::Kind::uniform : SizeDistribution::Kind::constant;
  q.size.diameter = q.size.max = k_largest;
  q.size.min = k_largest / r.ratio;
  q.velocity_jitter = factor * r.speed * draw.real(0.3, 0.8);
  q.velocity = factor * r.speed * draw.real(0, 0.5) * draw.direction();
  return q;
}

void add_events(RandomScene& r, Draw& draw, double duration) {
  Scene& s = r.scene;
  const Vec3 lower = s.domain.lower, size = s.domain.upper - lower;
  const Vec3 corner =
      lower + Vec3{draw.real(0.1, 0.5) * size.x, draw.real(0.1, 0.5) * size.y, draw.real(0.2, 0.5) * size.z};
  s.groups = {GroupSpec{"some", false, Region{corner, corner + 0.4 * size, 0}, std::nullopt}};
  const auto add = [&](Event::Action action, double from, double to, Vec3 vector) {
    Event e;
    e.action = action;
    e.group = action == Event::Action::gravity ? -1 : 0;
    e.time = draw.real(from, to) * duration;
    e.vector = vector;
    s.events.push_back(e);
  };
  if (draw.chance(0.5)) add(Event::Action::freeze, 0, 0.4, {});
  if (draw.chance(0.5)) add(Event::Action::drive, 0.2, 0.5, 0.05 * r.speed * draw.direction());
  if (draw.chance(0.7)) add(Event::Action::release, 0.5, 0.8, {});
  if (draw.chance(0.4)) add(Event::Action::set_velocity, 0.3, 0.9, r.speed * draw.direction());
  if (draw.chance(0.4)) add(Event::Action::remove, 0.3, 0.9, {});
  if (draw.chance(0.4)) add(Event::Action::gravity, 0.2, 0.9, norm(s.gravity) * draw.direction());
  r.events = !s.events.empty();
}

}  // namespace

RandomScene random_scene(int index) {
  Draw draw(1, index);
  RandomScene r;
  Scene& s = r.scene;
  s.title = "random scene " + std::to_string(index);
  s.seed = static_cast<std::uint64_t>(index) + 1;
  r.speed = std::pow(10, -2 + 3.0 * (index % 40) / 39);  // 0.01 to 10 m/s
  r.ratio = draw.chance(0.3) ? 1 : draw.real(1.1, 4);
  const double u = draw.real(0, 1);
  const int number = 15 + static_cast<int>(385 * u * u);
  // 1. domain: 10 to 30 % solid in the part above the obstacles
  const double mean = 0.5 * k_largest * (1 + 1 / r.ratio);
  const double volume = number * 0.5236 * mean * mean * mean * 1.3 / draw.real(0.12, 0.3);
  const double edge = std::cbrt(volume / 0.7);
  Vec3 size{draw.real(0.6, 1.6) * edge, draw.real(0.6, 1.6) * edge, 0};
  for (int k = 0; k < 2; ++k) size[k] = fmax2(size[k], 2.3 * k_largest);
  size.z = fmax2(volume / (0.7 * size.x * size.y), 7.5 * k_largest);
  s.domain.lower = draw.chance(0.5) ? Vec3{} : Vec3{draw.real(-1, 1), draw.real(-1, 1), draw.real(-1, 1)};
  s.domain.upper = s.domain.lower + size;
  for (std::size_t k = 0; k < 3; ++k) {
    const int kind = draw.below(5);
    auto& b = s.domain.boundary[k];
    if (kind <= 1) b = {Boundary::periodic, Boundary::periodic};
    if (kind == 2) b = {Boundary::open, Boundary::open};
    if (kind == 3) b = {Boundary::wall, Boundary::open};
    r.periodic = r.periodic || kind <= 1;
    r.open = r.open || kind == 2 || kind == 3;
  }
  // 2. law: an impact of two mean grains at the scene's speed overlaps by 0.15 of the smallest radius
  const double r_small = 0.5 * k_largest / r.ratio, density = 2500;
  const double mass_mean = density * 0.5236 * mean * mean * mean,
               mass_small = density * 4.1888 * r_small * r_small * r_small;
  const double k = mass_mean * (r.speed / (0.15 * r_small)) * (r.speed / (0.15 * r_small));
  s.dt = 0.25 * std::sqrt(mass_small / k);
  const double duration = k_audit_steps * s.dt;
  s.steps = k_audit_steps;
  s.sort_every = draw.chance(0.5) ? 1000000 : 40 + draw.below(100);
  s.allow_unstable_step = true;  // judged by the smallest grain; only the completeness of lists is tested here
  s.max_overlap = 1e6;
  s.materials = {Material{"glass", density, 2 * k / r_small, 0.3}};
  s.contact.friction = draw.chance(0.6);
  if (draw.chance(0.2)) s.contact.model = ContactModel::hertz_mindlin;
  s.contact.normal_stiffness = k;
  s.contact.tangential_stiffness = s.contact.friction ? 0.28 * k : 0;
  s.contact.by_restitution = true;
  s.pairs = {PairCoefficients{s.contact.friction ? 0.5 : 0, draw.real(0.3, 1)}};
  if (draw.chance(0.6)) s.gravity = draw.real(0, 3) * r.speed / duration * draw.direction();
  // 3. sources: fast, slow and resting grains; batches during the run
  const double low = s.domain.lower.z + 0.3 * size.z, high = s.domain.upper.z;
  const int sources = 1 + draw.below(3);
  for (int q = 0; q < sources; ++q) {
    const double a = low + (high - low) * q / sources, b = low + (high - low) * (q + 1) / sources;
    if (b - a < 1.3 * k_largest) break;
    Vec3 lo = s.domain.lower, hi = s.domain.upper;
    lo.z = a;
    hi.z = fmin2(b, high);
    Source source = fill_source(r, draw, lo, hi, q == 0 ? 1 : (q == 1 ? 0.03 : 0.001));
    source.number = std::max(2, static_cast<int>(number * (b - a) / (high - low)));
    s.sources.push_back(source);
  }
  if (draw.chance(0.5)) {
    Source stream = fill_source(r, draw, {s.domain.lower.x, s.domain.lower.y, low}, s.domain.upper, 1);
    stream.kind = Source::Kind::stream;
    stream.start = draw.chance(0.3) ? 0 : draw.real(0, 0.3) * duration;
    stream.interval = (7 + draw.below(40)) * s.dt;
    stream.number = 10 + draw.below(60);
    stream.number_rate = static_cast<double>(stream.number) / duration;
    s.sources.push_back(stream);
    r.inserts = true;
  }
  add_walls(r, draw, duration);
  if (draw.chance(0.35)) add_events(r, draw, duration);
  return r;
}

Scene with_random_list(const Scene& scene, ListPolicy policy, int index) {
  static constexpr double k_verlet[] = {0, 1, 10, 50, 200, 1000, 5000};
  static constexpr double cell[] = {0, 0, 1, 1.1, 1.5, 2.5};
  static constexpr double uniform[] = {1, 1, 0.02, 0.3, 2.5};
  Draw draw(2 + static_cast<std::uint64_t>(policy), index);
  Scene s = scene;
  s.list.policy = policy;
  s.list.verlet_k = k_verlet[draw.below(7)];
  s.list.automatic = index % 5 == 0;
  s.list.cell_factor = cell[draw.below(6)];
  s.list.uniform_skin = uniform[draw.below(5)];
  if (draw.chance(0.4)) {
    s.list.floor_on = draw.chance(0.5);
    s.list.acceleration_on = draw.chance(0.5);
    s.list.cap_on = draw.chance(0.5);
  }
  return s;
}

RunOptions random_options(int index) {
  static constexpr int chunks[] = {16, 64, 257, 0};
  Draw draw(99, index);
  RunOptions o;
  o.threads = draw.chance(0.15) ? 2 : 1;
  o.chunk = chunks[draw.below(4)];
  const auto isas = available_isas();
  o.isa = isas[static_cast<std::size_t>(draw.below(static_cast<int>(isas.size())))];
  return o;
}

}  // namespace talus::determinism
