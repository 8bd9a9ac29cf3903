// [heat] and its sections: what a scene may say, what it inherits, and what is refused.
#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "core/heat/property.hpp"
#include "core/scene/scene_file.hpp"

namespace talus {
namespace {

const std::string k_scene =
    "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n[time]\nstep = 1e-5\nsteps = 10\n"
    "[contact]\nnormal_stiffness = 1000\nrestitution = 0.8\nfriction = 0.4\n";
const std::string k_materials =
    "[[material]]\nname = \"glass\"\ndensity = 2500\n[[material]]\nname = \"wood\"\ndensity = 600\n";

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

TEST(HeatKeys, MaterialsTakeWhatTheyLackFromHeat) {
  const Scene s = parse(
      "[[material]]\nname = \"glass\"\ndensity = 2500\n[material.heat]\nconductivity = { table = [[300, 1], [500, 2]] "
      "}\n"
      "emissivity = 0.7\n[[material]]\nname = \"wood\"\ndensity = 600\n[material.heat]\n"
      "capacity = { polynomial = [1112, 4.85], origin = 273.15, range = [250, 800] }\n"
      "[heat]\ntemperature = 290\ncapacity = 800\nconductivity = 0.2\n[heat.radiation]\nenclosure = 500\n");
  ASSERT_EQ(s.heat.matter.size(), 2U);
  EXPECT_EQ(heat::Property::of(s.heat.matter[0].capacity).at(900.0), 800);
  EXPECT_EQ(heat::Property::of(s.heat.matter[0].conductivity).at(400.0), 1.5);
  EXPECT_EQ(s.heat.matter[0].emissivity, 0.7);
  EXPECT_NEAR(heat::Property::of(s.heat.matter[1].capacity).at(373.15), 1597, 1e-9);
  EXPECT_EQ(heat::Property::of(s.heat.matter[1].conductivity).at(400.0), 0.2);
  EXPECT_EQ(s.heat.matter[1].emissivity, 0.9);
}

TEST(HeatKeys, WhatCannotBeRightIsRefusedWithItsPlace) {
  const std::string heat = k_materials + "[heat]\ntemperature = 300\ncapacity = 800\nconductivity = 1\n";
  EXPECT_CONTAINS(refusal(heat + "every_most = 400\n"), "heat.every_most: 400: has no effect without error");
  EXPECT_CONTAINS(refusal(heat + "error = 1\nevery_most = 40\n"), "heat.every_most: 40: must not be below every (100)");
  EXPECT_CONTAINS(refusal(heat + "error = 0\n"), "heat.error");
  EXPECT_CONTAINS(refusal(heat + "error = 1\n[gas]\ncells = [4, 4, 4]\n"),
                  "heat.error: 1: cannot be kept beside [gas]");
  EXPECT_CONTAINS(refusal(heat + "[heat.gas]\ntemperature = 400\n[gas]\ncells = [4, 4, 4]\n"),
                  "heat.gas: cannot be had beside [gas]");  // a whole section has no value that the line could show
  EXPECT_CONTAINS(
      refusal(k_materials + "[[laser]]\npower = 10\nradius = 1e-4\nabsorptivity = 0.5\nx = [0.5]\ny = [0.5]\n"),
      "laser: has no effect without a [heat] section");
  EXPECT_CONTAINS(refusal(k_materials + "[heat]\ntemperature = 300\ncapacity = 800\n"), "heat.conductivity: missing");
  EXPECT_CONTAINS(refusal(k_materials + "[heat]\ncapacity = 800\nconductivity = 1\n"), "heat.temperature: missing");
  EXPECT_CONTAINS(refusal(k_materials + "[heat]\ntemperature = -5\ncapacity = 1\nconductivity = 1\n"),
                  "must be a number");
  EXPECT_CONTAINS(refusal(heat + "[[heat.wall]]\nwall = \"lid\"\ntemperature = 400\n"), "no such wall");
  EXPECT_CONTAINS(refusal(heat + "[[heat.wall]]\nwall = \"domain_x_lower\"\n"), "heat.wall.0.temperature: missing");
  EXPECT_CONTAINS(refusal(heat + "[[heat.wall]]\nwall = \"domain_x_lower\"\ntemperature = 400\nflux = 5\n"),
                  "contradicts 'temperature'");
  EXPECT_CONTAINS(refusal(heat + "[[heat.wall]]\nwall = \"domain_x_lower\"\ntemperature = 400\nlayer = [0.1]\n"),
                  "must be [thickness, conductivity]");
  EXPECT_CONTAINS(refusal(heat + "[heat.gas]\ntemperature = 400\nfilm = 30\nlaw = \"wakao\"\n"),
                  "no effect with a given film");
  EXPECT_CONTAINS(refusal(heat + "[heat.gas]\ntemperature = [[0, 300], [0, 400]]\n"), "ascending times");
  EXPECT_CONTAINS(refusal(heat + "[heat.radiation]\nrange = 1\n"), "without grains = true");
  EXPECT_CONTAINS(refusal(k_materials + "[material.heat]\ncapacity = 800\n"), "without a [heat] section");
  EXPECT_CONTAINS(refusal(k_materials + "[[source]]\nkind = \"file\"\nfile = \"x.csv\"\ntemperature = 400\n"),
                  "without a [heat] section");
  EXPECT_CONTAINS(refusal(k_materials + "[material.heat]\nyoung = 7e10\n[heat]\ntemperature = 300\ncapacity = 8\n"
                                        "conductivity = 1\n"),
                  "heat.young: missing");
}

TEST(HeatKeys, TheRealModulusIsNotBelowThatOfTheModel) {
  const auto with = [](const std::string& young) {
    try {
      parse_scene(
          "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n[time]\nstep = 1e-5\nsteps = 10\n[contact]\nmodel = "
          "\"hertz_mindlin\"\nrestitution = 0.8\n[[material]]\nname = \"glass\"\ndensity = 2500\nyoung = 5e7\npoisson "
          "= "
          "0.2\n[heat]\ntemperature = 300\ncapacity = 1\nconductivity = 1\nyoung = " +
              young + "\n",
          "t.toml", ".");
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(with("7e10"), "accepted");
  EXPECT_EQ(with("5e7"), "accepted");
  EXPECT_CONTAINS(with("70"), "heat.young: 70: is the real modulus");  // in GPa
}

TEST(HeatKeys, CurvesBelowZeroKelvinAreRefused) {
  const auto with = [](const std::string& capacity) {
    return refusal(k_materials + "[heat]\ntemperature = 300\nconductivity = 1\ncapacity = " + capacity + "\n");
  };
  EXPECT_CONTAINS(with("{ table = [[-20, 700], [500, 900]] }"), "has a temperature below 0: they are in kelvin");
  EXPECT_CONTAINS(with("{ polynomial = [700, 1], origin = 0, range = [-10, 500] }"), "they are in kelvin");
  EXPECT_CONTAINS(with("{ polynomial = [700, 1], origin = -273.15, range = [100, 500] }"), "they are in kelvin");
  EXPECT_EQ(with("{ table = [[0, 700], [500, 900]] }"), "accepted");
}

TEST(HeatKeys, PropertyThatLeavesItsRangeIsRefusedWithTheTemperature) {
  const auto with = [](const std::string& capacity) {
    return refusal(k_materials + "[heat]\ntemperature = 300\nconductivity = 1\ncapacity = " + capacity + "\n");
  };
  EXPECT_EQ(with("{ polynomial = [1000, -0.1] }"), "accepted");
  EXPECT_CONTAINS(with("{ polynomial = [100, -0.1] }"), "give a range = [T1, T2]");
  EXPECT_EQ(with("{ polynomial = [100, -0.1], range = [250, 900] }"), "accepted");
  for (const char* wrong :
       {"{ polynomial = [] }", "{ polynomial = [1, nan] }", "{ table = [[300, 1]] }",
        "{ table = [[300, 1], [300, 2]] }", "{ table = [[300, 1], [400, 0]] }", "{ tabel = [[300, 1], [400, 2]] }",
        "{ polynomial = [1], range = [5, 4] }", "[1, 2]", "\"high\"", "0", "{}"})
    EXPECT_CONTAINS(with(wrong), "heat.capacity: ");
  EXPECT_CONTAINS(with("{ table = [[300, 1], [400, 0]] }"), "must be a number");
}

}  // namespace
}  // namespace talus
