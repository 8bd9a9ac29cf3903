// WallSet: set-up of all walls of a scene, their motion and skins, their surfaces for output.
// Who calls it: scheduler/. Invariants: I2 (skin and travel), I4; elements stay in the wall's body frame, where they
// are static.
#include "core/walls/walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <variant>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/meshes/mesh_file.hpp"
#include "core/walls/wall_mesh.hpp"
#include "core/walls/wall_motion.hpp"
#include "core/walls/wall_set.hpp"
#include "core/walls/wall_surface.hpp"

namespace talus {
namespace {

std::array<Vec3, 8> box_corners(Vec3 lo, Vec3 hi) {
  std::array<Vec3, 8> c;
  for (int k = 0; k < 8; ++k) c[k] = {k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z};
  return c;
}

bool finite(Vec3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

void require(bool ok, const WallSpec& w, const std::string& what, const std::string& cure) {
  if (!ok) throw Error(ErrorCode::scene, what, "wall \"" + w.name + "\"", cure);
}

void check_spec(const WallSpec& w) {
  const WallMotion& m = w.motion;
  require(finite(w.point) && finite(w.normal) && finite(w.axis) && finite(w.lower) && finite(w.upper) &&
              finite(w.shift) && std::isfinite(w.length) && std::isfinite(w.radius) && std::isfinite(w.radius_end) &&
              std::isfinite(w.scale),
          w, "a number is not finite", "every length must be finite");
  require(finite(m.velocity) && finite(m.rotation_axis) && finite(m.rotation_origin) && finite(m.amplitude) &&
              std::isfinite(m.rotation_rate) && std::isfinite(m.frequency) && std::isfinite(m.phase) &&
              std::isfinite(m.start),
          w, "a number of the motion is not finite", "only end may be infinite");
  require(m.end >= m.start, w, "the motion ends before it starts", "end >= start");
  require(m.rotation_rate == 0 || norm2(m.rotation_axis) > 0, w, "the rotation axis has no length", "e.g. [0, 0, 1]");
  switch (w.shape) {
    case WallShape::plane:
      require(norm2(w.normal) > 0, w, "the normal has no length", "e.g. normal = [0, 0, 1]");
      break;
    case WallShape::cylinder:
      require(norm2(w.axis) > 0, w, "the axis has no length", "e.g. axis = [0, 0, 1]");
      require(w.length > 0 && w.radius > 0, w, "a cylinder needs length > 0 and radius > 0", "set both");
      break;
    case WallShape::cone:
      require(norm2(w.axis) > 0, w, "the axis has no length", "e.g. axis = [0, 0, 1]");
      require(w.length >= 0 && w.radius >= 0 && w.radius_end >= 0, w, "a cone has a negative length or radius",
              "length, radius and radius_end are >= 0");
      require(w.radius > 0 || w.radius_end > 0, w, "both radii of the cone are 0", "set radius or radius_end");
      require(w.length > 0 || w.radius != w.radius_end, w, "a cone of length 0 and equal radii is a circle",
              "an annulus needs two different radii");
      break;
    case WallShape::box:
      require(w.lower.x < w.upper.x && w.lower.y < w.upper.y && w.lower.z < w.upper.z, w, "the box is empty",
              "lower < upper on every axis");
      break;
    case WallShape::mesh:
      require(!w.file.empty(), w, "a mesh wall needs a file", "file = \"name.stl\"");
      require(w.scale != 0, w, "scale is 0", "e.g. 0.001 for a file in mm");
      break;
  }
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

/// True if a rotation about the motion's axis leaves the surface of revolution where it is.
bool turns_in_place(const FrustumElement& f, const WallMotion& m) {
  if (m.rotation_rate == 0) return true;
  const double size =
      std::sqrt(norm2(f.base)) + std::sqrt(norm2(m.rotation_origin)) + f.length + f.radius_start + f.radius_end;
  return norm2(cross(unit(m.rotation_axis), f.axis)) <= 1e-26 &&
         norm2(cross(f.base - m.rotation_origin, f.axis)) <= 1e-26 * size * size;
}

}  // namespace

Wall WallSet::Impl::build(const Scene& scene, const WallSpec& spec, double max_reach, double usual_reach,
                          double largest_diameter) const {
  check_spec(spec);
  Wall w;
  w.spec = spec;
  w.moves = spec.motion.any();
  w.count = 1;
  auto add_mesh = [&](const Mesh& mesh) {
    FacetMesh f;
    f.facets = make_facets(mesh);
    w.slack = flatness(f.facets);
    f.grid = FacetGrid(f.facets, max_reach, w.slack);
    if (usual_reach > 0 && usual_reach < max_reach) f.usual_grid = FacetGrid(f.facets, usual_reach, w.slack);
    w.count = static_cast<std::int32_t>(f.facets.size());
    w.corners = box_corners(mesh.report.lower, mesh.report.upper);
    w.shape = std::move(f);
  };
  switch (spec.shape) {
    case WallShape::plane:
      require_periodic_plane(scene.domain, spec);
      w.shape = make_plane(spec.point, spec.normal);
      w.corners.fill(spec.point);
      break;
    case WallShape::cylinder:
    case WallShape::cone: {
      const double end = spec.shape == WallShape::cylinder ? spec.radius : spec.radius_end;
      const FrustumElement f = make_frustum(spec.point, spec.axis, spec.length, spec.radius, end);
      const Vec3 top = f.base + f.length * f.axis;
      const double r = fmax2(spec.radius, end);
      Vec3 lo, hi;
      for (int k = 0; k < 3; ++k) {
        const double a = f.axis[(k + 1) % 3], b = f.axis[(k + 2) % 3], across = r * std::sqrt(a * a + b * b);
        lo[k] = fmin2(f.base[k], top[k]) - across, hi[k] = fmax2(f.base[k], top[k]) + across;
      }
      w.corners = box_corners(lo, hi);
      w.turns_in_place = turns_in_place(f, spec.motion);
      w.shape = f;
      break;
    }
    case WallShape::box: {
      Mesh mesh = box_mesh(spec.lower, spec.upper);
      check_mesh(mesh, 0);
      add_mesh(mesh);
      break;
    }
    case WallShape::mesh: {
      const std::filesystem::path file(spec.file);
      const auto path = file.is_absolute() ? file : std::filesystem::path(scene.directory) / file;
      const Mesh mesh = read_mesh(path.string(), {spec.scale, spec.shift, spec.corner}, largest_diameter);
      const MeshReport& r = mesh.report;
      for (int k = 0; k < 3 && !w.moves; ++k)
        require(
            scene.domain.periodic(k) || (r.lower[k] <= scene.domain.upper[k] && r.upper[k] >= scene.domain.lower[k]),
            spec,
            fmt::format("mesh {} lies outside the domain: {} from {:.4g} to {:.4g} m", r.file, "xyz"[k],
                        r.lower[k] + spec.corner[k], r.upper[k] + spec.corner[k]),
            "check wall.scale and wall.shift: a file in mm needs scale = 0.001");
      add_mesh(mesh);
      w.report = mesh.report;
      break;
    }
  }
  for (const Vec3 c : w.corners)
    for (int k = 0; k < 3; ++k) w.extent = fmax2(w.extent, c[k] < 0 ? -c[k] : c[k]);
  if (spec.shape != WallShape::plane)
    w.images = WallImages(scene.domain, spec, w.corners.front(), w.corners.back(), max_reach);
  return w;
}

/// Tells the wall's images where it is now.
void WallSet::Impl::place_images(Wall& w) const {
  Vec3 lo = to_world(w.pose, w.corners[0]), hi = lo;
  for (const Vec3 c : w.corners) {
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
  if (!w.moves) return 0;
  const bool rotated = w.marked.rotated || w.pose.rotated;
  if (const auto* plane = std::get_if<PlaneElement>(&w.shape)) {
    const Vec3 shift = w.pose.translation - w.marked.translation;
    if (!rotated) {  // sliding along itself moves no point of the plane towards a particle
      const double s = dot(shift, plane->normal);
      return s < 0 ? -s : s;
    }
    // The part of an infinite plane that matters is the part in the domain, then or now.
    std::array<Vec3, 16> body;
    for (int k = 0; k < 8; ++k) body[k] = to_body(w.marked, domain[k]), body[8 + k] = to_body(w.pose, domain[k]);
    return travel(w.marked, w.pose, body);
  }
  if (w.turns_in_place) return std::sqrt(norm2(w.pose.translation - w.marked.translation));
  return travel(w.marked, w.pose, w.corners);
}

/// Fastest speed of such a point now [m/s].
double WallSet::Impl::speed(const Wall& w) const {
  if (!w.pose.moving) return 0;
  if (const auto* plane = std::get_if<PlaneElement>(&w.shape)) {
    if (norm2(w.pose.omega) == 0) {
      const double s = dot(w.pose.velocity, direction_to_world(w.pose, plane->normal));
      return s < 0 ? -s : s;
    }
    std::array<Vec3, 8> body;
    for (int k = 0; k < 8; ++k) body[k] = to_body(w.pose, domain[k]);
    return fastest(w.pose, body);
  }
  if (w.turns_in_place) return std::sqrt(norm2(w.pose.velocity));
  return fastest(w.pose, w.corners);
}

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
  set_step(0, scene.dt > 0 ? scene.dt : 1);
  for (Wall& w : impl_->walls) {
    w.marked = w.pose;
    if (w.images.any()) impl_->place_images(w);
  }
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
std::int64_t WallSet::element_count() const noexcept { return impl_ ? impl_->elements : 0; }
const WallPose& WallSet::pose(int wall) const { return impl_->walls.at(wall).pose; }
double WallSet::skin(int wall) const { return impl_->walls.at(wall).skin; }

std::vector<std::pair<std::string, MeshReport>> WallSet::meshes() const {
  std::vector<std::pair<std::string, MeshReport>> all;
  for (int k = 0; k < size(); ++k) {
    const Wall& w = impl_->walls[k];
    if (w.spec.shape != WallShape::mesh) continue;
    MeshReport r = w.report;
    r.lower = r.lower + w.spec.corner;
    r.upper = r.upper + w.spec.corner;
    all.emplace_back(w.spec.name, std::move(r));
  }
  return all;
}

std::size_t WallSet::bytes() const noexcept {
  std::size_t sum = 0;
  for (int k = 0; k < size(); ++k) {
    sum += sizeof(Wall);
    if (const auto* m = std::get_if<FacetMesh>(&impl_->walls[k].shape))
      sum += m->facets.size() * sizeof(TriangleElement) + m->grid.bytes() + m->usual_grid.bytes();
  }
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
      if (const auto* plane = std::get_if<PlaneElement>(&w.shape))
        s = clipped_plane(to_world(w.pose, plane->point), direction_to_world(w.pose, plane->normal), impl_->lower,
                          impl_->upper);
      else if (const auto* frustum = std::get_if<FrustumElement>(&w.shape))
        s = tessellated(*frustum);
      else
        s = tessellated(std::get<FacetMesh>(w.shape).facets);
      if (w.spec.shape != WallShape::plane)
        for (Vec3& p : s.points) p = to_world(w.pose, p);
      s = with_images(w.images, s, impl_->lower, impl_->upper);
    }
    s.name = w.spec.name;
    all.push_back(std::move(s));
  }
  return all;
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
