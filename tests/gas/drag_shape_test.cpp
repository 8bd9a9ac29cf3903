// Drag of grains that are no spheres: Ganser's (1993) factors against other people's measurements and closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/words.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/exchange.hpp"

namespace talus::gas {
namespace {

TEST(DragShape, OfASphereLeavesEveryLawToTheBit) {
  const DragShape sphere = drag_shape(1);
  for (const GasDrag law : {GasDrag::ergun, GasDrag::gidaspow, GasDrag::di_felice, GasDrag::beetstra})
    for (const double e : {0.4, 0.8, 1.0})
      for (const double slip : {0.0, 1e-3, 0.3, 40.0})
        EXPECT_EQ(grain_drag(law, e, 2e-3, 1.7e-3, 1.8e-5, 1.2, slip, sphere),
                  grain_drag(law, e, 2e-3, 1.7e-3, 1.8e-5, 1.2, slip));
}

/// Pettyjohn and Christiansen (1948), cubes, octahedra, cube octahedra, tetrahedra: Stokes' velocity is that of the
/// sphere times 0.843 lg(psi / 0.065), Newton's coefficient of drag 5.31 - 4.88 psi. Measured to some per cent.
TEST(DragShape, OfIsometricGrainsIsWhatWasMeasured) {
  for (const double psi : {0.67, 0.806, 0.846, 0.906}) {
    const DragShape s = drag_shape(psi);
    EXPECT_NEAR(s.stokes / (0.843 * std::log10(psi / 0.065)), 1, 0.05) << psi;
    EXPECT_NEAR(0.44 * s.newton / (5.31 - 4.88 * psi), 1, 0.1) << psi;
  }
}

/// Oberbeck (1876): resistance of a prolate spheroid along and across its axis over that of the sphere of its volume;
/// all turns alike it is three over the sum of the inverse three.
TEST(DragShape, OfSpheroidsIsOberbecksMeanOfAllTurns) {
  for (const double b : {1.5, 2.0, 3.0, 4.0}) {
    const double f = b * b - 1, root = std::sqrt(f), lg = std::log(b + root);
    const double along = 4.0 / 3 * f / std::cbrt(b) / ((2 * b * b - 1) / root * lg - b);
    const double across = 8.0 / 3 * f / std::cbrt(b) / ((2 * b * b - 3) / root * lg + b);
    const double e = root / b, area = 2 * M_PI * (1 + b / e * std::asin(e));
    const double psi = 4 * M_PI * std::cbrt(b) * std::cbrt(b) / area;
    EXPECT_NEAR((1 / drag_shape(psi).stokes) / (3 / (1 / along + 2 / across)), 1, 0.05) << b;
  }
  // two spheres that touch: 1.12 (Hinds 1999)
  EXPECT_NEAR(1 / drag_shape(std::pow(2, 2.0 / 3) / 2).stokes, 1.12, 0.01);
}

/// In the limits of small and of large Reynolds numbers laws of a single grain give the factors themselves.
TEST(DragShape, ActsAsItsNamesSay) {
  const DragShape s = drag_shape(0.8);
  const auto ratio = [&](GasDrag law, double slip) {
    return grain_drag(law, 1, 1e-3, 1e-3, 1.8e-5, 1.2, slip, s) / grain_drag(law, 1, 1e-3, 1e-3, 1.8e-5, 1.2, slip);
  };
  for (const GasDrag law : {GasDrag::gidaspow, GasDrag::di_felice}) {
    EXPECT_NEAR(ratio(law, 1e-9), 1 / s.stokes, 1e-3) << enum_word(law);
    EXPECT_NEAR(ratio(law, 1e9), s.newton, 1e-3) << enum_word(law);
  }
  EXPECT_EQ(ratio(GasDrag::ergun, 1), 1) << "it goes by the Sauter diameter of the bed alone";
}

TEST(GasShare, OfAnEllipsoidIsThatOfTheStretchedBall) {
  const Grid g({0, 0, 0}, {4, 4, 4}, {1, 1, 4});
  std::vector<std::pair<int, double>> parts;
  const Vec3 reach{0.3, 0.7, 1.2};
  share(g, {2, 2, 2.4}, reach, parts);
  ASSERT_EQ(parts.size(), 3U);
  const double whole = 4 * M_PI / 3 * reach.x * reach.y * reach.z;
  const auto beyond = [](double t) { return (1 - t) * (1 - t) * (2 + t) / 4; };  // share of a ball beyond a plane
  EXPECT_NEAR(parts[2].second / whole, beyond(0.6 / 1.2), 1e-14);
  EXPECT_NEAR(parts[1].second / whole, 1 - beyond(0.6 / 1.2) - beyond(0.4 / 1.2), 1e-14);
  EXPECT_NEAR(parts[0].second / whole, beyond(0.4 / 1.2), 1e-14);
}

}  // namespace
}  // namespace talus::gas
