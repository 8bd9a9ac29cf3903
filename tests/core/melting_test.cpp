// Matter that melts, and beams: what a scene may say of them, and that enthalpy, temperature and molten fraction agree.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/heat/enthalpy.hpp"
#include "core/scene/scene_file.hpp"

namespace talus {
namespace {

using heat::Enthalpy;
using heat::Property;

TEST(Melting, TemperatureStaysWhileAPureSubstanceMelts) {
  const Enthalpy h(Property::constant(500), 1000, 1000, 2e5);
  EXPECT_EQ(h.at(1000), 5e5) << "at the melting point it is solid";
  for (const double share : {0.0, 0.25, 0.5, 1.0}) {
    EXPECT_NEAR(h.temperature(5e5 + share * 2e5, 900), 1000, 1e-12 * 1000);
    EXPECT_NEAR(h.molten(5e5 + share * 2e5), share, 1e-15);
  }
  EXPECT_NEAR(h.temperature(5e5 + 2e5 + 500 * 50, 900), 1050, 1e-9);
  EXPECT_EQ(h.molten(8e5), 1);
  EXPECT_EQ(h.molten(4.9e5), 0);
}

TEST(Melting, TemperatureInvertsEnthalpyAndNeverFalls) {
  const Property varying = Property::polynomial({400, 0.3}, 0, 250, 2500);
  for (const Enthalpy& h : {Enthalpy(varying, 1600, 1700, 2.7e5), Enthalpy(Property::constant(650), 1600, 1700, 2.7e5),
                            Enthalpy(varying)}) {
    double last = 0, molten = 0;
    for (double T = 300; T < 2400; T += 7) {
      const double e = h.at(T);
      EXPECT_NEAR(h.temperature(e, 300), T, 1e-10 * T);
      EXPECT_GT(e, last);
      EXPECT_GE(h.molten(e), molten);
      last = e;
      molten = h.molten(e);
    }
    EXPECT_EQ(molten, h.melts() ? 1 : 0);
  }
  const Enthalpy linear(Property::constant(650), 1600, 1700, 2.7e5);
  EXPECT_NEAR(linear.molten(linear.at(1625)), 0.25, 1e-13) << "of constant capacity: linear in temperature";
  EXPECT_NEAR(linear.at(2000) - linear.at(300), 650 * 1700 + 2.7e5, 1e-9);
}

const std::string k_scene =
    "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n[time]\nstep = 1e-5\nsteps = 10\n"
    "[contact]\nnormal_stiffness = 1000\nrestitution = 0.8\nfriction = 0.4\n[[material]]\nname = \"steel\"\n"
    "density = 7800\n";
const std::string k_heat = "[heat]\ntemperature = 300\ncapacity = 500\nconductivity = 20\nevery = 10\n";
const std::string k_beam =
    "[[laser]]\npower = [[0, 40], [1, 60]]\nradius = 5e-3\nabsorptivity = 0.6\nx = [0.1, 0.3]\ny = [0.5, 0.5]\n";

Scene parse(const std::string& text) { return parse_scene(k_scene + text, "t.toml", "."); }
std::string refusal(const std::string& text) {
  try {
    parse(text);
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

TEST(MeltingKeys, AMaterialMeltsWithAllThreeKeysAlone) {
  const Scene s = parse("[material.heat]\nsolidus = 1650\nliquidus = 1700\nlatent_heat = 2.7e5\n" + k_heat);
  EXPECT_EQ(s.heat.matter[0].liquidus, 1700);
  EXPECT_EQ(s.heat.matter[0].latent_heat, 2.7e5);
  EXPECT_CONTAINS(refusal("[material.heat]\nsolidus = 1650\nliquidus = 1700\n" + k_heat), "latent_heat: missing");
  EXPECT_CONTAINS(refusal("[material.heat]\nlatent_heat = 1e5\nliquidus = 1700\n" + k_heat), "solidus: missing");
  EXPECT_CONTAINS(refusal("[material.heat]\nsolidus = 1750\nliquidus = 1700\nlatent_heat = 2.7e5\n" + k_heat),
                  "must not be below the solidus");
}

TEST(LaserKeys, ABeamIsReadAndWhatCannotBeRightIsRefused) {
  const Scene s = parse(k_heat + k_beam + "speed = 2\nstart = 0.5\n");
  ASSERT_EQ(s.heat.lasers.size(), 1U);
  EXPECT_EQ(s.heat.lasers[0].power(0.5), 50);
  EXPECT_EQ(s.heat.lasers[0].x[1], 0.3);
  EXPECT_EQ(s.heat.lasers[0].stop, k_never);
  EXPECT_CONTAINS(refusal(k_beam + "speed = 2\n"), "without a [heat] section");
  EXPECT_CONTAINS(refusal(k_heat + k_beam), "speed: missing");
  EXPECT_CONTAINS(refusal(k_heat + k_beam + "speed = 100\n"), "heat.every = 2");
  EXPECT_CONTAINS(refusal(k_heat + k_beam + "speed = 2\nstart = 2\nstop = 1\n"), "later than start");
  EXPECT_CONTAINS(refusal(k_heat + "[[laser]]\npower = 1\nradius = 1e-3\nabsorptivity = 0.5\nx = [0.1, 0.2]\ny = [0]\n"
                                   "speed = 1\n"),
                  "as many numbers as x, 2");
  EXPECT_CONTAINS(refusal(k_heat + "[[laser]]\npower = 1\nradius = 1e-3\nabsorptivity = 0.5\nx = [0.1]\ny = [0]\n"
                                   "speed = 1\n"),
                  "no effect with one way point");
  EXPECT_CONTAINS(refusal(k_heat + "[[laser]]\npower = 1\nradius = 1e-3\nabsorptivity = 1.5\nx = [0.1]\ny = [0]\n"),
                  "absorptivity");
}

}  // namespace
}  // namespace talus
