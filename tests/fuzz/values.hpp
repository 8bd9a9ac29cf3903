// Numbers out of the bytes of an input; zeros when they are used up.
#pragma once

#include <limits>

#include "tests/fuzz/targets.hpp"

namespace talus::fuzz {

class Values {
 public:
  explicit Values(Bytes b) : b_(b) {}
  bool left() const { return at_ < b_.size(); }
  unsigned byte() { return left() ? b_[at_++] : 0U; }
  int below(int n) { return static_cast<int>(byte()) % n; }
  int flag() { return static_cast<int>(byte() & 1U); }
  /// In [0, 1).
  double fraction() {
    const unsigned high = byte(), low = byte();
    return (high * 256 + low + 0.5) * 0x1p-16;
  }
  double between(double low, double high) { return low + (high - low) * fraction(); }
  /// Every kind of double: zeros of both signs, denormal, huge, infinite, none at all; mostly ordinary.
  double any() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    static constexpr double k_special[] = {
        0.0,   -0.0,   1.0,    -1.0,   5e-324,   -2e-308,   1e-300, 1e300,
        1e150, -1e150, 1e-155, 3.0e-8, infinity, -infinity, 0.5,    std::numeric_limits<double>::quiet_NaN()};
    const unsigned kind = byte();
    if (kind < 16) return k_special[kind];
    return between(-1, 1) * (kind < 64 ? 10 : 1);
  }

 private:
  Bytes b_;
  std::size_t at_ = 0;
};

}  // namespace talus::fuzz
