// Implementation of det_math.hpp. Series are truncated Taylor series: the reduced arguments are small enough that a few
// more terms than a minimax fit needs cost nothing in set-up code, and every coefficient can be checked by eye.
#include "core/base/det_math.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace talus::det {
namespace {

constexpr double k_inf = std::numeric_limits<double>::infinity();
constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
// ln 2 = k_ln2_hi + k_ln2_lo; the high part has 21 trailing zero bits, so that its product with an exponent is exact.
constexpr double k_ln2_hi = 0x1.62e42fee00000p-1;
constexpr double k_ln2_lo = 1.90821492927058770002e-10;
constexpr double k_two62 = 4611686018427387904.0;

/// 2^k as a double for k in [-1022, 1023].
double power_of_two(int k) noexcept { return std::bit_cast<double>(static_cast<std::uint64_t>(k + 1023) << 52); }

/// Integer nearest to x as a double, for |x| < 2^51: the addition pushes the fraction out of the mantissa.
double to_integer(double x) noexcept {
  constexpr double magic = 6755399441055744.0;  // 1.5 * 2^52
  return (x + magic) - magic;
}

}  // namespace

double log(double x) noexcept {
  if (!(x > 0)) return x == 0 ? -k_inf : k_nan;
  if (x == k_inf) return x;
  int exponent = 0;
  if (x < std::numeric_limits<double>::min()) {
    x = x * 0x1p54;
    exponent = -54;
  }
  std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  exponent += static_cast<int>(bits >> 52) - 1023;
  double m = std::bit_cast<double>((bits & 0x000fffffffffffffULL) | 0x3ff0000000000000ULL);
  if (m > 1.41421356237309504880) {
    m = m * 0.5;
    exponent += 1;
  }
  // log(1 + f) = 2 atanh(s) with s = f / (2 + f). With 2 s = f - s f this is f - (h - s (h + r)), h = f^2 / 2, where r
  // is the tail of the atanh series: the leading term f carries no rounding error.
  const double f = m - 1;
  const double s = f / (2 + f);
  const double z = s * s;
  double tail = 2.0 / 25;
  for (int k = 23; k >= 3; k -= 2) tail = 2.0 / k + z * tail;
  const double r = z * tail;
  const double h = 0.5 * f * f;
  const double e = exponent;
  return e * k_ln2_hi - ((h - (s * (h + r) + e * k_ln2_lo)) - f);
}

double exp(double x) noexcept {
  if (x != x) return x;
  if (x > 709.782712893384) return k_inf;
  if (x < -745.2) return 0;
  const double k = to_integer(x * 1.44269504088896340736);
  const double r = (x - k * k_ln2_hi) - k * k_ln2_lo;  // |r| <= 0.347
  double tail = 1.0 / 6227020800.0;                    // 1/13!
  constexpr double inverse_factorial[] = {1.0 / 2,       1.0 / 6,        1.0 / 24,       1.0 / 120,
                                          1.0 / 720,     1.0 / 5040,     1.0 / 40320,    1.0 / 362880,
                                          1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600};
  for (int i = 10; i >= 0; --i) tail = inverse_factorial[i] + r * tail;
  const double value = 1 + (r + r * r * tail);
  const int n = static_cast<int>(k);
  // Two factors, so that neither leaves the range of normal numbers while the product may.
  const int half = n / 2;
  return value * power_of_two(half) * power_of_two(n - half);
}

SinCos sincos_turns(double turns) noexcept {
  if (!(turns - turns == 0)) return {k_nan, k_nan};
  double t = turns;
  if (t > 0x1p51 || t < -0x1p51) t = fraction(t);
  t = t - to_integer(t);               // exact: both share the exponent of t or less
  const double q = to_integer(4 * t);  // quarter turn, -2 ... 2
  const double u = t - 0.25 * q;       // exact, |u| <= 1/8
  const double a = (2 * k_pi) * u;
  const double z = a * a;
  double ts = -1.0 / 121645100408832000.0;  // -1/19!
  constexpr double sine[] = {-1.0 / 6,
                             1.0 / 120,
                             -1.0 / 5040,
                             1.0 / 362880,
                             -1.0 / 39916800,
                             1.0 / 6227020800.0,
                             -1.0 / 1307674368000.0,
                             1.0 / 355687428096000.0};
  for (int i = 7; i >= 0; --i) ts = sine[i] + z * ts;
  const double s = a + a * (z * ts);
  double tc = -1.0 / 6402373705728000.0;  // -1/18!
  constexpr double cosine[] = {1.0 / 24,        -1.0 / 720,           1.0 / 40320,           -1.0 / 3628800,
                               1.0 / 479001600, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
  for (int i = 6; i >= 0; --i) tc = cosine[i] + z * tc;
  // 1 - z/2 loses the low bits of z/2; put them back.
  const double h = 0.5 * z;
  const double w = 1 - h;
  const double c = w + (((1 - w) - h) + z * z * tc);
  switch (static_cast<int>(q)) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case -1:
      return {-c, s};
    default:
      return {-s, -c};
  }
}

double fraction(double turns) noexcept {
  if (!(turns - turns == 0)) return k_nan;
  if (turns >= 0x1p52 || turns <= -0x1p52) return 0;  // integers
  double whole = static_cast<double>(static_cast<std::int64_t>(turns));
  if (whole > turns) whole -= 1;
  const double f = turns - whole;  // rounds only for tiny negative arguments, then possibly up to 1
  return f < 1 ? f : 0;
}

double atan(double x) noexcept {
  const double size = x < 0 ? -x : x;
  if (size > 1) {
    const double rest = 0.5 * k_pi - atan(1 / size);
    return x < 0 ? -rest : rest;
  }
  // three times the half angle: |t| < 0.0985
  double t = x;
  for (int k = 0; k < 3; ++k) t = t / (1 + std::sqrt(1 + t * t));
  const double q = t * t;
  double sum = 0;
  for (int k = 17; k > 1; k -= 2) sum = q * (1.0 / k - sum);
  return 8 * (t - t * sum);
}

double cbrt(double x) noexcept {
  if (x == 0 || !(x - x == 0)) return x;
  const double a = x < 0 ? -x : x;
  double y = exp(log(a) / 3);
  y = y - (y - a / y / y) / 3;  // one Newton step removes the error of the exponent
  return x < 0 ? -y : y;
}

double pow(double x, double y) noexcept {
  if (y == 0) return 1;
  if (x == 0) return y > 0 ? 0 : k_inf;
  return exp(y * log(x));
}

std::int64_t nearest(double x) noexcept {
  if (x != x) return 0;
  if (x >= k_two62) return static_cast<std::int64_t>(k_two62);
  if (x <= -k_two62) return -static_cast<std::int64_t>(k_two62);
  const std::int64_t whole = static_cast<std::int64_t>(x);  // towards zero
  const double rest = x - static_cast<double>(whole);       // exact
  if (rest >= 0.5) return whole + 1;
  if (rest <= -0.5) return whole - 1;
  return whole;
}

std::int64_t floor_int(double x) noexcept {
  if (x != x) return 0;
  if (x >= k_two62) return static_cast<std::int64_t>(k_two62);
  if (x <= -k_two62) return -static_cast<std::int64_t>(k_two62);
  const std::int64_t whole = static_cast<std::int64_t>(x);
  return static_cast<double>(whole) > x ? whole - 1 : whole;
}

}  // namespace talus::det
