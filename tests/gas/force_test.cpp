// The force of the gas on the grains and what the gas loses to them are one sum, in any bed.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/det_math.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/species.hpp"
#include "tests/gas/gas_support.hpp"

namespace talus::gas::testing {
namespace {

/// Cells of random porosity, sizes, velocities and drag factors; some without grains, one overfull.
FromGrains uneven_bed(const Grid& g, unsigned seed) {
  std::mt19937 random(seed);
  const auto between = [&](double a, double b) { return a + (b - a) * static_cast<double>(random()) / 4294967296.0; };
  FromGrains s(g.cells());
  for (std::size_t c = 0; c < s.solid.size(); ++c) {
    if (c % 7 == 3) continue;
    s.solid[c] = (c == 5 ? 0.97 : between(0.07, 0.7)) * g.volume;
    s.specific[c] = s.solid[c] / between(1e-3, 4e-3);
    s.drag_factor[c] = between(0.7, 1.5);
    s.moment[c] = s.drag_factor[c] * s.solid[c] * Vec3{between(-.2, .2), between(-.2, .2), between(-.5, .5)};
  }
  return s;
}

/// What all grains get: drag and the push of the pressure gradient.
Vec3 force_on_grains(const Gas& gas, const FromGrains& grains) {
  const ToGrains& f = gas.fields();
  Vec3 sum;
  for (std::size_t c = 0; c < f.drag.size(); ++c) {
    const double e = f.porosity[c];
    Vec3 mean;
    if (grains.solid[c] > 0) mean = (1 / (grains.drag_factor[c] * grains.solid[c])) * grains.moment[c];
    sum = sum + f.drag[c] * ((1 / e) * f.velocity[c] - mean) - ((1 - e) * gas.grid().volume) * f.gradient[c];
  }
  return sum;
}

TEST(GasForce, OfAllGrainsIsDropTimesAreaToRoundOff) {
  for (const GasDrag law : {GasDrag::ergun, GasDrag::gidaspow, GasDrag::di_felice, GasDrag::beetstra})
    for (const unsigned seed : {1U, 2U, 3U}) {
      GasSettings s = column(0.05, 9, 0.4);
      s.upper = {0.02, 0.03, 0.05};
      s.cells = {3, 4, 9};
      s.drag = law;
      s.most_porosity = 1;  // no resistance of empty cells, which no grain feels
      if (seed == 3) {
        s.inlets[0].kind = GasInlet::Kind::pressure;
        s.inlets[0].pressure = 101325 + 200;
      }
      const Vec3 gravity{0, 0, -9.81};
      Gas gas(s, {}, gravity);
      FromGrains grains = uneven_bed(gas.grid(), seed);
      for (std::size_t c = 0; c < grains.solid.size(); ++c)
        if (grains.solid[c] == 0) {  // every cell resists
          grains.solid[c] = 0.05 * gas.grid().volume;
          grains.specific[c] = grains.solid[c] / 2e-3;
        }
      gas.start(grains);
      for (int k = 0; k < 20; ++k) gas.step(grains, 0.1);
      double weight = 0;  // of the gas between the grains
      for (std::size_t c = 0; c < grains.solid.size(); ++c)
        weight += 9.81 * gas.fields().porosity[c] * gas.grid().volume * gas.fields().density[c];
      const double drop = gas.pressure_drop(2) * s.upper.x * s.upper.y;
      EXPECT_NEAR((force_on_grains(gas, grains).z + weight) / drop, 1, 1e-8);
      EXPECT_GT(drop, 50 * weight);
      // without the weight of the gas, whose density is that of an iteration before, it is exact
      Gas still(s, {}, {});
      still.start(grains);
      for (int k = 0; k < 20; ++k) still.step(grains, 0.1);
      EXPECT_NEAR(force_on_grains(still, grains).z / (still.pressure_drop(2) * s.upper.x * s.upper.y), 1, 1e-11);
    }
}

TEST(GasForce, OfALooseBedDependsOnItsSlipAlone) {
  // looser than most_porosity: the same bed held in a stream, and moved against a weaker one with the same slip
  for (const double most : {0.9, 0.95, 0.999}) {
    constexpr double k_e = 0.97, k_u = 0.5;
    const auto force = [&](double stream, double grains) {
      GasSettings s = column(0.05, 9, stream);
      s.drag = GasDrag::gidaspow;
      s.most_porosity = most;
      Gas gas(s, {}, {});
      FromGrains bed = uniform_bed(gas.grid(), k_e, 2e-3, {0, 0, grains});
      gas.start(bed);
      for (int k = 0; k < 20; ++k) gas.step(bed, 0.1);
      return force_on_grains(gas, bed).z;
    };
    EXPECT_NEAR(force((1 - k_e) * k_u, -k_u) / force(k_u, 0), 1, 1e-4) << most;
  }
}

TEST(GasForce, IsNoneAlongAPeriodicAxisOfOneCell) {
  GasSettings s = column(0.05, 9, 0.4);
  Gas gas(s, {true, true, false}, {});
  const FromGrains grains = uneven_bed(gas.grid(), 4);
  gas.start(grains);
  for (int k = 0; k < 5; ++k) gas.step(grains, 0.1);
  const Vec3 f = force_on_grains(gas, grains);
  EXPECT_LT(std::fabs(f.x), 1e-14 * f.z);
  EXPECT_LT(std::fabs(f.y), 1e-14 * f.z);
}

TEST(GasForce, OfACellIsThatOfItsOwnLaw) {
  // a dense layer under a loose one: each gets its share of the drop by its own resistance
  GasSettings s = column(0.04, 20, 0.3);
  Gas gas(s, {}, {});
  FromGrains grains = uniform_bed(gas.grid(), 0.4, 2e-3);
  for (std::size_t c = 10; c < 20; ++c) {
    grains.solid[c] = 0.3 * gas.grid().volume;
    grains.specific[c] = grains.solid[c] / 2e-3;
    grains.moment[c] = {};
  }
  gas.start(grains);
  for (int k = 0; k < 20; ++k) gas.step(grains, 0.1);
  const ToGrains& f = gas.fields();
  for (const std::size_t c : {9U, 10U}) {
    const double u = f.velocity[c].z, e = f.porosity[c];
    EXPECT_NEAR(-f.gradient[c].z / (u * bed_resistance(GasDrag::ergun, e, 2e-3, f.viscosity[c], f.density[c], u)), 1,
                1e-6);
  }
}

}  // namespace
}  // namespace talus::gas::testing
