// Facet grid. Who calls it: core/walls/walls.cpp. Invariants: see the header.
#include "core/walls/facet_grid.hpp"

#include <algorithm>
#include <utility>

#include "core/base/count.hpp"

namespace talus {
namespace {

constexpr double k_edge = 0.5;  // of a cell, in reaches
constexpr std::size_t k_cells_least = std::size_t{1} << 20;
constexpr std::int64_t k_cells_most = std::int64_t{1} << 21;
constexpr std::size_t k_entries_base = std::size_t{1} << 21, k_entries_per_facet = 64;

}  // namespace

FacetGrid::FacetGrid(std::span<const TriangleElement> facets, double reach, double slack) : reach_(reach) {
  if (facets.empty()) return;
  lower_ = upper_ = facets[0].v[0];
  for (const TriangleElement& t : facets)
    for (const Vec3 v : t.v)
      for (int k = 0; k < 3; ++k) lower_[k] = fmin2(lower_[k], v[k]), upper_[k] = fmax2(upper_[k], v[k]);
  double size = 0;
  for (int k = 0; k < 3; ++k) {
    const double far = fmax2(upper_[k], -lower_[k]);
    size = fmax2(size, fmax2(upper_[k] - lower_[k], far));
  }
  const double padded = reach * (1 + 1e-6) + slack + 1e-12 * size;
  for (int k = 0; k < 3; ++k) lower_[k] -= padded, upper_[k] += padded;

  // Cells below the reach give short lists; larger where the box would have too many cells, or where large
  // slanted facets would fill too many of them.
  const std::size_t cell_limit = std::min<std::size_t>(k_cells_most, std::max(k_cells_least, 4 * facets.size()));
  const std::size_t entry_limit = k_entries_base + k_entries_per_facet * facets.size();
  const Vec3 extent = upper_ - lower_;
  double edge = fmax2(k_edge * reach, 1e-6 * size);
  auto cells_at = [&](double h) {
    double n = 1;
    for (int k = 0; k < 3; ++k) n *= extent[k] / h + 1;
    return n;
  };
  while (cells_at(edge) > static_cast<double>(cell_limit)) edge *= 1.25;
  while (!fill(facets, padded, edge, entry_limit)) edge *= 1.5;
}

bool FacetGrid::fill(std::span<const TriangleElement> facets, double padded, double edge, std::size_t limit) {
  inverse_edge_ = 1 / edge;
  for (int k = 0; k < 3; ++k)
    cells_[k] = static_cast<int>(count_floor((upper_[k] - lower_[k]) * inverse_edge_, 0, k_cells_most)) + 1;
  const std::size_t total = static_cast<std::size_t>(cells_[0]) * cells_[1] * cells_[2];
  const double half_diagonal = 0.8660254037844387 * edge * (1 + 1e-9);
  const double near_enough = padded + half_diagonal;
  const bool unlimited = total <= 8;  // coarser cells would save nothing

  std::vector<std::pair<std::int32_t, std::int32_t>> hits;  // cell, facet; facets ascend
  for (std::size_t f = 0; f < facets.size(); ++f) {
    const TriangleElement& t = facets[f];
    std::array<int, 3> lo, hi;
    for (int k = 0; k < 3; ++k) {
      const double a = fmin2(t.v[0][k], fmin2(t.v[1][k], t.v[2][k])) - padded;
      const double b = fmax2(t.v[0][k], fmax2(t.v[1][k], t.v[2][k])) + padded;
      lo[k] = cell_index((a - lower_[k]) * inverse_edge_ - 1e-9, cells_[k]);
      hi[k] = cell_index((b - lower_[k]) * inverse_edge_ + 1e-9, cells_[k]);
    }
    // Walk the columns along the axis in which the facet's plane is steepest: only the slab around it is visited.
    int w = 0;
    auto size_of = [&](int k) { return t.normal[k] < 0 ? -t.normal[k] : t.normal[k]; };
    for (int k = 1; k < 3; ++k)
      if (size_of(k) > size_of(w)) w = k;
    const int u = (w + 1) % 3, v = (w + 2) % 3;
    const double half_height = near_enough / size_of(w);
    std::array<int, 3> cell;
    for (cell[u] = lo[u]; cell[u] <= hi[u]; ++cell[u])
      for (cell[v] = lo[v]; cell[v] <= hi[v]; ++cell[v]) {
        Vec3 centre = lower_;
        centre[u] += (cell[u] + 0.5) * edge;
        centre[v] += (cell[v] + 0.5) * edge;
        centre[w] = t.point[w];
        const double middle = t.point[w] - plane_distance(t, centre) / t.normal[w];
        const double from = ((middle - half_height) - lower_[w]) * inverse_edge_ - 0.5;
        const double to = ((middle + half_height) - lower_[w]) * inverse_edge_ - 0.5;
        const int first = std::max(lo[w], cell_index(from - 1e-6, cells_[w]));
        const int last = std::min(hi[w], cell_index(to + 1 + 1e-6, cells_[w]));
        for (cell[w] = first; cell[w] <= last; ++cell[w]) {
          centre[w] = lower_[w] + (cell[w] + 0.5) * edge;
          if (closest(t, centre).distance > near_enough) continue;
          const auto id = (static_cast<std::int64_t>(cell[2]) * cells_[1] + cell[1]) * cells_[0] + cell[0];
          hits.emplace_back(static_cast<std::int32_t>(id), static_cast<std::int32_t>(f));
          if (hits.size() > limit && !unlimited) return false;
        }
      }
  }

  first_.assign(total + 1, 0);
  for (const auto& [cell, facet] : hits) ++first_[cell + 1];
  for (std::size_t c = 0; c < total; ++c) first_[c + 1] += first_[c];
  facets_.resize(hits.size());
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (const auto& [cell, facet] : hits) facets_[next[cell]++] = facet;
  return true;
}

std::span<const std::int32_t> FacetGrid::near(Vec3 c) const noexcept {
  if (first_.empty()) return {};
  std::array<int, 3> cell;
  for (int k = 0; k < 3; ++k) {
    if (!(c[k] >= lower_[k] && c[k] <= upper_[k])) return {};
    cell[k] = cell_index((c[k] - lower_[k]) * inverse_edge_, cells_[k]);
  }
  const std::int64_t id = (static_cast<std::int64_t>(cell[2]) * cells_[1] + cell[1]) * cells_[0] + cell[0];
  return {facets_.data() + first_[id], static_cast<std::size_t>(first_[id + 1] - first_[id])};
}

}  // namespace talus
