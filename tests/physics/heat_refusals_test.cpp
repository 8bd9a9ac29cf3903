// What a scene says of heat that its grains contradict: refused or said, with the bound that follows from their sizes.
#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

/// Grains of 5 mm with springs of 1000 N/m.
const std::string k_scene =
    "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n[time]\nstep = 1e-5\nsteps = 10\n"
    "[contact]\nnormal_stiffness = 1000\nrestitution = 0.8\nfriction = 0.4\n"
    "[[material]]\nname = \"glass\"\ndensity = 2500\n[[source]]\nkind = \"random\"\nnumber = 5\n"
    "region = { lower = [0, 0, 0], upper = [1, 1, 1] }\nsize = { diameter = 0.01 }\n"
    "[heat]\ntemperature = 300\ncapacity = 800\nconductivity = 1\n";

std::string said_of(const std::string& heat) {
  try {
    const Simulation sim(parse_scene(k_scene + heat, "t.toml", "."), options());
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}

// The spring is a Hertz contact of E* = 3 k / (4 R sqrt(0.5)) at the deepest overlap of a grain on a wall, 0.5 R:
// E = 2 E* = 4.24e5 Pa without Poisson's ratio. Below it no overlap that can come is that of the modulus.
TEST(HeatRefusals, TheRealModulusIsNotBelowThatOfASpring) {
  EXPECT_EQ(said_of("young = 7e10\n"), "accepted");
  EXPECT_EQ(said_of("young = 4.25e5\n"), "accepted");
  EXPECT_CONTAINS(said_of("young = 4.24e5\n"), "at least 4.24e+05 Pa");
  EXPECT_CONTAINS(said_of("young = 70\n"), "heat.young: 70 Pa of material 'glass' is softer than the spring");  // GPa
}

TEST(HeatRefusals, TheLeastGapIsThinnerThanTheGasThatAGrainCarries) {
  const std::string gap = "[heat.gap]\nconductivity = 0.026\nleast_gap = ";
  EXPECT_EQ(said_of(gap + "1e-6\n"), "accepted");
  EXPECT_EQ(said_of(gap + "0.0019\n"), "accepted");
  EXPECT_CONTAINS(said_of(gap + "0.002\n"), "heat.gap.least_gap: 0.002 m is no less than the layer of gas");
  EXPECT_CONTAINS(said_of(gap + "1\n"), "all gaps would conduct alike");
}

// A grain in gas 100 K hotter gains h A dT t / (m c) per heat step of t, half of which is its error.
TEST(HeatRefusals, AWantedErrorThatTheShortestHeatStepDoesNotKeepIsSaidWithTheStepThatWould) {
  const double film = 50, rise = 3 * film * 100 / (2500 * 800 * 0.005);  // [K/s]
  const double error = 0.5 * rise * 100 * 1e-5;
  for (const double share : {0.26, 1.05}) {
    Simulation sim(parse_scene(k_scene + "every = 100\nerror = " + std::to_string(share * error) +
                                   "\n[heat.gas]\ntemperature = 400\nfilm = 50\n",
                               "t.toml", "."),
                   options());
    sim.run(300);
    std::string said;
    for (const Warning& w : sim.warnings())
      if (w.kind == "heat error") said = w.text;
    if (share > 1) {
      EXPECT_EQ(said, "");
    } else {
      EXPECT_CONTAINS(said, "is not kept: at step 99 the shortest heat step (every = 100)");
      EXPECT_CONTAINS(said, "at most every = 26 would keep it");
    }
  }
}

}  // namespace
}  // namespace talus::physics
