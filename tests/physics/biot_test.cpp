// Grains with gradients that react with nothing, in a bed's scene: the sphere in gas against its series from Bi 0.1 to
// 10; errors and orders are printed.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_radius = 5e-3, k_conductivity = 0.2, k_density = 600, k_capacity = 1500, k_cold = 300, k_hot = 400;

/// (T - T_gas) / (T_0 - T_gas) at x = r / R, after the Fourier number fo.
double series(double biot, double x, double fo) {
  double sum = 0;
  for (int k = 0; k < 60; ++k) {
    double low = k * k_pi + 1e-9, high = (k + 1) * k_pi - 1e-9;
    for (int q = 0; q < 100; ++q) {  // z cos z = (1 - Bi) sin z
      const double z = 0.5 * (low + high), f = 1 - z * std::cos(z) / std::sin(z) - biot;
      (f < 0 ? low : high) = z;
    }
    const double z = 0.5 * (low + high);
    const double shape = x > 0 ? std::sin(z * x) / (z * x) : 1;
    sum += 4 * (std::sin(z) - z * std::cos(z)) / (2 * z - std::sin(2 * z)) * std::exp(-z * z * fo) * shape;
  }
  return sum;
}

std::string grain_file() {
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("talus-biot-{}.toml", getpid())).string();
  std::ofstream(path) << fmt::format(
      "[time]\nstep = 1\nduration = 1\n[grain]\ndiameter = {}\ntemperature = 300\n[material]\ndensity = {}\n"
      "[heat_capacity]\nfuel = {}\n[conductivity]\nfuel = {}\n[surroundings]\ntemperature = 300\n",
      2 * k_radius, k_density, k_capacity, k_conductivity);
  return path;
}

/// Largest error at three times of centre and surface, as a share of the step of the gas.
double error(double biot, int shells, int steps, const std::string& grain) {
  const double time = k_radius * k_radius * k_density * k_capacity / k_conductivity;  // of Fo = 1 [s]
  const double film = biot * k_conductivity / k_radius, end = 0.5 * time * (biot < 0.5 ? 4 : 1);
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, end / steps);
  linear_law(s, 1, 0);
  s.allow_unstable_step = true;
  s.materials[0].density = k_density;
  add_grains(s, {{{}, {}, k_radius, {}, 0, true}});
  s.heat.on = true;
  s.heat.every = s.conversion.every = 1;
  s.heat.temperature = k_cold;
  MatterHeat m;
  m.capacity = Curve::constant(k_capacity);
  m.conductivity = Curve::constant(k_conductivity);
  s.heat.matter = {m};
  s.heat.sources = {{k_cold, false}};
  s.heat.gas.on = true;
  s.heat.gas.film = film;
  s.heat.gas.temperature = TimeTable::constant(k_hot);
  s.conversion.on = true;
  s.conversion.shells = shells;
  s.conversion.grain = {grain};
  Simulation sim(s, options());
  double worst = 0;
  for (int k = 1; k <= 3; ++k) {
    sim.run(steps / 3);
    const double fo = sim.time() / time;
    for (const ExtraColumn& c : sim.frame().extra) {
      if (c.name != "centre_temperature" && c.name != "surface_temperature") continue;
      const double wanted = series(biot, c.name == "centre_temperature" ? 0 : 1, fo);
      worst = std::max(worst, std::fabs((k_hot - c.values[0]) / (k_hot - k_cold) - wanted));
    }
  }
  return worst;
}

TEST(Biot, GrainsWithShellsFollowTheSeriesWithSecondOrderInTheirNumber) {
  const std::string grain = grain_file();
  for (const double biot : {0.1, 1.0, 10.0}) {
    double last = 0;
    for (const int shells : {5, 10, 20}) {
      const double e = error(biot, shells, 30 * shells * shells, grain);
      figure(fmt::format("sphere in gas, Bi {}", biot), e, fmt::format("largest error, {} shells", shells));
      if (last > 0) {
        figure(fmt::format("sphere in gas, Bi {}", biot), std::log2(last / e), "order in the shells");
        EXPECT_GT(std::log2(last / e), 1.6) << biot << ' ' << shells;
      }
      last = e;
    }
    EXPECT_LT(last, 2e-3) << biot;
  }
  std::filesystem::remove(grain);
}

}  // namespace
}  // namespace talus::physics
