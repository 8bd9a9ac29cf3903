// Periodic images of walls. Who calls it: core/walls/walls.cpp. Invariants: see the header.
#include "core/walls/wall_images.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/walls/wall_elements.hpp"

namespace talus {
namespace {

constexpr double k_parallel = 1e-12;  // normals come from sines and cosines: to rounding they are parallel

double magnitude(double x) { return x < 0 ? -x : x; }

/// Along axis k: the part of space that the box lower..upper can come to during the motion [m].
std::array<double, 2> swept(const WallMotion& m, Vec3 lower, Vec3 upper, int k) {
  std::array<double, 2> range{lower[k], upper[k]};
  const auto turns_about = [&](int q) {
    return m.rotation_axis[(q + 1) % 3] == 0 && m.rotation_axis[(q + 2) % 3] == 0;
  };
  if (m.rotation_rate != 0 && !turns_about(k)) {
    double far2 = 0;
    for (int q = 0; q < 3; ++q) {
      const double d = fmax2(magnitude(upper[q] - m.rotation_origin[q]), magnitude(m.rotation_origin[q] - lower[q]));
      if (!turns_about(q)) far2 += d * d;
    }
    const double far = std::sqrt(far2);
    range = {m.rotation_origin[k] - far, m.rotation_origin[k] + far};
  }
  const double swing = magnitude(m.amplitude[k]);
  const double way = m.velocity[k] != 0 ? m.velocity[k] * (m.end - m.start) : 0;
  return {range[0] - swing + fmin2(way, 0), range[1] + swing + fmax2(way, 0)};
}

/// The largest component along axis k that the normal has at some time.
double largest_component(Vec3 normal, const WallMotion& m, int k) {
  if (m.rotation_rate == 0) return magnitude(normal[k]);
  const Vec3 u = unit(m.rotation_axis);
  const double along = dot(normal, u);
  const Vec3 across = normal - along * u;
  const double a = u[(k + 1) % 3], b = u[(k + 2) % 3];
  return magnitude(along * u[k]) + std::sqrt(norm2(across) * (a * a + b * b));
}

}  // namespace

WallImages::WallImages(const Domain& domain, const WallSpec& wall, Vec3 lower, Vec3 upper, double margin)
    : from_(domain.lower), lower_(lower), upper_(upper) {
  for (int k = 0; k < 3; ++k) {
    if (!domain.periodic(k)) continue;
    const auto [low, high] = swept(wall.motion, lower, upper, k);
    if (low > domain.lower[k] + margin && high < domain.upper[k] - margin) continue;
    const double side = domain.upper[k] - domain.lower[k];
    // a rotating wall can turn its longest diagonal along the axis
    const double extent = wall.motion.rotation_rate != 0 ? norm(upper - lower) : upper[k] - lower[k];
    if (!(extent <= k_longest * side))
      throw Error(ErrorCode::scene,
                  fmt::format("the wall is {:.4g} times as long as the domain along the periodic axis {}",
                              extent / side, "xyz"[k]),
                  "wall \"" + wall.name + "\"", "check its lengths: a mesh file in mm needs scale = 0.001");
    period_[k] = side;
    margin_[k] = fmax2(margin, 0.5 * side);
    slots_[k] = static_cast<std::int32_t>((extent + 2 * margin_[k]) / side) + 3;
    count_ *= slots_[k];
  }
}

bool WallImages::place(Vec3 lower, Vec3 upper) noexcept {
  lower_ = lower;
  upper_ = upper;
  for (int k = 0; k < 3; ++k) {
    if (slots_[k] == 1) continue;
    const double m = std::ceil((from_[k] - margin_[k] - upper[k]) / period_[k]);
    if (!(magnitude(m) <= k_farthest)) return false;
    first_[k] = static_cast<std::int64_t>(m);
    const std::int64_t rest = first_[k] % slots_[k];
    first_slot_[k] = static_cast<std::int32_t>(rest < 0 ? rest + slots_[k] : rest);
  }
  return true;
}

void require_periodic_plane(const Domain& domain, const WallSpec& plane) {
  const Vec3 normal = unit(plane.normal);
  for (int k = 0; k < 3; ++k) {
    if (!domain.periodic(k) || largest_component(normal, plane.motion, k) <= k_parallel) continue;
    const bool at_rest = magnitude(normal[k]) > k_parallel;
    throw Error(ErrorCode::scene,
                fmt::format("the plane {} the periodic axis {}, where it does not meet itself",
                            at_rest ? "cuts" : "turns across", "xyz"[k]),
                "wall \"" + plane.name + "\"",
                fmt::format("a plane must be parallel to a periodic axis: tilt gravity instead, use a box or mesh, or "
                            "close the {} sides (domain.boundary)",
                            "xyz"[k]));
  }
}

}  // namespace talus
