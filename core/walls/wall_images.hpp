// Periodic images of a wall. On a periodic axis the wall stands at every whole number of box lengths from where the
// scene puts it, and a grain meets the image that is near. Who calls it: core/walls/walls.cpp.
// Invariants: I1 (every image that a grain of the domain can reach has a slot of its own), I4 (an image is its whole
// number of periods: the same for every list, and its shift is one product).
#pragma once

#include <array>
#include <cstdint>

#include "core/base/types.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// Whole periods along each axis.
using Periods = std::array<std::int64_t, 3>;

/// The images of one wall that can act in the domain. Each has a slot, its number of periods modulo the number of
/// slots: as the wall moves on, an image keeps its slot for as long as it can act.
class WallImages {
 public:
  /// No images but the wall itself.
  WallImages() = default;
  /// `lower`, `upper` [m]: box around the wall in its body frame. `margin` [m]: a wall that never comes nearer to a
  /// periodic side has no images along that axis. Error{scene} for a wall of more than k_longest box lengths.
  WallImages(const Domain& domain, const WallSpec& wall, Vec3 lower, Vec3 upper, double margin);

  static constexpr double k_longest = 64;    ///< length of a wall / period: beyond it the scale is wrong
  static constexpr double k_farthest = 1e6;  ///< periods that a wall may be away: beyond it rounding spoils contacts

  bool any() const noexcept { return count_ > 1; }
  std::int32_t count() const noexcept { return count_; }  ///< number of slots
  Vec3 period() const noexcept { return period_; }        ///< [m], 0 along an axis without images

  /// Tells where the wall is now [m]: a box around it in the world. False where it is farther than k_farthest.
  bool place(Vec3 lower, Vec3 upper) noexcept;
  std::array<Vec3, 2> box() const noexcept { return {lower_, upper_}; }
  /// How far c is from the box at least, along the axes that have images [m].
  double away(Vec3 c) const noexcept {
    double most = 0;
    for (int k = 0; k < 3; ++k)
      if (slots_[k] > 1) most = fmax2(most, fmax2(lower_[k] - c[k], c[k] - upper_[k]));
    return most;
  }
  /// The image in a slot.
  Periods image(std::int32_t slot) const noexcept {
    Periods m = first_;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t n = slots_[k];
      if (n == 1) continue;
      const std::int32_t ahead = slot % n - first_slot_[k];
      m[k] += ahead < 0 ? ahead + n : ahead;
      slot /= n;
    }
    return m;
  }
  /// Displacement [m] of an image from the wall itself.
  Vec3 shift(const Periods& image) const noexcept {
    return {static_cast<double>(image[0]) * period_.x, static_cast<double>(image[1]) * period_.y,
            static_cast<double>(image[2]) * period_.z};
  }
  /// Calls f(slot, image) for every image whose box comes within `reach` [m] of c, along the axes that have images.
  template <class F>
  void for_near(Vec3 c, double reach, F f) const;
  /// Calls f(slot, image) for every slot.
  template <class F>
  void for_all(F f) const {
    for (std::int32_t s = 0; s < count_; ++s) f(s, image(s));
  }

 private:
  Vec3 period_, from_;  ///< lower corner of the domain [m]
  Vec3 lower_, upper_;  ///< box around the wall now [m]
  Vec3 margin_;         ///< of the domain, within which images are counted [m]
  std::array<std::int32_t, 3> slots_{1, 1, 1};
  std::int32_t count_ = 1;
  Periods first_{0, 0, 0};                           ///< the lowest image that has a slot now
  std::array<std::int32_t, 3> first_slot_{0, 0, 0};  ///< and its slot along each axis
};

template <class F>
void WallImages::for_near(Vec3 c, double reach, F f) const {
  std::array<std::int32_t, 3> from{0, 0, 0}, to{0, 0, 0};  // counted from the first image
  for (int k = 0; k < 3; ++k) {
    if (slots_[k] == 1) continue;
    const double base = c[k] - static_cast<double>(first_[k]) * period_[k];
    for (std::int32_t& q = from[k]; q < slots_[k] && base - q * period_[k] > upper_[k] + reach; ++q) {
    }
    to[k] = from[k];
    while (to[k] < slots_[k] && base - to[k] * period_[k] >= lower_[k] - reach) ++to[k];
    --to[k];
  }
  Periods q{0, 0, 0};
  for (q[2] = from[2]; q[2] <= to[2]; ++q[2])
    for (q[1] = from[1]; q[1] <= to[1]; ++q[1])
      for (q[0] = from[0]; q[0] <= to[0]; ++q[0]) {
        std::int32_t slot = 0;
        for (int k = 2; k >= 0; --k) {
          const auto own = first_slot_[k] + static_cast<std::int32_t>(q[k]);
          slot = slot * slots_[k] + (own >= slots_[k] ? own - slots_[k] : own);
        }
        f(slot, Periods{first_[0] + q[0], first_[1] + q[1], first_[2] + q[2]});
      }
}

/// Refuses a plane that is not its own image along every periodic axis, at some time of its motion: Error{scene}.
void require_periodic_plane(const Domain& domain, const WallSpec& plane);

}  // namespace talus
