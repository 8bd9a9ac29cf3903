// Output steps and slice length; see schedule.hpp.
#include "scheduler/run/schedule.hpp"

#include <algorithm>
#include <limits>

#include "core/base/count.hpp"

namespace talus {
namespace {
constexpr std::int64_t k_none = std::numeric_limits<std::int64_t>::max();
constexpr double k_slice_s = 0.2;     // well below the second within which a signal must be answered
constexpr std::int64_t k_growth = 4;  // a slice that happened to hold no rebuild must not make the next one huge
}  // namespace

std::int64_t Repeat::after(std::int64_t step) const noexcept {
  if (!on()) return k_none;
  if (ratio_ <= 1) return step + 1;  // every step has one
  // Start one output too early and walk: rounding of k * ratio may be off by one either way.
  for (std::int64_t k = std::max<std::int64_t>(0, count_floor(static_cast<double>(step) / ratio_) - 1);; ++k) {
    const double at = static_cast<double>(k) * ratio_;
    if (!(at < static_cast<double>(k_most_count))) return k_none;
    if (const std::int64_t due_step = count_nearest(at); due_step > step) return due_step;
  }
}

bool Repeat::due(std::int64_t step) const noexcept { return on() && step >= 0 && after(step - 1) == step; }

std::int64_t Slicer::next(std::int64_t now, std::int64_t until) const noexcept {
  return std::clamp<std::int64_t>(until - now, 0, length_);
}

void Slicer::measured(std::int64_t steps, double seconds) noexcept {
  const double wanted = seconds > 0 ? k_slice_s * static_cast<double>(steps) / seconds : 1e9;
  const double limit = static_cast<double>(std::max(steps, length_) * k_growth);
  length_ = count_floor(wanted, 1, count_floor(std::min(limit, 1e8), 1));
}

}  // namespace talus
