// Counter-based random numbers: the value is a pure function of (seed, stream, counter), so that nothing but a counter
// has to be saved, and no draw depends on who drew before (DESIGN I4, I6).
// Who calls it: core/grains/insertion.cpp, test and packing generators. Invariants: integer mixing and exact
// conversions only.
#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/det_math.hpp"

namespace talus {

/// Bijective 64-bit finaliser (two multiply-xorshift rounds with the SplitMix64 constants).
inline constexpr std::uint64_t mix64(std::uint64_t z) noexcept {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// One stream of random numbers, addressed by counter. Copyable, stateless.
class CounterRng {
 public:
  /// Streams with different (seed, stream, substream) are independent for all practical purposes.
  constexpr CounterRng(std::uint64_t seed, std::uint64_t stream, std::uint64_t substream = 0) noexcept
      : key_(mix64(mix64(mix64(seed + k_step) + stream * k_step + 1) + substream * k_step + 2)) {}

  /// 64 random bits of draw `counter`.
  constexpr std::uint64_t bits(std::uint64_t counter) const noexcept {
    return mix64(mix64(counter * k_step + key_) ^ (key_ >> 32 | key_ << 32));
  }
  /// Uniform in [0, 1) with 53 random bits.
  double uniform(std::uint64_t counter) const noexcept { return static_cast<double>(bits(counter) >> 11) * 0x1p-53; }
  /// Uniform in [low, high).
  double uniform(std::uint64_t counter, double low, double high) const noexcept {
    return low + (high - low) * uniform(counter);
  }
  /// Standard normal (Box and Muller); uses the two sub-draws 2*counter and 2*counter + 1.
  double normal(std::uint64_t counter) const noexcept {
    const double u = 1 - uniform(2 * counter);  // (0, 1]
    return std::sqrt(-2 * det::log(u)) * det::sincos_turns(uniform(2 * counter + 1)).cos;
  }

 private:
  static constexpr std::uint64_t k_step = 0x9e3779b97f4a7c15ULL;  // odd: counter * k_step is a bijection
  std::uint64_t key_;
};

}  // namespace talus
