// WallSet: set-up of all walls of a scene, their motion and skins, their surfaces for output.
// Who calls it: scheduler/. Invariants: I2 (skin and travel), I4; elements stay in the wall's body frame, where they
// are static.
#include "core/walls/walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.hpp"
#include "core/walls/wall_motion.hpp"
#include "core/walls/wall_set.hpp"

namespace talus {
namespace {

bool finite(Vec3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

void check_spec(const WallSpec& w) {
  const WallMotion& m = w.motion;
  require_of_wall(finite(w.point) && finite(w.normal) && finite(w.axis) && finite(w.lower) && finite(w.upper) &&
                      finite(w.shift) && std::isfinite(w.length) && std::isfinite(w.radius) &&
                      std::isfinite(w.radius_end) && std::isfinite(w.scale),
                  w, "a number is not finite", "every length must be finite");
  require_of_wall(finite(m.velocity) && finite(m.rotation_axis) && finite(m.rotation_origin) && finite(m.amplitude) &&
                      std::isfinite(m.rotation_rate) && std::isfinite(m.frequency) && std::isfinite(m.phase) &&
                      std::isfinite(m.start),
                  w, "a number of the motion is not finite", "only end may be infinite");
  require_of_wall(m.end >= m.start, w, "the motion ends before it starts", "end >= start");
  require_of_wall(m.rotation_rate == 0 || norm2(m.rotation_axis) > 0, w, "the rotation axis has no length",
                  "e.g. [0, 0, 1]");
  shape_kind(w.shape).check(w);
}

/// Planes for the sides of the domain with Boundary::wall.
void append_domain_sides(const Domain& d, std::vector<WallSpec>& out) {
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      if (d.boundary[axis][side] != Boundary::wall) continue;
      WallSpec w;
      w.name = fmt::format("domain_{}_{}", "xyz"[axis], side == 0 ? "lower" : "upper");
      w.material = d.wall_material;
      w.point = side == 0 ? d.lower : d.upper;
      w.normal = Vec3{};
      w.normal[axis] = side == 0 ? 1 : -1;
      out.push_back(w);
    }
}

}  // namespace

Wall WallSet::Impl::build(const Scene& scene, const WallSpec& spec, double max_reach, double usual_reach,
                          double largest_diameter) const {
  check_spec(spec);
  Wall w;
  w.spec = spec;
  w.moves = spec.motion.any();
  w.shape = shape_kind(spec.shape).make({scene, spec, max_reach, usual_reach, largest_diameter});
  w.count = w.shape->elements;
  w.slack = w.shape->slack;
  const auto& corners = w.shape->corners;
  for (const Vec3 c : corners)
    for (int k = 0; k < 3; ++k) w.extent = fmax2(w.extent, c[k] < 0 ? -c[k] : c[k]);
  if (w.shape->bounded) w.images = WallImages(scene.domain, spec, corners.front(), corners.back(), max_reach);
  return w;
}

/// Tells the wall's images where it is now.
void WallSet::Impl::place_images(Wall& w) const {
  Vec3 lo = to_world(w.pose, w.shape->corners[0]), hi = lo;
  for (const Vec3 c : w.shape->corners) {
    const Vec3 x = to_world(w.pose, c);
    for (int k = 0; k < 3; ++k) lo[k] = fmin2(lo[k], x[k]), hi[k] = fmax2(hi[k], x[k]);
  }
  if (!w.images.place(lo, hi))
    throw Error(ErrorCode::physics,
                fmt::format("the wall is more than {:g} periods away from the domain", WallImages::k_farthest),
                "wall \"" + w.spec.name + "\"", "let its motion end sooner (wall.motion.end)");
}

/// Upper bound of the displacement since mark() of every point of the wall that a particle can touch [m].
double WallSet::Impl::travelled(const Wall& w) const {
  return w.moves ? w.shape->travelled(w.marked, w.pose, domain) : 0;
}

/// Fastest speed of such a point now [m/s].
double WallSet::Impl::speed(const Wall& w) const { return w.pose.moving ? w.shape->speed(w.pose, domain) : 0; }

WallSet::WallSet(const Scene& scene, double max_reach, double usual_reach) : impl_(std::make_unique<Impl>()) {
  std::vector<WallSpec> specs = scene.walls;
  append_domain_sides(scene.domain, specs);
  const Vec3 margin{max_reach, max_reach, max_reach};
  impl_->domain = box_corners(scene.domain.lower - margin, scene.domain.upper + margin);
  impl_->lower = scene.domain.lower;
  impl_->upper = scene.domain.upper;
  double largest_diameter = 0;
  for (const Source& s : scene.sources)
    if (s.kind != Source::Kind::file) largest_diameter = fmax2(largest_diameter, s.size.largest());
  std::int64_t codes = 0;
  for (const WallSpec& spec : specs) {
    Wall w = impl_->build(scene, spec, max_reach, usual_reach, largest_diameter);
    w.first = static_cast<std::int32_t>(impl_->elements);
    w.first_code = static_cast<std::int32_t>(codes);
    impl_->elements += w.count;
    codes += static_cast<std::int64_t>(w.count) * w.images.count();
    if (codes > std::numeric_limits<std::int32_t>::max())
      throw Error(ErrorCode::scene, "the walls and their periodic images have more than 2^31 elements",
                  "wall \"" + spec.name + "\"", "use coarser meshes");
    w.end_code = static_cast<std::int32_t>(codes);
    impl_->judge_speed(scene, w);
    impl_->walls.push_back(std::move(w));
  }
  for (std::size_t i = 0; i < impl_->walls.size(); ++i) impl_->walls[i].surface = impl_->first_of_surface(i);
  set_step(0, scene.dt > 0 ? scene.dt : 1);
  for (Wall& w : impl_->walls) {
    w.marked = w.pose;
    if (w.images.any()) impl_->place_images(w);
  }
}

int WallSet::Impl::first_of_surface(std::size_t wall) const {
  const WallSpec& w = walls[wall].spec;
  std::size_t first = 0;
  while (first < wall && !(walls[first].spec.material == w.material && move_alike(walls[first].spec.motion, w.motion)))
    ++first;
  return static_cast<int>(first);
}

WallSet::WallSet() = default;
WallSet::~WallSet() = default;
WallSet::WallSet(WallSet&&) noexcept = default;
WallSet& WallSet::operator=(WallSet&&) noexcept = default;
WallSet::WallSet(const WallSet& o) : impl_(o.impl_ ? std::make_unique<Impl>(*o.impl_) : nullptr) {}

int WallSet::size() const noexcept { return impl_ ? static_cast<int>(impl_->walls.size()) : 0; }

bool WallSet::any_moving() const noexcept {
  for (int k = 0; k < size(); ++k) {
    const Wall& w = impl_->walls[k];
    if (w.moves || w.spec.appear > 0 || w.spec.vanish < k_never) return true;
  }
  return false;
}

bool WallSet::has_images() const noexcept {
  for (int k = 0; k < size(); ++k)
    if (impl_->walls[k].images.any()) return true;
  return false;
}

int WallSet::image_count(int wall) const { return impl_->walls.at(wall).images.count(); }

Vec3 WallSet::image_shift(int wall, int image) const {
  const WallImages& images = impl_->walls.at(wall).images;
  return images.shift(images.image(image));
}

const std::string& WallSet::name(int wall) const { return impl_->walls.at(wall).spec.name; }
int WallSet::material(int wall) const { return impl_->walls.at(wall).spec.material; }
int WallSet::surface(int wall) const { return impl_->walls.at(wall).surface; }
std::int64_t WallSet::element_count() const noexcept { return impl_ ? impl_->elements : 0; }
const WallPose& WallSet::pose(int wall) const { return impl_->walls.at(wall).pose; }
double WallSet::skin(int wall) const { return impl_->walls.at(wall).skin; }

std::vector<std::pair<std::string, MeshReport>> WallSet::meshes() const {
  std::vector<std::pair<std::string, MeshReport>> all;
  for (int k = 0; k < size(); ++k) {
    const Wall& w = impl_->walls[k];
    if (!w.shape->mesh) continue;
    MeshReport r = *w.shape->mesh;
    r.lower = r.lower + w.spec.corner;
    r.upper = r.upper + w.spec.corner;
    all.emplace_back(w.spec.name, std::move(r));
  }
  return all;
}

std::size_t WallSet::bytes() const noexcept {
  std::size_t sum = 0;
  for (int k = 0; k < size(); ++k) sum += sizeof(Wall) + impl_->walls[k].shape->bytes();
  return sum;
}

void WallSet::set_step(std::int64_t n, double dt) {
  if (!impl_) return;
  impl_->dt = dt;
  impl_->largest_travel = 0;
  for (Wall& w : impl_->walls) {
    w.pose = pose_at(w.spec.motion, w.spec.appear, w.spec.vanish, n, dt);
    if (w.moves && w.images.any()) impl_->place_images(w);
    impl_->largest_travel = fmax2(impl_->largest_travel, impl_->travelled(w));
  }
}

void WallSet::act(int wall, bool active) { impl_->walls[static_cast<std::size_t>(wall)].pose.active = active; }

double WallSet::largest_travel() const noexcept { return impl_->largest_travel; }

void WallSet::mark(double k, double dt, double floor, double cap) {
  if (impl_) impl_->largest_travel = 0;
  for (int i = 0; i < size(); ++i) {
    Wall& w = impl_->walls[i];
    w.marked = w.pose;
    w.skin = w.moves ? fmin2(fmax2(k * impl_->speed(w) * dt, floor), cap) : 0;
  }
}

bool WallSet::expired() const {
  for (int i = 0; i < size(); ++i) {
    const Wall& w = impl_->walls[i];
    if (w.pose.active != w.marked.active || impl_->travelled(w) > w.skin) return true;
  }
  return false;
}

namespace {

/// The wall and those of its images that lie in the domain, beyond rounding; nothing where none does.
WallSurface with_images(const WallImages& images, const WallSurface& own, Vec3 lower, Vec3 upper) {
  if (!images.any()) return own;
  WallSurface s;
  images.for_all([&](std::int32_t, const Periods& image) {
    const Vec3 shift = images.shift(image), period = images.period();
    const std::array<Vec3, 2> box = images.box();
    for (int k = 0; k < 3; ++k) {
      const double hair = 1e-9 * period[k], low = box[0][k] + shift[k], high = box[1][k] + shift[k];
      // one that only touches a side is drawn at the other side; a flat one in the side must be somewhere
      const double least = high - low > 2 * hair ? lower[k] + hair : lower[k] - hair;
      if (period[k] > 0 && !(low < upper[k] - hair && high > least)) return;
    }
    const auto first = static_cast<std::int32_t>(s.points.size());
    for (const Vec3 p : own.points) s.points.push_back(p + shift);
    for (const auto& t : own.triangles) s.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  });
  return s;
}

}  // namespace

std::vector<WallSurface> WallSet::surfaces() const {
  std::vector<WallSurface> all;
  for (int i = 0; i < size(); ++i) {
    const Wall& w = impl_->walls[i];
    WallSurface s;
    if (w.pose.active) {
      s = w.shape->surface(w.pose, impl_->lower, impl_->upper);
      s = with_images(w.images, s, impl_->lower, impl_->upper);
    }
    s.name = w.spec.name;
    all.push_back(std::move(s));
  }
  return all;
}

double WallSet::area(int wall) const {
  const Wall& w = impl_->walls[wall];
  const WallSurface s = w.shape->surface(w.pose, impl_->lower, impl_->upper);
  double area = 0;
  for (const auto& t : s.triangles) {
    const Vec3 a = s.points[static_cast<std::size_t>(t[0])];
    area +=
        0.5 * norm(cross(s.points[static_cast<std::size_t>(t[1])] - a, s.points[static_cast<std::size_t>(t[2])] - a));
  }
  return area;
}

Scene in_stored_frame(const Scene& scene) {
  Scene local = scene;
  local.domain.lower = {};
  local.domain.upper = scene.domain.upper - scene.domain.lower;
  for (WallSpec& s : local.walls) {
    for (Vec3* at : {&s.point, &s.lower, &s.upper, &s.motion.rotation_origin}) *at = *at - scene.domain.lower;
    s.corner = scene.domain.lower;  // taken off the shifted coordinates, so that large shifts lose nothing
  }
  return local;
}

}  // namespace talus
