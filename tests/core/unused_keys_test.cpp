// Keys and tables that nobody reads: what has no effect is refused where it stands, what may be meant is said.
#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "core/scene/scene_forgotten.hpp"

namespace talus {
namespace {

const std::string k_scene =
    "gravity = [0, 0, 0]\n[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n%D[time]\nstep = 1e-5\nsteps = 10\n"
    "[[material]]\nname = \"m\"\ndensity = 2500\n"
    "[contact]\nnormal_stiffness = 1000\nrestitution = 0.8\nfriction = 0.4\n[output]\ncsv_every = 0\n";

std::string text_of(const std::string& more, const std::string& domain = "") {
  std::string s = k_scene;
  return s.replace(s.find("%D"), 2, domain) + more;
}

std::string refusal(const std::string& more, const std::string& domain = "") {
  try {
    parse_scene(text_of(more, domain), "t.toml", ".");
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    return e.what();
  }
  return "accepted";
}

std::string notes(const std::string& more) {
  std::string all;
  for (const std::string& n : forgotten_keys(read_scene_text(text_of(more), "t.toml", ".", {}))) all += n + "\n";
  return all;
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

TEST(UnusedKeys, PartsOfAMotionThatDoNotMakeOneAreRefused) {
  const auto with = [](const std::string& motion) {
    return refusal("[[wall]]\nshape = \"box\"\nlower = [0.1, 0.1, 0.1]\nupper = [0.2, 0.2, 0.2]\nmotion = { " + motion +
                   " }\n");
  };
  EXPECT_CONTAINS(with("amplitude = [0, 0, 0.01]"),
                  "wall.0.motion.amplitude: [0, 0, 0.01]: has no effect without 'freq");
  EXPECT_CONTAINS(with("frequency = 5"), "wall.0.motion.frequency: 5: has no effect without 'amplitude'");
  EXPECT_CONTAINS(with("frequency = 5, phase = 0.5"), "has no effect without 'amplitude'");
  EXPECT_CONTAINS(with("phase = 0.5"), "wall.0.motion.phase: 0.5: has no effect without 'amplitude'");
  EXPECT_CONTAINS(with("rotation_axis = [1, 0, 0]"), "has no effect without 'rotation_rate'");
  EXPECT_CONTAINS(with("velocity = [1, 0, 0], rotation_origin = [1, 0, 0]"), "has no effect without 'rotation_rate'");
  EXPECT_CONTAINS(with("start = 1"), "wall.0.motion.start: 1: has no effect without a motion");
  EXPECT_CONTAINS(with("end = 1"), "wall.0.motion.end: 1: has no effect without a motion");
  EXPECT_EQ(with("amplitude = [0, 0, 0.01], frequency = 0, start = 1"), "accepted") << "a value of a study";
  EXPECT_EQ(with("rotation_rate = 0, rotation_axis = [1, 0, 0], end = 1"), "accepted");
}

TEST(UnusedKeys, LimitsAndSettingsOfWhatIsOffAreRefused) {
  EXPECT_CONTAINS(refusal("[relax]\ndisplacement = 0.1\n"), "relax.displacement: 0.1: has no effect without 'steps'");
  EXPECT_CONTAINS(refusal("[checks]\nmax_energy = 0.1\n"), "checks.max_energy: 0.1: has no effect without output.ener");
  EXPECT_CONTAINS(refusal("[checks]\nwarn_energy = 0.1\n"), "checks.warn_energy");
  EXPECT_EQ(refusal("energies = true\n[checks]\nmax_energy = 0.1\n"), "accepted");
  EXPECT_CONTAINS(refusal("", "boundary = \"open\"\nwall_material = \"m\"\n"),
                  "domain.wall_material: 'm': has no effect: no side of the domain is a wall");
  EXPECT_EQ(refusal("", "boundary = [\"open\", \"open\", [\"wall\", \"open\"]]\nwall_material = \"m\"\n"), "accepted");
}

TEST(UnusedKeys, AWallMayNotHaveTheNameOfASideThatIsOne) {
  const std::string wall = "[[wall]]\nname = \"domain_z_lower\"\nshape = \"plane\"\npoint = [0, 0, 0.1]\n";
  EXPECT_CONTAINS(refusal(wall), "wall.0.name: 'domain_z_lower': is the name of a side of the domain");
  EXPECT_EQ(refusal(wall, "boundary = \"open\"\n"), "accepted") << "there is no such side";
}

TEST(UnusedKeys, ALaserThatStandsStillOnItsWayIsRefused) {
  const std::string heat = "[heat]\ntemperature = 300\ncapacity = 1\nconductivity = 1\n[[laser]]\npower = 1\n";
  EXPECT_CONTAINS(refusal(heat + "radius = 0.1\nabsorptivity = 1\nx = [0.5, 0.5]\ny = [0.2, 0.2]\nspeed = 1\n"),
                  "laser.0.x: [0.5, 0.5]: all way points are one place");
  EXPECT_CONTAINS(refusal(heat + "radius = 1e-9\nabsorptivity = 1\nx = [0.5, 0.6]\ny = [0.2, 0.2]\nspeed = 1\n"),
                  "heat.every = 1 and time.step = 5e-10");
}

TEST(UnusedTables, ShapesAndGroupsThatNothingNamesAreSaid) {
  const std::string shape = "[[shape]]\nname = \"rod\"\nspheres = [0, 0, 0, 0.01, 0, 0, 0.01, 0.01]\n";
  const std::string source =
      "[[source]]\nkind = \"random\"\nnumber = 1\nshape = \"rod\"\n[source.region]\n"
      "lower = [0, 0, 0]\nupper = [1, 1, 1]\n";
  EXPECT_CONTAINS(notes(shape), "shape 'rod' is of no use");
  EXPECT_EQ(notes(shape + source), "");
  const std::string group = "[[group]]\nname = \"bed\"\nids = [0, 5]\n";
  EXPECT_CONTAINS(notes(group), "group 'bed' is of no use");
  EXPECT_EQ(notes(group + "[[event]]\ntime = 0\naction = \"freeze\"\ngroup = \"bed\"\n"), "");
}

TEST(UnusedTables, AClumpThatFallsApartIsSaid) {
  const std::string source =
      "[[source]]\nkind = \"random\"\nnumber = 1\nshape = \"rod\"\n[source.region]\n"
      "lower = [0, 0, 0]\nupper = [1, 1, 1]\n";
  const auto with = [&](const std::string& spheres) {
    return notes("[[shape]]\nname = \"rod\"\nspheres = [" + spheres + "]\n" + source);
  };
  EXPECT_CONTAINS(with("0, 0, 0, 0.01, 0, 0, 0.03, 0.01, 0, 0, 0.045, 0.01"), "falls into 2 pieces");
  EXPECT_EQ(with("0, 0, 0, 0.01, 0, 0, 0.02, 0.01, 0, 0, 0.035, 0.01"), "") << "touching is enough";
}

TEST(UnusedTables, SpheresWithinOthersAreLeftOutAndThisIsSaid) {
  const std::string source =
      "[[source]]\nkind = \"random\"\nnumber = 1\nshape = \"s\"\n[source.region]\n"
      "lower = [0, 0, 0]\nupper = [1, 1, 1]\n";
  const auto with = [&](const std::string& spheres) {
    return notes("[[shape]]\nname = \"s\"\nspheres = [" + spheres + "]\n" + source);
  };
  EXPECT_CONTAINS(with("0, 0, 0, 0.02, 0, 0, 0.005, 0.01, 0, 0, 0, 0.02"), "2 of its spheres lie within others");
  EXPECT_CONTAINS(with("0, 0, 0.01, 0.01, 0, 0, 0, 0.02"), "1 of its spheres lie within others");  // from inside
  EXPECT_EQ(with("0, 0, 0.011, 0.01, 0, 0, 0, 0.02"), "");
}

TEST(UnusedTables, DefaultsOfHeatThatEveryMaterialOverridesAreSaid) {
  const std::string heat = "[heat]\ntemperature = 300\ncapacity = 800\nconductivity = 1\n";
  EXPECT_EQ(notes(heat), "");
  EXPECT_CONTAINS(notes(heat + "[material.heat]\nconductivity = 5\n"),
                  "heat.conductivity is of no use: every material has its own");
  EXPECT_EQ(notes(heat + "[material.heat]\nconductivity = 5\n[[material]]\nname = \"n\"\ndensity = 1\n"), "");
}

TEST(UnusedTables, CurvesThatDoNotHoldWhereGrainsBeginAreSaid) {
  const std::string source =
      "[[source]]\nkind = \"random\"\nnumber = 1\n[source.region]\nlower = [0, 0, 0]\nupper = "
      "[1, 1, 1]\n[source.size]\ndiameter = 0.1\n";
  const auto with = [&](const std::string& capacity) {
    return notes(source + "[heat]\ntemperature = 300\nconductivity = 1\ncapacity = " + capacity + "\n");
  };
  EXPECT_CONTAINS(with("{ table = [[400, 800], [900, 900]] }"),
                  "the capacity of 'm' is given from 400 to 900 K, and grains of source 'source_0' begin at 300 K");
  EXPECT_CONTAINS(with("{ polynomial = [800, 0.1], origin = 0, range = [10, 200] }"), "given from 10 to 200 K");
  EXPECT_EQ(with("{ table = [[300, 800], [900, 900]] }"), "");
}

// The run ends at 1e-4 s, the domain is the unit cube, grains are 2 cm wide.
TEST(UnusedKeys, WhatTheRunEndsBeforeIsSaid) {
  const std::string grains =
      "[[source]]\nname = \"bed\"\nkind = \"random\"\nnumber = 5\nsize = { diameter = 0.02 }\n"
      "region = { lower = [0, 0, 0], upper = [1, 1, 1] }\nstart = ";
  const std::string event = "[[event]]\naction = \"gravity\"\ngravity = [0, 0, -1]\ntime = ";
  const std::string box = "[[wall]]\nname = \"w\"\nshape = \"box\"\nlower = [0.1, 0.1, 0.1]\nupper = [0.2, 0.2, 0.2]\n";
  const std::string motion = "[wall.motion]\nvelocity = [0, 0, 1]\nstart = ";
  EXPECT_EQ(notes(grains + "9e-5\n" + event + "9e-5\n" + box + "appear = 9e-5\n" + motion + "9e-5\n"), "");
  EXPECT_CONTAINS(notes(grains + "1e-4\n"), "source 'bed' begins at 0.0001 s, and the run ends at 0.0001 s before it");
  EXPECT_CONTAINS(notes(event + "2\n"), "event 0 (gravity) is due at 2 s, and the run ends at 0.0001 s before it");
  EXPECT_CONTAINS(notes(grains + "0\n" + box + "appear = 1\n"), "wall \"w\" appears at 1 s");
  EXPECT_CONTAINS(notes(grains + "0\n" + box + motion + "1\n"), "wall \"w\" begins to move at 1 s");
  // --steps ends a run early: a first look at a scene
  EXPECT_TRUE(forgotten_keys(read_scene_text(text_of(event + "2\n"), "t.toml", ".", {}), true).empty());
}

TEST(UnusedKeys, WallsThatNoGrainCanReachAreSaid) {
  const auto with = [](const std::string& wall, const std::string& domain = "") {
    const std::string text = text_of(
        "[[source]]\nkind = \"random\"\nnumber = 5\nsize = { diameter = 0.02 }\n"
        "region = { lower = [0, 0, 0], upper = [1, 1, 1] }\n[[wall]]\nname = \"w\"\n" +
            wall,
        domain);
    std::string all;
    for (const std::string& n : forgotten_keys(read_scene_text(text, "t.toml", ".", {}))) all += n;
    return all;
  };
  const std::string box = "shape = \"box\"\nlower = [0.2, 0.2, ", end = "]\nupper = [0.4, 0.4, 2]\n";
  EXPECT_EQ(with(box + "1.009" + end), "");  // a grain that touches the side reaches it
  EXPECT_CONTAINS(with(box + "1.011" + end), "no grain can touch wall \"w\": it lies 0.011 m outside the domain");
  EXPECT_EQ(with(box + "1.011" + end + "[wall.motion]\nvelocity = [0, 0, -1]\n"), "");          // it may come
  EXPECT_EQ(with(box + "1.011" + end, "boundary = [\"wall\", \"wall\", \"periodic\"]\n"), "");  // its image does
  const std::string plane = "shape = \"plane\"\nnormal = [0, 0, 2]\npoint = [0, 0, ";
  EXPECT_EQ(with(plane + "-0.009]\n"), "");
  EXPECT_CONTAINS(with(plane + "-0.5]\n"), "no grain can touch wall \"w\": it lies 0.5 m outside");
  EXPECT_CONTAINS(with(plane + "1.5]\n"), "no grain can touch wall \"w\": it lies 0.5 m outside");
  const std::string tube = "shape = \"cylinder\"\nlength = 1\nradius = 0.3\naxis = [0, 1, 0]\npoint = [0.5, 0, ";
  EXPECT_EQ(with(tube + "1.305]\n"), "");
  EXPECT_CONTAINS(with(tube + "1.4]\n"), "no grain can touch wall \"w\": it lies 0.1 m outside");
}

TEST(UnusedKeys, AveragesOverSpaceThatIsNotThereAreSaid) {
  const std::string region = "[[output.region]]\nname = \"bed\"\nlower = [0, 0, 0]\nupper = ";
  EXPECT_EQ(notes(region + "[1, 1, 1]\n"), "");
  EXPECT_CONTAINS(notes(region + "[1, 1, 1.5]\n"), "output region 'bed' reaches 0.5 m out of the domain");
}

TEST(UnusedKeys, AveragesOverSpaceSmallerThanABodyAreSaid) {
  const auto with = [](const std::string& shape, const std::string& output, const std::string& grid = "") {
    return notes(grid +
                 "[[shape]]\nname = \"rod\"\nkind = \"clump\"\nspheres = [0, 0, 0, 0.1, 0.2, 0, 0, 0.1]\n"
                 "[[source]]\nkind = \"random\"\nnumber = 5\nsize = { diameter = 0.26 }\n" +
                 shape + "region = { lower = [0, 0, 0], upper = [1, 1, 1] }\n" + output);
  };
  const auto region = [](const std::string& upper) {
    return "[[output.region]]\nname = \"bed\"\nlower = [0, 0, 0]\nupper = [" + upper + "]\n";
  };
  const std::string rod = "shape = \"rod\"\n";
  EXPECT_EQ(with(rod, region("0.3, 0.3, 0.3")), "");
  EXPECT_EQ(with(rod, region("1, 1, 0.03")), "");  // a thin layer meets many of them
  EXPECT_CONTAINS(with(rod, region("0.2, 0.2, 0.2")),
                  "'bed' is as large as a cube of 0.2 m, and bodies are as large as spheres of 0.26 m");
  EXPECT_EQ(with("", region("0.2, 0.2, 0.2")).find("bed"), std::string::npos);  // a sphere's share is exact
  EXPECT_EQ(with(rod, "", "grid = [3, 3, 3]\n"), "");
  EXPECT_CONTAINS(with(rod, "", "grid = [5, 5, 5]\n"), "each cell of output.grid is as large as a cube of 0.2 m");
}

TEST(UnusedKeys, CelsiusDegreesAndOtherUnitsAreDoubted) {
  const std::string heat = "[heat]\ncapacity = 800\nconductivity = 1\ntemperature = ";
  EXPECT_EQ(notes(heat + "293\n"), "");
  EXPECT_CONTAINS(notes(heat + "25\n"), "heat.temperature is 25 K, that is -248.15 degrees Celsius");
  EXPECT_CONTAINS(notes(heat + "293\n[heat.gas]\ntemperature = [[0, 80], [1, 400]]\n"), "heat.gas.temperature is 80 K");
  const auto friction = [](const std::string& value) {
    std::string all;
    for (const std::string& n :
         forgotten_keys(read_scene_text(text_of(""), "t.toml", ".", {"contact.friction=" + value})))
      all += n;
    return all;
  };
  EXPECT_CONTAINS(notes(heat + "293\n[heat.gap]\nconductivity = 26\n"), "heat.gap.conductivity is 26 W/m/K");
  EXPECT_EQ(friction("1.5"), "");
  EXPECT_EQ(friction("1e6"), "");  // nothing slides
  EXPECT_CONTAINS(friction("30"), "an angle of 30 degrees would be 0.577");
}

}  // namespace
}  // namespace talus
