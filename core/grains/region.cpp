// Regions. Who calls it: see the header. Invariants: see the header.
#include "core/grains/region.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/gas/overlap.hpp"
#include "core/grains/body.hpp"
#include "core/grains/body_shape.hpp"
#include "core/grains/curved_share.hpp"
#include "core/walls/closed_surface.hpp"
#include "core/walls/wall_elements.hpp"

namespace talus {
namespace {

using Shape = Region::Shape;

/// Share of a sphere's volume below a plane at signed distance t radii above its centre.
double below(double t) noexcept {
  if (t <= -1) return 0;
  if (t >= 1) return 1;
  return 0.25 * (2 + 3 * t - t * t * t);
}
double between(double lower, double upper, double centre, double r) noexcept {
  return below((upper - centre) / r) - below((lower - centre) / r);
}

double rim2(const Region& g, Vec3 x) noexcept {
  const double dx = x.x - 0.5 * (g.lower.x + g.upper.x), dy = x.y - 0.5 * (g.lower.y + g.upper.y);
  return dx * dx + dy * dy;
}

/// Position in a cylinder: along the axis, and squared distance from it.
struct Cylindrical {
  double along, rho2;
};
Cylindrical cylindrical(const Region& g, Vec3 x) noexcept {
  const Vec3 d = x - g.point;
  const double along = dot(d, g.axis);
  return {along, norm2(d - along * g.axis)};
}

bool in_bounds(const Region& g, Vec3 x) noexcept {
  return x.x >= g.lower.x && x.x <= g.upper.x && x.y >= g.lower.y && x.y <= g.upper.y && x.z >= g.lower.z &&
         x.z <= g.upper.z;
}

/// Calls visit with x and its images by one period on every axis on which images can matter.
template <class Visit>
void each_image(const Domain& d, const std::array<bool, 3>& axes, Vec3 x, Visit&& visit) {
  Vec3 at[3];
  int count[3];
  for (int k = 0; k < 3; ++k) {
    const double length = d.upper[k] - d.lower[k];
    at[0][k] = x[k];
    at[1][k] = x[k] - length;
    at[2][k] = x[k] + length;
    count[k] = axes[static_cast<std::size_t>(k)] ? 3 : 1;
  }
  for (int a = 0; a < count[0]; ++a)
    for (int b = 0; b < count[1]; ++b)
      for (int c = 0; c < count[2]; ++c) visit(Vec3{at[a].x, at[b].y, at[c].z});
}

/// Between flat ends alone in closed form.
double in_bar(double radius, double low, double high, double off, double r) noexcept {
  return off + r <= radius ? between(low, high, 0, r) : share_in_bar(radius, low, high, off, r);
}

double share_of_one(const Region& g, Vec3 x, double r) noexcept {
  for (int k = 0; k < 3; ++k)
    if (x[k] + r <= g.lower[k] || x[k] - r >= g.upper[k]) return 0;
  switch (g.shape) {
    case Shape::box: {
      const double wz = between(g.lower.z, g.upper.z, x.z, r);
      if (g.radius > 0) return in_bar(g.radius, g.lower.z - x.z, g.upper.z - x.z, std::sqrt(rim2(g, x)), r);
      int cut = 0;  // axes across which a side cuts the sphere: more than one meet in an edge
      for (int k = 0; k < 3; ++k) cut += x[k] - r < g.lower[k] || x[k] + r > g.upper[k] ? 1 : 0;
      if (cut > 1) return gas::ball_in_box(x, r, g.lower, g.upper) / Body{r}.volume();
      return wz * between(g.lower.x, g.upper.x, x.x, r) * between(g.lower.y, g.upper.y, x.y, r);
    }
    case Shape::cylinder: {
      const Cylindrical c = cylindrical(g, x);
      return in_bar(g.radius, -c.along, g.length - c.along, std::sqrt(c.rho2), r);
    }
    case Shape::sphere:
      return share_in_ball(g.radius, std::sqrt(norm2(x - g.point)), r);
    case Shape::mesh: {
      const double depth = g.surface->distance(x, r);
      return below((g.surface->inside(x) ? depth : -depth) / r);
    }
  }
  return 0;
}

std::string_view key_of(const Region& g, bool lower) {
  switch (g.shape) {
    case Shape::box:
      return lower ? "lower" : "upper";
    case Shape::cylinder:
      return "point";
    case Shape::sphere:
      return "centre";
    case Shape::mesh:
      break;
  }
  return "file";
}

}  // namespace

bool inside(const Region& g, Vec3 x) noexcept {
  switch (g.shape) {
    case Shape::box:
      return in_bounds(g, x) && (!(g.radius > 0) || rim2(g, x) <= g.radius * g.radius);
    case Shape::cylinder: {
      const Cylindrical c = cylindrical(g, x);
      return c.along >= 0 && c.along <= g.length && c.rho2 <= g.radius * g.radius;
    }
    case Shape::sphere:
      return norm2(x - g.point) <= g.radius * g.radius;
    case Shape::mesh:
      return g.surface->inside(x);
  }
  return false;
}

bool inside(const Domain& d, const Region& g, Vec3 x) noexcept {
  std::array<bool, 3> beyond;
  for (int k = 0; k < 3; ++k)
    beyond[static_cast<std::size_t>(k)] = d.periodic(k) && (g.lower[k] < d.lower[k] || g.upper[k] > d.upper[k]);
  bool any = false;
  each_image(d, beyond, x, [&](Vec3 y) { any = any || inside(g, y); });
  return any;
}

bool spans(const Domain& d, const Region& g, int axis) noexcept {
  if (!d.periodic(axis) || !(g.lower[axis] <= d.lower[axis] && g.upper[axis] >= d.upper[axis])) return false;
  const double along = g.axis[axis];
  return g.shape == Shape::box || (g.shape == Shape::cylinder && (along == 1 || along == -1));
}

bool holds(const Domain& d, const Region& g, Vec3 x, double r) noexcept {
  const double free = g.radius - r;
  switch (g.shape) {
    case Shape::box:
      return !(g.radius > 0) || (free >= 0 && rim2(g, x) <= free * free);
    case Shape::cylinder: {
      const Cylindrical c = cylindrical(g, x);
      bool closed = false;
      for (int k = 0; k < 3; ++k) closed = closed || spans(d, g, k);
      if (!closed && !(c.along >= r && c.along <= g.length - r)) return false;
      return free >= 0 && c.rho2 <= free * free;
    }
    case Shape::sphere:
      return free >= 0 && norm2(x - g.point) <= free * free;
    case Shape::mesh:
      return g.surface->inside(x) && !(g.surface->distance(x, r) < r);
  }
  return false;
}

double share_inside(const Domain& d, const Region& g, Vec3 x, double r) noexcept {
  double sum = 0;
  each_image(d, {d.periodic(0), d.periodic(1), d.periodic(2)}, x, [&](Vec3 y) { sum += share_of_one(g, y, r); });
  return sum;
}

double volume(const Region& g) noexcept {
  const Vec3 e = g.upper - g.lower;
  switch (g.shape) {
    case Shape::box:
      return g.radius > 0 ? det::k_pi * (g.radius * g.radius) * e.z : e.x * e.y * e.z;
    case Shape::cylinder:
      return det::k_pi * (g.radius * g.radius) * g.length;
    case Shape::sphere:
      return 4.0 / 3.0 * det::k_pi * (g.radius * g.radius * g.radius);
    case Shape::mesh:
      return g.surface->volume();
  }
  return 0;
}

void set_bounds(Region& g) noexcept {
  if (g.shape == Shape::sphere) {
    const Vec3 r{g.radius, g.radius, g.radius};
    g.lower = g.point - r;
    g.upper = g.point + r;
  }
  if (g.shape == Shape::cylinder) {
    g.axis = unit(g.axis);
    const Vec3 end = g.point + g.length * g.axis;
    for (int k = 0; k < 3; ++k) {
      const double across2 = 1 - g.axis[k] * g.axis[k];
      const double half = across2 > 0 ? g.radius * std::sqrt(across2) : 0;
      g.lower[k] = fmin2(g.point[k], end[k]) - half;
      g.upper[k] = fmax2(g.point[k], end[k]) + half;
    }
  }
  if (g.shape == Shape::mesh) {
    g.lower = g.surface->lower();
    g.upper = g.surface->upper();
  }
}

void load_region(Region& g, const std::string& directory, const std::string& where) {
  if (g.shape != Shape::mesh) return;
  const std::filesystem::path file(g.file);
  const auto path = file.is_absolute() ? file : std::filesystem::path(directory) / file;
  try {
    g.surface = std::make_shared<const ClosedSurface>(read_mesh(path.string(), {g.scale, g.shift, {}}, 0));
  } catch (const Error& e) {
    throw Error(e.code(), e.what(), where);
  }
  set_bounds(g);
}

void load_regions(Scene& scene) {
  const auto load = [&](Region& g, const std::string& where, bool within) {
    if (g.shape != Shape::mesh) return;  // the others were judged when they were read
    load_region(g, scene.directory, where);
    if (const auto fault = region_fault(scene.domain, g, within))
      throw Error(ErrorCode::scene, fmt::format("mesh {}: {}", g.file, fault->text), where,
                  "check scale and shift: a file in mm needs scale = 0.001");
  };
  for (Source& s : scene.sources)
    if (s.kind != Source::Kind::file) load(s.region, fmt::format("source '{}', region", s.name), true);
  for (GroupSpec& g : scene.groups)
    if (g.region) load_region(*g.region, scene.directory, fmt::format("group '{}', region", g.name));
  for (auto& a : scene.output.regions) load(a.region, fmt::format("output region '{}'", a.name), false);
  for (ShapeSpec& s : scene.shapes) load_shape(s, scene.directory);
  set_natural_sizes(scene);
}

void require_loaded(const Scene& scene) {
  const auto require = [](const Region& g, const std::string& where) {
    if (g.shape == Shape::mesh && g.surface == nullptr)
      throw Error(ErrorCode::scene, fmt::format("the mesh {} of a region has not been read", g.file), where,
                  "load_regions() reads it");
  };
  for (const Source& s : scene.sources) require(s.region, fmt::format("source '{}'", s.name));
  for (const GroupSpec& g : scene.groups)
    if (g.region) require(*g.region, fmt::format("group '{}'", g.name));
  for (const auto& a : scene.output.regions) require(a.region, fmt::format("output region '{}'", a.name));
  for (const ShapeSpec& s : scene.shapes)
    if (s.body == nullptr)
      throw Error(ErrorCode::scene, fmt::format("the file {} has not been read", s.file),
                  fmt::format("shape '{}'", s.name), "load_regions() reads it");
}

std::optional<RegionFault> region_fault(const Domain& d, const Region& g, bool within) {
  for (int k = 0; k < 3; ++k) {
    const double length = d.upper[k] - d.lower[k], tiny = g.shape == Shape::box ? 0 : 1e-12 * length;
    const bool low = g.lower[k]<d.lower[k] - tiny, high = g.upper[k]> d.upper[k] + tiny;
    if (!low && !high) continue;
    if (!d.periodic(k)) {
      if (!within) continue;
      return RegionFault{key_of(g, low), fmt::format("the region must lie within the domain: it reaches from {} = {:g} "
                                                     "to {:g}, the domain from {:g} to {:g}",
                                                     "xyz"[k], g.lower[k], g.upper[k], d.lower[k], d.upper[k])};
    }
    const double middle = 0.5 * (g.lower[k] + g.upper[k]);
    if (g.upper[k] - g.lower[k] > length * (1 + 1e-12) || middle < d.lower[k] || middle > d.upper[k])
      return RegionFault{key_of(g, low),
                         fmt::format("on a periodic axis the region may be as long as the domain and has its middle in "
                                     "it: it reaches from {} = {:g} to {:g}, the domain from {:g} to {:g}",
                                     "xyz"[k], g.lower[k], g.upper[k], d.lower[k], d.upper[k])};
  }
  return {};
}

}  // namespace talus
