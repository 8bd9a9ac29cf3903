// See gas_bodies.hpp.
#include "scheduler/parts/gas_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/det_math.hpp"
#include "core/gas/exchange.hpp"
#include "core/grains/body_shape.hpp"
#include "core/shapes/superquadric.hpp"
#include "scheduler/parts/conversion_bodies.hpp"

namespace talus {

namespace {

using Shares = std::vector<std::pair<int, double>>;

constexpr double k_flat = 0.5;  // sphericity below which Ergun and Ganser know little

/// One entry per cell, ascending.
void merge(Shares& parts) {
  std::stable_sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::size_t n = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (n > 0 && parts[n - 1].first == parts[k].first)
      parts[n - 1].second += parts[k].second;
    else
      parts[n++] = parts[k];
  }
  parts.resize(n);
}

}  // namespace

GasGrains::GasGrains(const Scene& scene) : scene_(scene) {
  if (!makes_bodies(scene)) return;
  const std::vector<EqualSpheres> equal = equal_spheres(scene);
  for (const ShapeSpec& s : scene.shapes) {
    const BodyShape& body = *s.body;
    Kind k;
    k.ball = body.quadric ? body.quadric->ball : body.spheres.size() == 1;
    double all = 0;
    for (const shapes::SubSphere& p : body.spheres) all += 4 * det::k_pi / 3 * (p.r * p.r * p.r);
    if (!k.ball) {
      k.fill = body.volume / all;
      // 3 V/A over the radius of equal volume
      k.drag = gas::drag_shape(fmin2(1, equal[kinds_.size()].radius / body.equal_radius));
    }
    kinds_.push_back(k);
  }
}

GasGrain GasGrains::of(const Rows& rows, Row i) const {
  const std::int32_t b = rows.body_of(i);
  if (b < 0) return {2 * rows.p[4L * i + 3], &sphere_};
  const auto shape = static_cast<std::size_t>(rows.bodies.shape[static_cast<std::size_t>(b)]);
  const Kind& k = kinds_[shape];
  if (k.ball) return {2 * rows.p[4L * i + 3], &k.drag};
  return {2 * (rows.bodies.scale(b) * scene_.shapes[shape].body->equal_radius), &k.drag};
}

GasGrain GasGrains::of(const Source& s, double diameter) const {
  return {diameter, s.shape < 0 ? &sphere_ : &kinds_[static_cast<std::size_t>(s.shape)].drag};
}

void GasGrains::share(const Rules& rules, const Rows& rows, const gas::Grid& grid, Row i, Shares& parts) const {
  const std::int32_t b = rows.body_of(i);
  if (b >= 0) {
    const auto shape = static_cast<std::size_t>(rows.bodies.shape[static_cast<std::size_t>(b)]);
    if (!kinds_[shape].ball)
      return scene_.shapes[shape].body->quadric ? share_superquadric(rules, rows, grid, i, parts)
                                                : share_clump(rules, rows, grid, i, kinds_[shape].fill, parts);
  }
  gas::share(grid, position_of(rules, rows, i), rows.p[4L * i + 3], parts);
}

void GasGrains::share_clump(const Rules& rules, const Rows& rows, const gas::Grid& grid, Row i, double fill,
                            Shares& parts) {
  const Row end = i + static_cast<Row>(shape_of(rules, rows.bodies, rows.body_of(i)).spheres.size());
  Shares own;
  parts.clear();
  for (Row q = i; q < end; ++q) {
    gas::share(grid, position_of(rules, rows, q), rows.p[4L * q + 3], own);
    for (const auto& [cell, volume] : own) parts.emplace_back(cell, fill * volume);
  }
  merge(parts);
}

void GasGrains::share_superquadric(const Rules& rules, const Rows& rows, const gas::Grid& grid, Row i, Shares& parts) {
  const std::int32_t b = rows.body_of(i);
  const BodyShape& body = shape_of(rules, rows.bodies, b);
  const double scale = rows.bodies.scale(b);
  const shapes::Rotation turn = shapes::rotation(state_of(rows.bodies, b).turn);
  Vec3 reach;
  for (int k = 0; k < 3; ++k) reach[k] = scale * shapes::support_point(body.quadric->surface, turn.row[k]).h;
  gas::share(grid, centre_of(rules, rows, i), reach, parts);
  const double volume = body.volume * (scale * scale * scale),
               fill = volume / (4 * det::k_pi / 3 * (reach.x * reach.y * reach.z));
  for (auto& part : parts) part.second *= fill;
}

std::vector<std::string> GasGrains::advice() const {
  std::vector<std::string> lines;
  for (std::size_t k = 0; k < kinds_.size(); ++k) {
    const gas::DragShape& s = kinds_[k].drag;
    const double d = 2 * scene_.shapes[k].body->equal_radius;
    if (!kinds_[k].ball)
      lines.push_back(
          fmt::format("{}: sphericity {:.3g}; at scale 1 the gas sees {:.4g} m of equal volume, in a dense "
                      "bed {:.4g} m; alone Stokes' drag times {:.3g}, Newton's times {:.3g}{}",
                      scene_.shapes[k].name, s.sphericity, d, s.sphericity * d, 1 / s.stokes, s.newton,
                      s.sphericity < k_flat ? ", which is uncertain of grains so flat or long" : ""));
  }
  return lines;
}

Vec3 arm_of_first(const Rules& rules, const Bodies& bodies, std::int32_t b) {
  const shapes::Rotation turn = shapes::rotation(state_of(bodies, b).turn);
  return shapes::to_space(turn, bodies.scale(b) * shape_of(rules, bodies, b).spheres.front().x);
}

}  // namespace talus
