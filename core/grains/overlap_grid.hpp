// Spheres in hashed cells, one grid per halving of the radius: finds who overlaps a given sphere at a cost that does not
// depend on the number of spheres; only one that is far larger than others looks at all of them. Set-up and insertion
// only; the engine's list is elsewhere. Who calls it: core/grains/insertion.cpp. Invariants: answers do not depend on
// the hash (a query visits every sphere in reach); + - * / and comparisons only (I4).
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/det_math.hpp"
#include "core/base/rng.hpp"
#include "core/base/types.hpp"

namespace talus {

class OverlapGrid {
 public:
  struct Sphere {
    Vec3 x;
    double r;
    std::int32_t next;   ///< chain of the cell
    std::int32_t index;  ///< the caller's number
  };

  /// `largest` [m]: radius of the largest sphere to come (larger ones are found too, only slower).
  explicit OverlapGrid(double largest) : edge_(2 * largest), heads_(1 << 12, -1) {}

  /// Room for n spheres in all, so that growing does not link them again and again.
  void reserve(std::size_t n) {
    spheres_.reserve(n);
    std::size_t size = heads_.size();
    while (size < n) size *= 2;
    if (size > heads_.size()) relink(size);
  }

  void add(Vec3 x, double r, std::int32_t index) {
    spheres_.push_back({x, r, -1, index});
    if (spheres_.size() > heads_.size()) {
      relink(2 * heads_.size());
    } else {
      link(spheres_.size() - 1);
    }
  }

  /// Calls visit(sphere, squared distance of centres) for every sphere that may touch (x, r), some more than once,
  /// until it returns true; returns whether it did.
  template <class Visit>
  bool any(Vec3 x, double r, Visit&& visit) const {
    for (int level = 0; level < k_levels; ++level) {
      if (!(reach_[level] > 0)) continue;
      const double reach = r + reach_[level], edge = edge_ / static_cast<double>(1 << level);
      std::int64_t low[3], high[3];
      for (int k = 0; k < 3; ++k) {
        low[k] = cell(x[k] - reach, edge);
        high[k] = cell(x[k] + reach, edge);
      }
      // Far smaller spheres than this one: it covers more of their cells than there are spheres in all.
      const double cells = static_cast<double>(high[0] - low[0] + 1) * static_cast<double>(high[1] - low[1] + 1) *
                           static_cast<double>(high[2] - low[2] + 1);
      if (cells > 64 + static_cast<double>(spheres_.size())) {
        for (const Sphere& sphere : spheres_)
          if (visit(sphere, norm2(sphere.x - x))) return true;
        return false;
      }
      for (std::int64_t z = low[2]; z <= high[2]; ++z) {
        for (std::int64_t y = low[1]; y <= high[1]; ++y) {
          const std::uint64_t row = row_hash(level, y, z);
          for (std::int64_t c = low[0]; c <= high[0]; ++c) {
            for (std::int32_t s = heads_[slot(row, c)]; s >= 0; s = spheres_[static_cast<std::size_t>(s)].next) {
              const Sphere& sphere = spheres_[static_cast<std::size_t>(s)];
              if (visit(sphere, norm2(sphere.x - x))) return true;
            }
          }
        }
      }
    }
    return false;
  }

 private:
  static constexpr int k_levels = 16;
  static std::int64_t cell(double x, double edge) noexcept {
    return det::floor_int(fmin2(fmax2(x / edge, -1e15), 1e15));
  }
  static std::uint64_t row_hash(int level, std::int64_t y, std::int64_t z) noexcept {
    return mix64(static_cast<std::uint64_t>(y) * 0x9e3779b97f4a7c15ULL + static_cast<std::uint64_t>(z) * 16 +
                 static_cast<std::uint64_t>(level));
  }
  /// Neighbours along x share cache lines.
  std::size_t slot(std::uint64_t row, std::int64_t x) const noexcept {
    return (row + static_cast<std::uint64_t>(x)) & (heads_.size() - 1);
  }
  void relink(std::size_t size) {
    heads_.assign(size, -1);
    for (std::size_t k = 0; k < spheres_.size(); ++k) link(k);
  }
  void link(std::size_t k) {
    Sphere& s = spheres_[k];
    int level = 0;
    double edge = edge_;
    while (level + 1 < k_levels && 4 * s.r <= edge) edge = edge * 0.5, ++level;
    reach_[level] = fmax2(reach_[level], s.r);
    std::int32_t& head = heads_[slot(row_hash(level, cell(s.x.y, edge), cell(s.x.z, edge)), cell(s.x.x, edge))];
    s.next = head;
    head = static_cast<std::int32_t>(k);
  }

  double edge_;
  double reach_[k_levels] = {};  ///< largest radius of each level
  std::vector<std::int32_t> heads_;
  std::vector<Sphere> spheres_;
};

}  // namespace talus
