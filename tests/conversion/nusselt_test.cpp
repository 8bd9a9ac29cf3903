// Nusselt numbers of grains in beds, and the view that grains have of each other, against figures.
#include <gtest/gtest.h>

#include "core/heat/convection.hpp"
#include "core/heat/radiation.hpp"

namespace talus::heat {
namespace {

TEST(Nusselt, LawsHaveTheirPublishedValues) {
  // Pr 0.7, porosity 0.4: Gunn, Whitaker, Ranz and Marshall, Wakao
  const double Re[] = {1, 10, 100, 1000};
  const double expected[][4] = {{6.661, 2.399, 2.533, 2.977},
                                {10.044, 3.338, 3.685, 5.888},
                                {22.267, 6.589, 7.327, 17.480},
                                {76.02, 18.17, 18.85, 63.63}};
  const NusseltLaw laws[] = {NusseltLaw::gunn, NusseltLaw::whitaker, NusseltLaw::ranz_marshall, NusseltLaw::wakao};
  for (std::size_t k = 0; k < 4; ++k)
    for (std::size_t l = 0; l < 4; ++l)
      EXPECT_NEAR(nusselt(laws[l], Re[k], 0.7, 0.4) / expected[k][l], 1, 3e-4) << Re[k] << " " << l;
}

TEST(Nusselt, CoefficientIsThatOfTheVelocityPastTheGrain) {
  const GasAt gas{300, {0, 0, 3}, 1.2, 1.8e-5, 0.026, 0.7, 1};
  const double d = 0.005, Re = 1.2 * 2 * d / 1.8e-5;
  EXPECT_NEAR(film_coefficient(NusseltLaw::ranz_marshall, gas, {0, 0, 1}, d),
              nusselt(NusseltLaw::ranz_marshall, Re, 0.7, 1) * 0.026 / d, 1e-12);
}

TEST(ExchangeArea, IsTheSameFromBothSidesAndExactFarAway) {
  EXPECT_EQ(exchange_area(0.001, 0.003, 0.0047), exchange_area(0.003, 0.001, 0.0047));
  const double r = 0.001, q = 0.002, d = 0.5;
  EXPECT_NEAR(exchange_area(r, q, d) / (det::k_pi * r * r * q * q / (d * d)), 1, 1e-4);
  EXPECT_EQ(radiant_slope(300, 400), radiant_slope(400, 300));
  EXPECT_EQ(grey_factor(1, 1), 1);
  EXPECT_EQ(grey_factor(0, 1), 0);
}

}  // namespace
}  // namespace talus::heat
