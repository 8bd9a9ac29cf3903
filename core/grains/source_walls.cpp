// Walls as sources see them. Who calls it: see the header. Invariants: see the header.
#include "core/grains/source_walls.hpp"

#include <algorithm>
#include <array>

#include "core/base/error.hpp"
#include "core/shapes/body_walls.hpp"
#include "core/walls/shapes/shape.hpp"
#include "core/walls/wall_motion.hpp"

namespace talus {
namespace {

std::unique_ptr<const ClosedSurface> closed_surface(const Scene& scene, const WallSpec& w) {
  const ShapeKind& kind = shape_kind(w.shape);
  const std::optional<Mesh> mesh = kind.enclosing != nullptr ? kind.enclosing(scene, w) : std::nullopt;
  if (!mesh) return nullptr;
  try {
    return std::make_unique<const ClosedSurface>(*mesh);
  } catch (const Error&) {  // some edge has an odd number of facets
    return nullptr;
  }
}

}  // namespace

ClosedWalls::ClosedWalls(const Scene& scene) : domain_(scene.domain) {
  for (const WallSpec& w : scene.walls) surfaces_.push_back(closed_surface(scene, w));
}

bool ClosedWalls::any() const {
  return std::any_of(surfaces_.begin(), surfaces_.end(), [](const auto& s) { return s != nullptr; });
}

bool ClosedWalls::inside(const WallSet& walls, int wall, Vec3 x) const {
  const ClosedSurface* surface = surfaces_[static_cast<std::size_t>(wall)].get();
  if (surface == nullptr || !walls.pose(wall).active) return false;
  for (int k = 0; k < walls.image_count(wall); ++k) {
    const Vec3 c = (x - domain_.lower) - walls.image_shift(wall, k);
    if (surface->inside(to_body(walls.pose(wall), c) + domain_.lower)) return true;
  }
  return false;
}

bool ClosedWalls::inside_any(const WallSet& walls, Vec3 x) const {
  for (std::size_t w = 0; w < surfaces_.size(); ++w)
    if (inside(walls, static_cast<int>(w), x)) return true;
  return false;
}

std::vector<Vec3> ClosedWalls::points(const WallSet& walls, int wall) const {
  std::vector<Vec3> out;
  for (const TriangleElement& t : surfaces_[static_cast<std::size_t>(wall)]->facets()) {
    const auto add = [&](Vec3 body) {
      out.push_back(to_world(walls.pose(wall), body - domain_.lower) + domain_.lower);
    };
    for (const Vec3 v : t.v) add(v);
    add((1.0 / 3.0) * ((t.v[0] + t.v[1]) + t.v[2]));
  }
  return out;
}

SourceWalls::SourceWalls(const Domain& domain, const WallSet* walls)
    : domain_(domain), walls_(walls != nullptr && walls->size() > 0 ? walls : nullptr) {
  for (int k = 0; k < 3; ++k)
    for (const double c : {domain.lower[k], domain.upper[k]}) size_ = fmax2(size_, c < 0 ? -c : c);
}

double SourceWalls::rounding(double r) const noexcept {
  // Meshes often come in single precision: a lattice that is flush with a facet may overlap it by the rounding of its
  // vertices.
  return fmin2(1e-3 * r, fmax2(1e-6 * r, 0x1p-22 * size_));
}

std::optional<SourceWalls::Overlap> SourceWalls::deepest(Vec3 x, double r, double forgiven) const {
  if (walls_ == nullptr) return {};
  const Vec3 c = x - domain_.lower;
  near_.clear();
  walls_->candidates(c, r, near_);
  Overlap worst;
  // One element at a time: a sphere across a fine mesh may meet more of them than a contact in motion can have.
  for (const std::int32_t& element : near_) {
    std::array<WallContact, WallSet::k_max_contacts> contact;
    if (walls_->contacts(c, r, {&element, 1}, contact.data()) == 0) continue;
    const double depth = r - contact[0].distance;
    if (worst.wall < 0 || depth > worst.depth) worst = {contact[0].wall, depth};
  }
  if (worst.wall < 0 || !(worst.depth > forgiven)) return {};
  return worst;
}

std::optional<SourceWalls::Overlap> SourceWalls::deepest(shapes::Body body, double bound, double forgiven) const {
  if (walls_ == nullptr) return {};
  body.centre = body.centre - domain_.lower;
  near_.clear();
  walls_->candidates(body.centre, bound, near_);
  Overlap worst;
  std::vector<shapes::BodyWallContact> contacts;
  for (const std::int32_t& element : near_) {
    contacts.clear();
    shapes::body_wall_contacts(body, bound, *walls_, {&element, 1}, {}, contacts);
    for (const shapes::BodyWallContact& c : contacts)
      if (const double depth = bound - c.contact.distance; worst.wall < 0 || depth > worst.depth)
        worst = {c.contact.wall, depth};
  }
  if (worst.wall < 0 || !(worst.depth > forgiven)) return {};
  return worst;
}

}  // namespace talus
