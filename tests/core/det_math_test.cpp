// Claims about core/base/det_math.hpp and core/base/rng.hpp, measured against the C library in long double.
#include "core/base/det_math.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/base/rng.hpp"

namespace talus {
namespace {

constexpr double k_tolerance = 1e-15;

double relative_error(double value, long double exact) {
  return static_cast<double>(std::fabs((static_cast<long double>(value) - exact) / exact));
}

TEST(DetMath, LogAgreesWithLibmOverAllExponents) {
  const CounterRng rng(7, 1);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const double x = std::ldexp(1 + rng.uniform(2 * i), static_cast<int>(rng.uniform(2 * i + 1) * 2100) - 1074);
    if (x == 1 || x == 0 || std::isinf(x)) continue;
    worst = std::fmax(worst, relative_error(det::log(x), logl(x)));
  }
  EXPECT_LT(worst, k_tolerance);
}

TEST(DetMath, LogKeepsRelativeAccuracyNextToOne) {
  double worst = 0;
  for (int k = 1; k < 52; ++k) {
    for (double sign : {-1.0, 1.0}) {
      const double x = 1 + sign * std::ldexp(1.0, -k);
      worst = std::fmax(worst, relative_error(det::log(x), logl(x)));
    }
  }
  EXPECT_LT(worst, k_tolerance);
  EXPECT_EQ(det::log(1.0), 0.0);
}

TEST(DetMath, LogAndExpHandleTheEndsOfTheRange) {
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(det::log(0.0), -inf);
  EXPECT_EQ(det::log(inf), inf);
  EXPECT_TRUE(std::isnan(det::log(-1.0)));
  EXPECT_EQ(det::exp(0.0), 1.0);
  EXPECT_EQ(det::exp(710.0), inf);
  EXPECT_EQ(det::exp(-746.0), 0.0);
  EXPECT_EQ(det::exp(-inf), 0.0);
  EXPECT_TRUE(std::isnan(det::exp(std::nan(""))));
  EXPECT_NEAR(det::exp(-745.0) / 4.94065645841246544e-324, 1.0, 0.5);
}

TEST(DetMath, ExpAgreesWithLibm) {
  const CounterRng rng(7, 2);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const double x = i % 2 == 0 ? rng.uniform(i, -700, 709) : rng.uniform(i, -1, 1);
    worst = std::fmax(worst, relative_error(det::exp(x), expl(x)));
  }
  EXPECT_LT(worst, k_tolerance);
}

TEST(DetMath, SineAndCosineOfTurnsAgreeWithLibm) {
  const CounterRng rng(7, 3);
  const long double two_pi = 2 * acosl(-1.0L);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const double t = rng.uniform(i, -0.5, 0.5);
    const auto [s, c] = det::sincos_turns(t);
    worst = std::fmax(worst, static_cast<double>(std::fabs(s - sinl(two_pi * t))));
    worst = std::fmax(worst, static_cast<double>(std::fabs(c - cosl(two_pi * t))));
    if (std::fabs(t) < 0.124) worst = std::fmax(worst, relative_error(s, sinl(two_pi * t)));
  }
  EXPECT_LT(worst, k_tolerance);
}

TEST(DetMath, PhaseIsReducedExactly) {
  for (double n : {0.0, 1.0, 3.0, 1e6, 1e15, -1e9, -7.0, 0x1p60}) {
    EXPECT_EQ(det::sincos_turns(n).sin, 0.0) << n;
    EXPECT_EQ(det::sincos_turns(n).cos, 1.0) << n;
  }
  const double base = 0.1328125;  // exactly representable with the integers added below
  const auto expected = det::sincos_turns(base);
  for (double n : {1.0, -1.0, 12345.0, 1e9, -1e9}) {
    EXPECT_EQ(det::sincos_turns(base + n).sin, expected.sin) << n;
    EXPECT_EQ(det::sincos_turns(base + n).cos, expected.cos) << n;
    EXPECT_EQ(det::fraction(base + n), base) << n;
  }
  const double quarters[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
  for (int q = -8; q <= 8; ++q) {
    EXPECT_EQ(det::sincos_turns(0.25 * q).sin, quarters[(q + 8) % 4][0]) << q;
    EXPECT_EQ(det::sincos_turns(0.25 * q).cos, quarters[(q + 8) % 4][1]) << q;
  }
  EXPECT_TRUE(std::isnan(det::sincos_turns(std::numeric_limits<double>::infinity()).sin));
}

TEST(DetMath, FractionStaysBelowOne) {
  EXPECT_EQ(det::fraction(-1e-300), 0.0);
  EXPECT_EQ(det::fraction(-0.25), 0.75);
  EXPECT_EQ(det::fraction(2.5), 0.5);
  EXPECT_EQ(det::fraction(1e300), 0.0);
}

TEST(DetMath, RootsAndPowersAgreeWithLibm) {
  const CounterRng rng(7, 4);
  double worst_root = 0, worst_power = 0;
  for (int i = 0; i < 50000; ++i) {
    const double x = std::ldexp(1 + rng.uniform(3 * i), static_cast<int>(rng.uniform(3 * i + 1) * 200) - 100);
    worst_root = std::fmax(worst_root, relative_error(det::cbrt(x), cbrtl(x)));
    const double y = rng.uniform(3 * i + 2, -3, 3);
    worst_power = std::fmax(worst_power, relative_error(det::pow(x, y), powl(x, y)) / (1 + std::fabs(y * std::log(x))));
  }
  EXPECT_LT(worst_root, k_tolerance);
  EXPECT_LT(worst_power, 4e-16);
  EXPECT_EQ(det::cbrt(-27.0), -3.0);
  EXPECT_EQ(det::pow(0.0, 2.0), 0.0);
  EXPECT_EQ(det::pow(5.0, 0.0), 1.0);
}

TEST(DetMath, RoundingToIntegersIsExact) {
  EXPECT_EQ(det::nearest(2.5), 3);
  EXPECT_EQ(det::nearest(-2.5), -3);
  EXPECT_EQ(det::nearest(0.49999999999999994), 0);
  EXPECT_EQ(det::floor_int(-0.5), -1);
  EXPECT_EQ(det::floor_int(-3.0), -3);
  EXPECT_EQ(det::floor_int(3.999), 3);
  EXPECT_EQ(det::floor_int(1e300), std::int64_t{1} << 62);
}

TEST(Rng, ValuesDependOnSeedStreamAndCounterAlone) {
  const CounterRng a(1, 2, 3), b(1, 2, 3), c(2, 2, 3), d(1, 3, 3), e(1, 2, 4);
  int same = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    EXPECT_EQ(a.bits(i), b.bits(i));
    same += a.bits(i) == c.bits(i) || a.bits(i) == d.bits(i) || a.bits(i) == e.bits(i) || a.bits(i) == a.bits(i + 1);
  }
  EXPECT_EQ(same, 0);
}

TEST(Rng, UniformFillsTheUnitIntervalEvenly) {
  const CounterRng rng(42, 0);
  constexpr int bins = 100, draws = 1000000;
  std::vector<int> count(bins);
  double correlation = 0;
  for (int i = 0; i < draws; ++i) {
    const double u = rng.uniform(i);
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    ++count[static_cast<int>(u * bins)];
    correlation += (u - 0.5) * (rng.uniform(i + 1) - 0.5);
  }
  double chi2 = 0;
  for (int c : count) chi2 += (c - draws / bins) * static_cast<double>(c - draws / bins) / (draws / bins);
  EXPECT_LT(chi2, 148.0);  // 99 degrees of freedom, 0.1 %
  EXPECT_GT(chi2, 60.0);
  EXPECT_LT(std::fabs(correlation * 12 / draws), 0.004);
}

TEST(Rng, NormalHasUnitVarianceAndGaussianTails) {
  const CounterRng rng(42, 1);
  constexpr int draws = 400000;
  double sum = 0, sum2 = 0, sum4 = 0;
  for (int i = 0; i < draws; ++i) {
    const double z = rng.normal(i);
    sum += z;
    sum2 += z * z;
    sum4 += z * z * z * z;
  }
  EXPECT_NEAR(sum / draws, 0, 0.008);
  EXPECT_NEAR(sum2 / draws, 1, 0.012);
  EXPECT_NEAR(sum4 / draws, 3, 0.08);
}

}  // namespace
}  // namespace talus
