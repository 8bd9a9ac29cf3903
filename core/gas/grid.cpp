// See grid.hpp.
#include "core/gas/grid.hpp"

#include "core/base/det_math.hpp"

namespace talus::gas {

Grid::Grid(Vec3 lo, Vec3 up, std::array<int, 3> count, std::array<bool, 3> wraps)
    : lower(lo), upper(up), n(count), periodic(wraps) {
  for (int k = 0; k < 3; ++k) h[k] = (up[k] - lo[k]) / n[static_cast<std::size_t>(k)];
  volume = h.x * h.y * h.z;
  area = {h.y * h.z, h.x * h.z, h.x * h.y};
  const int stride[3] = {1, n[0], n[0] * n[1]};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    for (int c = 0; c < cells(); ++c) {
      const int place = c / stride[axis] % n[a], last = n[a] - 1;
      if (place < last) inner.push_back({c, c + stride[axis], axis});
      if (periodic[a]) {
        if (place == last && last > 0) inner.push_back({c, c - last * stride[axis], axis});
        continue;
      }
      for (const bool high : {false, true}) {
        if (place != (high ? last : 0)) continue;
        Vec3 x = middle(c);
        x[axis] = high ? upper[axis] : lower[axis];
        outer.push_back({c, axis, high, x});
      }
    }
  }
}

Vec3 Grid::middle(int c) const noexcept {
  const int i = c % n[0], j = c / n[0] % n[1], k = c / (n[0] * n[1]);
  return lower + Vec3{(i + 0.5) * h.x, (j + 0.5) * h.y, (k + 0.5) * h.z};
}

int Grid::cell_of(Vec3 x) const noexcept {
  int at[3];
  for (int k = 0; k < 3; ++k) {
    const double q = (x[k] - lower[k]) / h[k];
    const int most = n[static_cast<std::size_t>(k)];
    if (!(q >= 0) || !(x[k] <= upper[k])) return -1;
    at[k] = static_cast<int>(fmin2(q, most - 1));
  }
  return index(at[0], at[1], at[2]);
}

}  // namespace talus::gas
