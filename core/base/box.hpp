// Box: the computational box as arithmetic sees it, and the one place of the minimum image. Who uses it: whoever takes
// differences of positions. Kernels get half(k) and period(k) and apply the same rule to lanes. Invariant (I4): compare
// and select, no rounding, so that the image has the same bits everywhere.
#pragma once

#include <array>

#include "core/base/types.hpp"

namespace talus {

struct Box {
  Vec3 size;  ///< [m]
  std::array<bool, 3> periodic{};

  double period(int k) const noexcept { return periodic[static_cast<std::size_t>(k)] ? size[k] : 0.0; }
  /// Half a period; where nothing wraps, beyond every difference.
  double half(int k) const noexcept { return periodic[static_cast<std::size_t>(k)] ? 0.5 * size[k] : 1e300; }

  /// Image of d along axis k: -1, 0 or 1 periods away. d: less than one and a half periods, as between two positions in
  /// the box; exactly half a period stays as it is.
  int wraps(int k, double d) const noexcept { return d > half(k) ? 1 : (d < -half(k) ? -1 : 0); }
  double nearest(int k, double d) const noexcept {
    const double h = half(k), p = period(k);
    return d > h ? d - p : (d < -h ? d + p : d);
  }
  Vec3 nearest(Vec3 d) const noexcept { return {nearest(0, d.x), nearest(1, d.y), nearest(2, d.z)}; }

  /// The same for d of any number of periods, as between positions that were not wrapped.
  Vec3 nearest_of_any(Vec3 d) const noexcept {
    for (int k = 0; k < 3; ++k)
      if (periodic[static_cast<std::size_t>(k)]) d[k] = d[k] - size[k] * __builtin_floor(d[k] / size[k] + 0.5);
    return d;
  }
};

}  // namespace talus
