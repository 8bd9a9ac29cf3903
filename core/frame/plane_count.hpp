// Flux planes: which grains pass them, and the totals. Who calls it: scheduler/nodes/plane_count.cpp in every step, the
// scene parser (meets). Invariants: nothing here influences a trajectory; a passage is a function of the stored
// positions before and after one step, so that totals depend on the trajectory alone; sides are those of stored
// positions, so that the net passages of a grain always are the difference of its sides, however often it goes to and
// fro.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// Passages of grains' centres through a plane since the start of the trajectory.
struct PlaneTotal {
  std::int64_t forward = 0, backward = 0;  ///< along the normal, against it
  double mass = 0;                         ///< forward less backward [kg]
  std::int64_t particles() const noexcept { return forward - backward; }
};

/// The part of a plane that lies in the domain. A grain exactly on it is on its upper side: the one of larger
/// coordinates on the first axis that the normal is not perpendicular to; so turning the normal round changes the sign
/// of the count and nothing else, and a plane in an open side counts exactly the grains that leave there. A plane
/// across a periodic axis counts once per round, and the two ends of the axis are the same plane. An oblique plane
/// has no images: what wraps beside it has not passed it.
class CountedPlane {
 public:
  CountedPlane(const Domain& domain, const OutputSettings::Plane& plane);
  /// Net passages along the normal in one step from `a` to `b`, stored positions (relative to the domain's lower
  /// corner, wrapped). A step is shorter than half a period.
  int passages(const double* a, const double* b) const noexcept;
  /// found(row, net) for rows [lo, hi) of {x, y, z, r} that pass in the step from `a` to `b`, ascending.
  template <class Found>
  void find(const double* a, const double* b, Row lo, Row hi, Found found) const {
    const auto report = [&](Row i) {
      if (const int net = passages(a + 4L * i, b + 4L * i); net != 0) found(i, net);
    };
    if (axis_ < 0) {
      for (Row i = lo; i < hi; ++i)
        if (side(a + 4L * i) != side(b + 4L * i) || (periodic_ && wraps(a + 4L * i, b + 4L * i))) report(i);
      return;
    }
    // the usual plane; locals, since the compiler has to expect that report() changes members
    const double offset = offset_, half = half_[axis_], *from = a + axis_, *to = b + axis_;
    for (Row i = lo; i < hi; ++i) {
      const double x = from[4L * i], y = to[4L * i];
      if (__builtin_expect(((x >= offset) != (y >= offset)) | (std::abs(y - x) > half), 0)) report(i);
    }
  }
  /// False: it does not meet the domain, and nothing can ever pass.
  bool meets() const noexcept;

 private:
  bool side(const double* x) const noexcept {
    return axis_ >= 0 ? x[axis_] >= offset_ : (normal_.x * x[0] + normal_.y * x[1]) + normal_.z * x[2] >= offset_;
  }
  /// The step goes through a periodic side that the plane is not perpendicular to.
  bool wraps(const double* a, const double* b) const noexcept {
    for (int k = 0; k < 3; ++k)
      if (std::abs(b[k] - a[k]) > half_[k]) return true;
    return false;
  }
  int jumps(const double* a, const double* b) const noexcept;

  Vec3 normal_;  ///< its first non-zero component is positive
  Vec3 size_;    ///< of the domain [m]
  Vec3 half_;    ///< half a period [m]; infinite where wrapping does not matter
  double offset_ = 0;
  int axis_ = -1;  ///< the one that the plane is perpendicular to; -1: oblique
  int sign_ = 1;   ///< of the scene's normal against normal_
  bool periodic_ = false;
};

/// All planes of a scene with their totals.
class PlaneCounts {
 public:
  PlaneCounts() = default;
  explicit PlaneCounts(const Scene& scene);
  const std::vector<CountedPlane>& planes() const noexcept { return planes_; }
  const std::vector<PlaneTotal>& totals() const noexcept { return totals_; }
  void begin_step() { before_ = totals_; }
  void add(std::int32_t plane, int net, double mass) noexcept;
  /// Back to the last begin_step(): the step has failed.
  void take_back() { totals_ = before_; }
  /// Names, places and totals as bytes for the checkpoint (section "planes"), and back. A plane of the scene that the
  /// bytes do not name starts from zero. Error{io}: damaged, or a plane of that name was elsewhere.
  std::vector<std::uint8_t> save() const;
  void load(std::span<const std::uint8_t> bytes, const std::string& where);
  std::uint64_t hash() const;  ///< of the saved bytes

 private:
  std::vector<OutputSettings::Plane> specs_;
  std::vector<CountedPlane> planes_;
  std::vector<PlaneTotal> totals_, before_;
};

}  // namespace talus
