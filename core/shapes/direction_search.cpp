// Implementation of direction_search.hpp.
#include "core/shapes/direction_search.hpp"

#include <algorithm>
#include <vector>

namespace talus::shapes {
namespace {

using Vector = Triple<Plain>;

/// Corner of cells: direction and the plane below the overlap there: overlap >= slope . n, equal at the corner.
struct Corner {
  Vector n, slope;
  double overlap;
};
struct Cell {
  Corner corner[3];
  double bound;
};

Corner corner_at(const PairForm<Plain>& p, Vector n) noexcept {
  const Vector m = to_j<Plain>(p, n);
  const Support<Plain> i = support<Plain>(p.i, n, k_eta), j = support<Plain>(p.j, {-m.x, -m.y, -m.z}, k_eta);
  const Vector xj = from_j<Plain>(p, j.point);
  return {n,
          {(i.point.x - xj.x) - p.d.x, (i.point.y - xj.y) - p.d.y, (i.point.z - xj.z) - p.d.z},
          (i.h + j.h) - dot<Plain>(n, p.d)};
}

/// Lower bound over the cell: on it n = v / |v| with v in the flat triangle, and |v| between `least` and 1.
double bound_of(const Cell& c) noexcept {
  const Corner* k = c.corner;
  const Vector middle{(k[0].n.x + k[1].n.x) + k[2].n.x, (k[0].n.y + k[1].n.y) + k[2].n.y,
                      (k[0].n.z + k[1].n.z) + k[2].n.z};
  // The distance of the flat triangle's plane from the origin is at most |v| everywhere on it.
  const Vector a{k[1].n.x - k[0].n.x, k[1].n.y - k[0].n.y, k[1].n.z - k[0].n.z};
  const Vector b{k[2].n.x - k[0].n.x, k[2].n.y - k[0].n.y, k[2].n.z - k[0].n.z};
  const Vector w{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  const double area = __builtin_sqrt(dot<Plain>(w, w));
  double least = area > 1e-30 ? __builtin_fabs(dot<Plain>(w, middle)) / (3 * area) : 1;
  if (least > 1) least = 1;
  double best = -1e300;
  for (int s = 0; s < 3; ++s) {
    double low = 1e300;
    for (int v = 0; v < 3; ++v) low = std::min(low, dot<Plain>(k[s].slope, k[v].n));
    best = std::max(best, low < 0 ? low / least : low);
  }
  return best;
}

Cell cell_of(const Corner& a, const Corner& b, const Corner& c) noexcept {
  Cell cell{{a, b, c}, 0};
  cell.bound = bound_of(cell);
  return cell;
}

Corner between(const PairForm<Plain>& p, const Corner& a, const Corner& b) noexcept {
  return corner_at(p, unit<Plain>({a.n.x + b.n.x, a.n.y + b.n.y, a.n.z + b.n.z}));
}

}  // namespace

Direction search_directions(const PairForm<Plain>& p, double tolerance, double width) noexcept {
  constexpr std::size_t k_cells = 20000;
  Direction best;
  best.overlap = 1e300;
  const auto look = [&](const Corner& c) {
    ++best.evaluations;
    if (c.overlap < best.overlap) best.n = c.n, best.overlap = c.overlap;
  };
  Corner axis[6];
  for (int k = 0; k < 6; ++k) {
    const double s = k % 2 == 0 ? 1 : -1;
    axis[k] = corner_at(p, {k / 2 == 0 ? s : 0, k / 2 == 1 ? s : 0, k / 2 == 2 ? s : 0});
    look(axis[k]);
  }
  std::vector<Cell> cells, next;
  for (int octant = 0; octant < 8; ++octant)
    cells.push_back(cell_of(axis[octant & 1], axis[2 + ((octant >> 1) & 1)], axis[4 + (octant >> 2)]));
  best.width = 2;
  while (best.width > width) {
    next.clear();
    for (const Cell& c : cells) {
      if (c.bound > best.overlap - tolerance && best.width < 0.6) continue;
      const Corner *k = c.corner, ab = between(p, k[0], k[1]), bc = between(p, k[1], k[2]), ca = between(p, k[2], k[0]);
      look(ab);
      look(bc);
      look(ca);
      next.push_back(cell_of(k[0], ab, ca));
      next.push_back(cell_of(ab, k[1], bc));
      next.push_back(cell_of(ca, bc, k[2]));
      next.push_back(cell_of(ab, bc, ca));
    }
    best.width = 0.5 * best.width;
    std::erase_if(next, [&](const Cell& c) { return c.bound > best.overlap - tolerance; });
    if (next.empty() || next.size() > k_cells) break;  // found to the tolerance, or directions that hardly differ
    cells.swap(next);
  }
  return best;
}

}  // namespace talus::shapes
