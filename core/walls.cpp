// WallSet: candidates, reduced contacts and history hand-over for all walls of a scene.
// Who calls it: scheduler/ (rebuild and wall_contact nodes). Invariants: I1 (candidate distances are inflated by more
// than their rounding), I2 (skin and travel), I3 (element order), I4; elements stay in the wall's body frame, where
// they are static: a centre is carried into it and the normal back.
//
// Reduction of the elements within reach of one sphere to contacts. A surface is touched where its distance to the
// centre has a local minimum. So a feature is no contact of its own if
//   (1) it lies at or behind the tangent plane of an accepted face, or of a nearer accepted edge or vertex: coplanar
//       neighbours, the far side of a convex body, and copies of an edge or vertex seen from each of its facets;
//   (2) it is an edge or vertex that lies in another facet which comes nearer to the centre elsewhere: facets are
//       convex, so the distance falls on the way there (the foot of a ramp, the diagonal of a box face near a corner).
// Faces are decided first, and only a face removes a face; then edges and vertices together, nearest first, because on
// a finely meshed corner an edge farther away than the corner itself belongs to the same convex surface.
#include "core/walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <variant>

#include "core/det_math.hpp"
#include "core/error.hpp"
#include "core/facet_grid.hpp"
#include "core/io/mesh_file.hpp"
#include "core/wall_elements.hpp"
#include "core/wall_mesh.hpp"
#include "core/wall_motion.hpp"
#include "core/wall_surface.hpp"

namespace talus {
namespace {

constexpr double k_tangent_tolerance = 1e-9;    // of the radius
constexpr double k_candidate_inflation = 1e-9;  // of the reach: far above the rounding of a distance
constexpr double k_bound_deflation = 1e-6;      // of a distance that is stored in single precision

struct FacetMesh {
  std::vector<TriangleElement> facets;
  FacetGrid grid;        ///< for the largest reach there can be
  FacetGrid usual_grid;  ///< for the reach of nearly all grains: shorter lists; empty where none was asked for
};

struct Wall {
  WallSpec spec;
  std::int32_t first = 0, count = 0;  ///< global element ids [first, first + count)
  std::variant<PlaneElement, FrustumElement, FacetMesh> shape;
  double slack = 0;             ///< vertices lie this near to their facet's plane [m]
  double extent = 0;            ///< largest body coordinate, for rounding bounds [m]
  std::array<Vec3, 8> corners;  ///< body box around the elements (planes: see travelled)
  bool moves = false;           ///< at some time
  bool turns_in_place = false;  ///< rotation maps the surface of revolution onto itself
  WallPose pose, marked;
  double skin = 0;  ///< [m]
};

struct Hit {
  Vec3 normal;
  double distance = 0;
  std::int32_t wall = 0, element = 0;
  Feature feature = Feature::face;
};

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
};

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
    w.slack = coplanarity(mesh);
    f.grid = FacetGrid(f.facets, max_reach, w.slack);
    if (usual_reach > 0 && usual_reach < max_reach) f.usual_grid = FacetGrid(f.facets, usual_reach, w.slack);
    w.count = static_cast<std::int32_t>(f.facets.size());
    w.corners = box_corners(mesh.report.lower, mesh.report.upper);
    w.shape = std::move(f);
  };
  switch (spec.shape) {
    case WallShape::plane:
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
      for (int k = 0; k < 3; ++k) lo[k] = fmin2(f.base[k], top[k]) - r, hi[k] = fmax2(f.base[k], top[k]) + r;
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
      const Mesh mesh = read_mesh(path.string(), spec.scale, spec.shift, largest_diameter);
      const MeshReport& r = mesh.report;
      for (int k = 0; k < 3 && !w.moves; ++k)
        require(r.lower[k] <= scene.domain.upper[k] && r.upper[k] >= scene.domain.lower[k], spec,
                fmt::format("mesh {} lies outside the domain: {} from {:.4g} to {:.4g} m", r.file, "xyz"[k], r.lower[k],
                            r.upper[k]),
                "check wall.scale and wall.shift: a file in mm needs scale = 0.001");
      add_mesh(mesh);
      break;
    }
  }
  for (const Vec3 c : w.corners)
    for (int k = 0; k < 3; ++k) w.extent = fmax2(w.extent, c[k] < 0 ? -c[k] : c[k]);
  return w;
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
  for (const WallSpec& spec : specs) {
    Wall w = impl_->build(scene, spec, max_reach, usual_reach, largest_diameter);
    w.first = static_cast<std::int32_t>(impl_->elements);
    impl_->elements += w.count;
    if (impl_->elements > std::numeric_limits<std::int32_t>::max())
      throw Error(ErrorCode::scene, "the walls have more than 2^31 elements", "wall \"" + spec.name + "\"",
                  "use coarser meshes");
    impl_->walls.push_back(std::move(w));
  }
  set_step(0, scene.dt > 0 ? scene.dt : 1);
  for (Wall& w : impl_->walls) w.marked = w.pose;
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

const std::string& WallSet::name(int wall) const { return impl_->walls.at(wall).spec.name; }
int WallSet::material(int wall) const { return impl_->walls.at(wall).spec.material; }
std::int64_t WallSet::element_count() const noexcept { return impl_ ? impl_->elements : 0; }
const WallPose& WallSet::pose(int wall) const { return impl_->walls.at(wall).pose; }
double WallSet::skin(int wall) const { return impl_->walls.at(wall).skin; }

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

void WallSet::candidates(Vec3 c, double reach, std::vector<std::int32_t>& out, std::vector<float>* distance) const {
  for (int i = 0; i < size(); ++i) {
    const Wall& w = impl_->walls[i];
    if (!w.pose.active) continue;
    const Vec3 b = to_body(w.pose, c);
    const double coordinates = std::sqrt(norm2(c)) + std::sqrt(norm2(b)) + w.extent;
    const double rounding = 0x1p-48 * coordinates + w.slack;
    const double within = (reach + w.skin) * (1 + k_candidate_inflation) + rounding;
    const auto add = [&](std::int32_t element, double d) {
      if (!(d <= within)) return;
      out.push_back(element);
      if (distance != nullptr) distance->push_back(static_cast<float>((d - rounding) * (1 - k_bound_deflation)));
    };
    if (const auto* plane = std::get_if<PlaneElement>(&w.shape)) {
      add(w.first, closest(*plane, b).distance);
    } else if (const auto* frustum = std::get_if<FrustumElement>(&w.shape)) {
      add(w.first, closest(*frustum, b).distance);
    } else {
      const auto& m = std::get<FacetMesh>(w.shape);
      const double padded = within * (1 + k_candidate_inflation);
      auto test = [&](std::int32_t f) {
        ElementHit hit;
        if (closest_within(m.facets[f], b, padded, hit)) add(w.first + f, hit.distance);
      };
      // a grid was built with the slack on top of its reach
      const auto covers = [&](const FacetGrid& g) { return within - w.slack <= g.reach() * (1 + 0.5e-6); };
      if (covers(m.usual_grid)) {
        for (const std::int32_t f : m.usual_grid.near(b)) test(f);
      } else if (covers(m.grid)) {
        for (const std::int32_t f : m.grid.near(b)) test(f);
      } else {  // more than the grid was built for: slower, never incomplete
        for (std::int32_t f = 0; f < w.count; ++f) test(f);
      }
    }
  }
}

namespace {

/// Closest points nearer than the radius, in element order, normals in the world frame.
void collect_hits(const std::vector<Wall>& walls, Vec3 c, double radius, std::span<const std::int32_t> elements,
                  std::vector<Hit>& hits) {
  std::size_t wall = 0;
  bool placed = false;
  Vec3 b;
  for (const std::int32_t e : elements) {
    while (e >= walls[wall].first + walls[wall].count) ++wall, placed = false;
    const Wall& w = walls[wall];
    if (!w.pose.active) continue;
    if (!placed) b = to_body(w.pose, c), placed = true;
    ElementHit hit;
    if (const auto* m = std::get_if<FacetMesh>(&w.shape)) {
      if (!closest_within(m->facets[e - w.first], b, radius + w.slack, hit)) continue;
    } else if (const auto* plane = std::get_if<PlaneElement>(&w.shape)) {
      hit = closest(*plane, b);
    } else {
      hit = closest(std::get<FrustumElement>(w.shape), b);
    }
    if (hit.distance < radius)
      hits.push_back(
          {direction_to_world(w.pose, hit.normal), hit.distance, static_cast<std::int32_t>(wall), e, hit.feature});
  }
}

/// True if the closest point of `b` lies in the facet of `a`, which comes nearer to the centre elsewhere.
bool leads_nearer(const Wall& wall, const Hit& a, const Hit& b, Vec3 c, double tolerance) {
  const auto* m = std::get_if<FacetMesh>(&wall.shape);
  if (m == nullptr || !(a.distance < b.distance)) return false;
  const Vec3 point = to_body(wall.pose, c - b.distance * b.normal);
  return closest(m->facets[a.element - wall.first], point).distance <= tolerance;
}

}  // namespace

int WallSet::contacts(Vec3 c, double radius, std::span<const std::int32_t> elements, WallContact* out) const {
  if (elements.empty()) return 0;
  const std::vector<Wall>& walls = impl_->walls;
  static thread_local std::vector<Hit> hits;
  hits.clear();
  collect_hits(walls, c, radius, elements, hits);

  const auto contact = [&](const Hit& h) {
    const Vec3 point = c - h.distance * h.normal;
    return WallContact{h.wall, h.element, h.normal, h.distance, velocity_at(walls[h.wall].pose, point, impl_->dt)};
  };
  if (hits.empty()) return 0;
  if (hits.size() == 1) {
    out[0] = contact(hits[0]);
    return 1;
  }
  static thread_local std::array<Hit, k_max_contacts> accepted;  // not cleared at every call
  int count = 0;
  auto accept = [&](const Hit& h) {
    if (count == k_max_contacts)
      throw Error(
          ErrorCode::physics,
          fmt::format("a particle of radius {:.4g} m touches more than {} wall features", radius, k_max_contacts),
          fmt::format("position ({:.6g}, {:.6g}, {:.6g})", c.x, c.y, c.z),
          "the mesh is much finer than the particle: use a coarser one");
    accepted[count++] = h;
  };
  auto tolerance = [&](const Hit& a, const Hit& b) {
    return fmax2(k_tangent_tolerance * radius, fmax2(walls[a.wall].slack, walls[b.wall].slack));
  };
  auto behind_accepted = [&](const Hit& h) {
    for (int k = 0; k < count; ++k) {
      const Hit& a = accepted[k];
      if (a.distance - h.distance * dot(a.normal, h.normal) <= tolerance(a, h)) return true;
    }
    return false;
  };
  // Faces first, each group nearest first; an edge wins against a vertex at the same distance.
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    const bool fa = a.feature == Feature::face, fb = b.feature == Feature::face;
    if (fa != fb) return fa;
    if (a.distance != b.distance) return a.distance < b.distance;
    return a.feature != b.feature ? a.feature < b.feature : a.element < b.element;
  });
  for (const Hit& h : hits) {
    if (behind_accepted(h)) continue;
    bool separate = true;
    if (h.feature != Feature::face)
      for (const Hit& a : hits)
        if (separate && leads_nearer(walls[a.wall], a, h, c, tolerance(a, h))) separate = false;
    if (separate) accept(h);
  }
  std::sort(accepted.begin(), accepted.begin() + count,
            [](const Hit& a, const Hit& b) { return a.element < b.element; });
  for (int k = 0; k < count; ++k) out[k] = contact(accepted[k]);
  return count;
}

void WallSet::match(std::span<const WallContact> before, std::span<const WallContact> now, std::int32_t* from) {
  std::array<bool, k_max_contacts> taken{};
  for (std::size_t i = 0; i < now.size(); ++i) {
    from[i] = -1;
    for (std::size_t j = 0; j < before.size(); ++j)
      if (before[j].element == now[i].element && !taken[j]) {
        from[i] = static_cast<std::int32_t>(j);
        taken[j] = true;
        break;
      }
  }
  // The best remaining pair first, so that the outcome does not depend on the order of the contacts.
  for (;;) {
    double best = 0.9;
    std::size_t bi = 0, bj = 0;
    bool found = false;
    for (std::size_t i = 0; i < now.size(); ++i)
      for (std::size_t j = 0; j < before.size() && from[i] < 0; ++j)
        if (!taken[j] && before[j].wall == now[i].wall && dot(before[j].normal, now[i].normal) > best) {
          best = dot(before[j].normal, now[i].normal);
          bi = i, bj = j;
          found = true;
        }
    if (!found) return;
    from[bi] = static_cast<std::int32_t>(bj);
    taken[bj] = true;
  }
}

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
  for (WallSpec& s : local.walls)
    for (Vec3* at : {&s.point, &s.lower, &s.upper, &s.shift, &s.motion.rotation_origin}) *at = *at - scene.domain.lower;
  return local;
}

}  // namespace talus
