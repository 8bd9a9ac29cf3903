// A random bed that gas lifts: forces on all grains against the drop of pressure, the velocity at which they carry the
// bed against the balance of Ergun, and what the bed does below and above it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "core/base/det_math.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/species.hpp"
#include "core/io/checkpoint.hpp"
#include "scheduler/simulation.hpp"
#include "tests/part_values.hpp"

namespace talus::gas {
namespace {

constexpr double k_side = 0.008, k_height = 0.024;

/// Grains of 1 mm (or of 0.7 to 1.4 mm) fall onto a floor, sides periodic; gas from below.
Scene bed(bool equal) {
  Scene s;
  s.domain.upper = {k_side, k_side, k_height};
  s.domain.boundary[0] = s.domain.boundary[1] = {Boundary::periodic, Boundary::periodic};
  s.materials = {Material{"glass", 2500}};
  s.pairs = {PairCoefficients{}};
  s.gravity = {0, 0, -9.81};
  s.contact.normal_stiffness = 200;
  s.contact.normal_damping = 12000;
  s.contact.friction = true;
  s.pairs[0].friction = 0.3;
  s.dt = 1e-5;
  s.gas.on = true;
  s.gas.upper = s.domain.upper;
  s.gas.cells = {2, 2, 12};
  s.gas.every = 20;
  s.gas.most_porosity = 0.99;  // the space above resists little
  GasInlet in, out;
  out.side = GasSide::top;
  out.kind = GasInlet::Kind::pressure;
  s.gas.inlets = {in, out};
  Source a;
  a.kind = Source::Kind::random;
  a.number = equal ? 700 : 500;
  if (equal) {
    a.size.diameter = 1e-3;
  } else {
    a.size.kind = SizeDistribution::Kind::uniform;
    a.size.min = 0.7e-3;
    a.size.max = 1.4e-3;
  }
  a.region.lower = {0, 0, 0.0007};
  a.region.upper = {k_side, k_side, k_height - 0.0007};
  s.sources = {a};
  s.steps = 1000000;
  return s;
}

/// Volume of the grains, their Sauter diameter and weight, the height of their middle.
struct BedState {
  double volume = 0, diameter = 0, weight = 0, middle = 0;
  explicit BedState(const Simulation& sim) {
    const Frame f = sim.frame();
    double specific = 0;
    for (std::size_t i = 0; i < f.x.size(); ++i) {
      const double v = 4 * det::k_pi / 3 * f.r[i] * f.r[i] * f.r[i];
      volume += v;
      specific += v / (2 * f.r[i]);
      middle += v * f.x[i].z;
    }
    middle /= volume;
    diameter = volume / specific;
    weight = volume * 2500 * 9.81;
  }
  double porosity() const { return 1 - volume / (k_side * k_side * 2 * middle); }
};

/// Velocity at which Ergun's drop over the bed carries it.
double ergun_velocity(const BedState& b) {
  const double e = b.porosity(), d = b.diameter, mu = viscosity(300),
               rho = 101325 / (specific_gas_constant(k_air) * 300);
  const double A = 1.75 * rho / (e * e * e * d), B = 150 * mu * (1 - e) / (e * e * e * d * d), C = (2500 - rho) * 9.81;
  return (std::sqrt(B * B + 4 * A * C) - B) / (2 * A);
}

class Fluidised {
 public:
  explicit Fluidised(bool equal) : scene_(bed(equal)) {
    Simulation sim(scene_, RunOptions{});
    sim.run(15000);
    CheckpointWriter out;
    sim.save(out);
    path_ = (std::filesystem::path(::testing::TempDir()) / "fluidised.checkpoint").string();
    out.commit(path_);
  }
  ~Fluidised() { std::filesystem::remove(path_); }
  /// The settled bed in gas of velocity u from now on.
  Simulation at(double u) const {
    Scene s = scene_;
    s.gas.inlets[0].velocity = u;
    return Simulation(s, RunOptions{}, CheckpointReader(path_));
  }
  /// Force of the gas on the bed as it lies, over its weight.
  double lift(double u) const {
    Simulation sim = at(u);
    sim.run(40);
    const double force = value_of(sim, "gas.force_z"), area = k_side * k_side;
    const double gas = 9.81 * 101325 / (specific_gas_constant(k_air) * 300) * (area * k_height - BedState(sim).volume);
    // the empty space above has a resistance of its own, which no grain feels
    EXPECT_NEAR((force + gas) / (value_of(sim, "gas.pressure_drop") * area), 1, 2e-3);
    return force / BedState(sim).weight;
  }

 private:
  Scene scene_;
  std::string path_;
};

TEST(Fluidisation, BeginsWhereErgunsDropCarriesARandomBed) {
  for (const bool equal : {true, false}) {
    const Fluidised f(equal);
    const BedState settled(f.at(0));
    const double ergun = ergun_velocity(settled);
    double low = 0.5 * ergun, high = 1.5 * ergun;
    ASSERT_LT(f.lift(low), 1);
    ASSERT_GT(f.lift(high), 1);
    for (int k = 0; k < 7; ++k) {
      const double u = 0.5 * (low + high);
      (f.lift(u) < 1 ? low : high) = u;
    }
    std::printf("%s: porosity %.4f, carried at %.4f m/s, Ergun %.4f (%+.1f %%)\n",
                equal ? "equal grains" : "grains 1:2", settled.porosity(), low, ergun, 100 * (low / ergun - 1));
    EXPECT_NEAR(low / ergun, 1, 0.05);
    Simulation below = f.at(0.95 * ergun), above = f.at(1.05 * ergun);
    below.run(10000);
    above.run(10000);
    const double rest = BedState(below).middle / settled.middle - 1, rise = BedState(above).middle / settled.middle - 1;
    std::printf("  middle of the bed after 0.1 s: %+.2f %% at 0.95, %+.2f %% at 1.05 of Ergun's velocity\n", 100 * rest,
                100 * rise);
    EXPECT_LT(rest, 0.25 * rise);  // unloaded it rearranges; how much depends on the packing that it fell into
    EXPECT_GT(rise, 0.012);
  }
}

}  // namespace
}  // namespace talus::gas
