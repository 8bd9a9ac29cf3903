// Grains in a sealed vessel of gas: the temperature that both end at, and what is said of steam and pressure that the
// model does not follow.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/gas/species.hpp"
#include "core/scene/scene_file.hpp"
#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

/// Eight fixed grains of 4 mm in a box of 20 mm full of gas; heat, conversion and gas at every step.
std::string box(double dt, double grains, const std::string& gas, const std::string& more = "",
                const std::string& material = "[material.heat]\ncapacity = 800\nconductivity = 10\n") {
  std::string rows = "x,y,z,diameter,fixed\n";
  for (int k = 0; k < 8; ++k)
    rows += fmt::format("{},{},{},0.004,1\n", 0.007 + 0.006 * (k % 2), 0.007 + 0.006 * (k / 2 % 2),
                        0.007 + 0.006 * (k / 4));
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("talus-sealed-{}.csv", getpid())).string();
  std::ofstream(path) << rows;
  return fmt::format(
      "domain = {{ lower = [0, 0, 0], upper = [0.02, 0.02, 0.02] }}\ntime = {{ step = {}, steps = 100000 }}\n"
      "checks = {{ allow_unstable_step = true }}\n[contact]\nnormal_stiffness = 1\nrestitution = 1\nfriction = 0\n"
      "[[source]]\nkind = \"file\"\nfile = \"{}\"\n[heat]\ntemperature = {}\nevery = 1\n"
      "[gas]\ncells = [2, 2, 2]\nevery = 1\nnusselt = \"wakao\"\n{}\n{}[[material]]\nname = \"m\"\ndensity = 700\n{}",
      dt, path, grains, gas, more, material);
}

int said(const Simulation& sim, const std::string& kind, const std::string& word) {
  int n = 0;
  for (const Warning& w : sim.warnings()) n += w.kind == kind && w.text.find(word) != std::string::npos;
  return n;
}

TEST(SealedBox, HotGrainsWarmTheGasAtConstantVolume) {
  Simulation sim(parse_scene(box(0.02, 1000, "temperature = 300"), "sealed", "/"), RunOptions{});
  sim.run(6000);
  const double solid = 8 * 4.0 / 3 * 3.14159265358979324 * 8e-9, room = 8e-6 - solid,
               r = gas::specific_gas_constant(k_air);
  const double mass = 101325 * room / (r * 300), capacity = solid * 700 * 800;
  const auto energy = [&](double t) { return gas::enthalpy(k_air, t) - r * t; };
  double low = 300, high = 1000;
  for (int k = 0; k < 80; ++k) {
    const double t = 0.5 * (low + high);
    (mass * (energy(t) - energy(300)) < capacity * (1000 - t) ? low : high) = t;
  }
  figure("sealed box", value_of(sim, "gas.temperature_min") - low, fmt::format("K off {:.6f} K, 120 s", low));
  EXPECT_LT(low, 999) << "the gas has taken heat that is seen";
  EXPECT_NEAR(value_of(sim, "gas.temperature_min"), low, 1e-6);
  EXPECT_NEAR(value_of(sim, "gas.temperature_max"), low, 1e-6);
  EXPECT_NEAR(value_of(sim, "heat.lowest"), low, 1e-6);
  EXPECT_NEAR(value_of(sim, "gas.pressure"), 101325 * low / 300, 1e-3);
  EXPECT_NEAR(value_of(sim, "gas.pressure_work"), room * 101325 * (low / 300 - 1), 1e-9);
}

TEST(HeatAdvice, SaysWhatRadiationAllowsOnceGrainsAreHot) {
  // rho c r / 3 / (4 sigma e T^3) = 700 * 800 * 0.002 / 3 / (4 * 5.670374e-8 * 0.9 * 2300^3) = 0.150322 s
  for (const double dt : {0.1, 0.2}) {
    std::string text = box(dt, 300, "", "[heat.radiation]\nenclosure = 2300\n");
    const std::size_t gas = text.find("[gas]");
    text.erase(gas, text.find("[heat.radiation]") - gas);
    const Simulation sim(parse_scene(text, "hot", "/"), RunOptions{});
    int said = 0;
    for (const auto& [part, line] : sim.part_advice())
      said += line.find("(2300 K), radiation alone allows 1 and time.step = 0.15 s") != std::string::npos;
    EXPECT_EQ(said, dt > 0.15 ? 1 : 0);
  }
}

TEST(SealedBox, SteamThatWouldCondenseIsSaidOnce) {
  const std::string wet = "temperature = 370\nfractions = [0, 0, 0, 0.3, 0, 0, 0, 0.7]";
  Simulation cold(parse_scene(box(0.001, 300, wet), "wet", "/"), RunOptions{});
  cold.run(20);
  EXPECT_EQ(said(cold, "gas saturation", "it does not condense"), 1);
  EXPECT_EQ(said(cold, "gas saturation", "grains of 300"), 1);
  for (const Warning& w : cold.warnings())
    if (w.kind == "gas saturation") {
      EXPECT_GT(w.count, 20) << "cells of all gas steps";
      // 0.3 of the mass is 0.4 of the moles; 3.54 kPa saturate at 300 K
      EXPECT_NEAR(w.worst, 0.4 * 101325 / 3540, 0.05 * w.worst);
    }
  Simulation warm(parse_scene(box(0.001, 372, wet), "warm", "/"), RunOptions{});
  warm.run(20);
  EXPECT_EQ(said(warm, "gas saturation", ""), 0);
}

TEST(SealedBox, PressureThatWetGrainsDoNotKnowOfIsSaid) {
  const std::string wood =
      "[time]\nstep = 1\nduration = 1\n[grain]\ndiameter = 0.004\ntemperature = 300\n[material]\ndensity = 700\n"
      "moisture = 0.3\n[heat_capacity]\nfuel = 1500\n[conductivity]\nfuel = 0.2\n[surroundings]\ntemperature = 300\n";
  const std::string path =
      (std::filesystem::temp_directory_path() / fmt::format("talus-sealed-{}.toml", getpid())).string();
  std::ofstream(path) << wood;
  for (const bool open : {false, true}) {
    const std::string more = "[heat.radiation]\nenclosure = 1300\n[conversion]\nevery = 1\nshells = 5\n" +
                             std::string(open ? "[[gas.inlet]]\nside = \"top\"\nkind = \"pressure\"\n" : "");
    Simulation sim(parse_scene(box(0.005, 300, "temperature = 300", more, "grain = \"" + path + "\"\n"), "wood", "/"),
                   RunOptions{});
    sim.run(600);
    EXPECT_EQ(said(sim, "gas pressure", "goes on to boil") + said(sim, "gas pressure", "go on to boil"), open ? 0 : 1);
    EXPECT_EQ(value_of(sim, "gas.pressure") > 1.2e5, !open);
    EXPECT_LT(value_of(sim, "conversion.moisture"), 0.99 * 0.3 * value_of(sim, "conversion.mass") / 0.7);
    EXPECT_LT(std::fabs(value_of(sim, "gas.enthalpy_residual")), 1e-10 * 5e2);
  }
}

TEST(SealedBox, PressureThatInletsRaiseAndHeatThatNobodyKnowsAreSaid) {
  const std::string blown = "[[gas.inlet]]\nside = \"bottom\"\nkind = \"flow\"\nvelocity = 0.1\n";
  for (const bool open : {false, true}) {
    const std::string more = blown + (open ? "[[gas.inlet]]\nside = \"top\"\nkind = \"pressure\"\n" : "");
    Simulation sim(parse_scene(box(0.01, 300, "temperature = 300", more), "blown", "/"), RunOptions{});
    sim.run(20);
    EXPECT_EQ(said(sim, "gas pressure", "inlets give it a flow alone"), open ? 0 : 1);
    EXPECT_EQ(value_of(sim, "gas.pressure") > 1.5e5, !open);
  }
  for (const double oxygen : {0.0, 0.4}) {
    const std::string gas = fmt::format(
        "temperature = 2000\ncombustion = true\nfractions = [{}, 0, 0, 0, 0.1, 0, 0, {}]", oxygen, 0.9 - oxygen);
    Simulation sim(parse_scene(box(0.001, 2000, gas), "flame", "/"), RunOptions{});
    sim.run(5);
    EXPECT_EQ(said(sim, "gas temperature", "does not dissociate"), oxygen > 0 ? 1 : 0);
  }
}

}  // namespace
}  // namespace talus::physics
