// Heat of bodies that are no spheres: one temperature each; contacts of all their rows, gas and enclosure by their true
// surface, capacity by their true mass.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/base/error.hpp"
#include "core/heat/radiation.hpp"
#include "core/scene/scene_file.hpp"
#include "core/shapes/surface_area.hpp"
#include "tests/part_values.hpp"
#include "tests/shapes/body_support.hpp"
#include "tests/shapes/shape_support.hpp"

namespace talus {
namespace {

using shapes::Superquadric;

// --- areas
// ------------------------------------------------------------------------------------------------------------

TEST(SurfaceArea, OfEllipsoidsIsTheClosedForm) {
  EXPECT_NEAR(shapes::surface_area(Superquadric{}), 4 * M_PI, 1e-12);
  for (const double c : {0.1, 0.5, 0.9, 1.1, 2.0, 10.0}) {  // of revolution: semi-axes 1, 1, c
    const double e = std::sqrt(std::fabs(1 - (c < 1 ? c * c : 1 / (c * c))));
    const double wanted = 2 * M_PI * (c < 1 ? 1 + (1 - e * e) / e * std::atanh(e) : 1 + c / e * std::asin(e));
    EXPECT_NEAR(shapes::surface_area(Superquadric{{1, 1, c}, 2, 2}) / wanted, 1, 1e-6) << c;
    EXPECT_NEAR(shapes::surface_area(Superquadric{{1, c, 1}, 2, 2}) / wanted, 1, 1e-6) << c;
  }
}

/// By triangles between points of a fine grid of directions; another way than the code's.
double triangulated(const Superquadric& s, int n) {
  const auto at = [&](int i, int j) {
    // fine where edges of bodies with large exponents are: equal steps of the face's coordinates, not of angles
    const double polar = M_PI * i / n, turn = 2 * M_PI * j / n;
    const Vec3 u{std::sin(polar) * std::cos(turn) * s.axes.x, std::sin(polar) * std::sin(turn) * s.axes.y,
                 std::cos(polar) * s.axes.z};
    return (1 / shapes::testing::gauge(s, u)) * u;
  };
  double area = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Vec3 a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), d = at(i + 1, j + 1);
      area += 0.5 * (norm(cross(b - a, d - a)) + norm(cross(d - a, c - a)));
    }
  return area;
}

TEST(SurfaceArea, OfSuperquadricsIsThatOfTheirTriangles) {
  shapes::testing::Draw draw(5);
  for (int k = 0; k < 4; ++k) {
    const Superquadric s = draw.shape(2, 20, 5);
    EXPECT_NEAR(shapes::surface_area(s) / triangulated(s, 400), 1, 2e-3) << s.n1 << " " << s.n2;
  }
  // nearly a box, nearly a cylinder: from below
  EXPECT_NEAR(shapes::surface_area(Superquadric{{1, 2, 3}, 20, 20}) / 88, 0.97, 0.025);
  EXPECT_NEAR(shapes::surface_area(Superquadric{{1, 1, 2}, 20, 2}) / (2 * M_PI + 8 * M_PI), 0.98, 0.02);
}

TEST(SurfaceArea, OfClumpsCountsWhatIsHiddenOnce) {
  const auto area = [](std::vector<shapes::SubSphere> s) { return shapes::surface_area(s); };
  EXPECT_NEAR(area({{{1, 2, 3}, 2}}), 16 * M_PI, 1e-12);
  EXPECT_NEAR(area({{{0, 0, 0}, 1}, {{5, 0, 0}, 2}}), 20 * M_PI, 1e-12);
  EXPECT_NEAR(area({{{0, 0, 0}, 1}, {{0, 0, 0}, 1}}), 4 * M_PI, 1e-12) << "the same sphere twice";
  EXPECT_NEAR(area({{{0, 0, 0}, 1}, {{0.2, 0.1, 0}, 3}}), 36 * M_PI, 1e-9) << "one within the other";
  for (const Vec3 d : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0.6, 0, 0.8}, Vec3{0.48, 0.6, 0.64}}) {
    // radii 1 and 1, centres 1 apart: each loses a cap of height 1/2
    EXPECT_NEAR(area({{{0, 0, 0}, 1}, {d, 1}}) / (6 * M_PI), 1, 1e-4);
    // three in a row: the middle one keeps a ring of height 1
    EXPECT_NEAR(area({{{0, 0, 0}, 1}, {d, 1}, {2 * d, 1}}) / (8 * M_PI), 1, 1e-4);
  }
}

// --- scenes
// -----------------------------------------------------------------------------------------------------------

constexpr double k_density = 2000, k_capacity = 800, k_conductivity = 5;

Scene scene_of(const std::string& rest, const std::string& heat = {}, const std::string& head = "gravity = [0, 0, 0]",
               const std::string& law =
                   "normal_stiffness = 2000\nrestitution = 0.5\nfriction = 0.4\n"
                   "tangential_stiffness = 800") {
  return parse_scene(
      head +
          "\nseed = 3\nsort_every = 300\n[domain]\nlower = [0, 0, 0]\nupper = [0.05, 0.05, 0.05]\n[time]\nstep = 1e-5\n"
          "duration = 1\n[[material]]\nname = \"m\"\ndensity = 2000\nyoung = 1e7\npoisson = 0.3\n[contact]\n" +
          law + "\n[heat]\ntemperature = 300\ncapacity = 800\nconductivity = 5\nemissivity = 0.9\n" + heat + rest,
      "test", "", {});
}

constexpr const char* k_egg = "[[shape]]\nname = \"egg\"\nkind = \"superquadric\"\nsemi_axes = [0.002, 0.002, 0.004]\n";
constexpr const char* k_rod =
    "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.002, 0.002, 0, 0, 0, 0.002, 0, 0, 0.002, 0.002]\n";

/// Heat step by heat step T' = (1 - h A dt / (m c)) T + ... : the factor of one step tells A / m.
TEST(BodyHeat, FilmAndEnclosureSeeTheTrueSurfaceAndHeatTheTrueMass) {
  const double e = std::sqrt(0.75);
  // egg: semi-axes 2, 2, 4 mm; rod: spheres of 2 mm, the outer two lose one cap of 1 mm, the middle one two
  struct Case {
    const char *shape, *name;
    double area, volume;
  };
  const double egg_area = 2 * M_PI * (1 + 2 / e * std::asin(e)) * 4e-6, egg_volume = 4.0 / 3 * M_PI * 16e-9;
  const double rod_area = 4 * M_PI * 4e-6 * (0.75 + 0.5 + 0.75), cap = M_PI / 3 * 1e-6 * (3 * 0.002 - 0.001),
               rod_volume = 4 * M_PI * 8e-9 - 4 * cap;
  for (const Case& c : {Case{k_egg, "egg", egg_area, egg_volume}, Case{k_rod, "rod", rod_area, rod_volume}})
    for (const bool radiates : {false, true}) {
      const Table table(fmt::format("x,y,z,shape,scale\n0.02,0.02,0.02,{},1.5\n", c.name));
      Simulation sim(
          scene_of(c.shape + table.source(), radiates ? "every = 100\n[heat.radiation]\nenclosure = 900\n"
                                                      : "every = 100\n[heat.gas]\ntemperature = 900\nfilm = 40\n"),
          {});
      sim.run(100);
      const double area = c.area * 2.25, mass = c.volume * 3.375 * k_density;
      const double film = radiates ? heat::k_stefan * 0.9 * (900.0 * 900 + 300.0 * 300) * 1200 : 40;
      const double rise = film * area * 600 * 1e-3 / (mass * k_capacity);
      EXPECT_NEAR((value_of(sim, "heat.mean") - 300) / rise, 1, 1e-4) << c.name << radiates;
      EXPECT_NEAR(value_of(sim, "heat.total") - value_of(sim, "heat.in_by_sources"), film * area * 600 * 1e-3,
                  1e-4 * film * area * 600 * 1e-3);
      EXPECT_EQ(value_of(sim, "heat.lowest"), value_of(sim, "heat.highest")) << "all spheres show the body's";
    }
}

TEST(BodyHeat, FilmOfALawHasTheDiameterOfTheSphereOfEqualVolume) {
  const Table table("x,y,z,shape,scale\n0.02,0.02,0.02,egg,1\n");
  Simulation sim(scene_of(k_egg + table.source(), "every = 100\n[heat.gas]\ntemperature = 900\n"), {});
  sim.run(100);
  const double d = 2 * std::cbrt(16e-9), film = 2 * 0.026 / d;  // at rest Nu = 2
  const double area = shapes::surface_area(rules_of(sim).scene.shapes[0].body->quadric->surface);
  EXPECT_NEAR(value_of(sim, "heat.in_by_gas") / (film * area * 600 * 1e-3), 1, 1e-6);
}

/// Two eggs, point to point and side by side: R* of the curvature there.
TEST(BodyHeat, ContactsConductAsWideAsTheSurfacesTouch) {
  struct Case {
    const char* turn;  ///< of both
    double half, radius;
  };
  const double h = std::sqrt(0.5);
  // ends: b^2 / a; flanks: sqrt(b * a^2 / b)
  for (const Case& c :
       {Case{"1,0,0,0", 0.004, 0.001}, Case{"0.70710678118654757,0.70710678118654757,0,0", 0.002, 0.004}}) {
    const double overlap = 2e-5, z = 0.02 + 2 * c.half - overlap;
    const Table hot(fmt::format("x,y,z,shape,scale,qw,qx,qy,qz\n0.02,0.02,0.02,egg,1,{}\n", c.turn)),
        cold(fmt::format("x,y,z,shape,scale,qw,qx,qy,qz\n0.02,0.02,{},egg,1,{}\n", z, c.turn));
    Simulation sim(scene_of(k_egg + hot.source("temperature = 500") + cold.source(), "every = 1\n"), {});
    sim.run(1);
    // the overlap of step 0 is that of the file
    const double a = std::sqrt(0.5 * c.radius * overlap), flow = 2 * k_conductivity * a * 200;
    const double mass = 4.0 / 3 * M_PI * 16e-9 * k_density;
    EXPECT_NEAR((value_of(sim, "heat.lowest") - 300) * mass * k_capacity / (flow * 1e-5), 1, 1e-5) << c.half << h;
    EXPECT_NEAR(value_of(sim, "heat.residual") / value_of(sim, "heat.total"), 0, 1e-15);
  }
}

TEST(BodyHeat, WallsHeatWhatTouchesThem) {
  const double overlap = 1e-5;
  const Table table(fmt::format("x,y,z,shape,scale\n0.02,0.02,{},egg,1\n", 0.004 - overlap));
  Simulation sim(
      scene_of(k_egg + table.source(), "every = 1\n[[heat.wall]]\nwall = \"domain_z_lower\"\ntemperature = 400\n"), {});
  sim.run(1);
  const double flow = 2 * k_conductivity * std::sqrt(0.001 * overlap) * 100;
  EXPECT_NEAR(value_of(sim, "heat.flow.domain_z_lower") / flow, 1, 1e-5);
}

/// A clump of one sphere and a superquadric that is a ball exchange what spheres do.
TEST(BodyHeat, BallsOfEveryKindExchangeWhatSpheresDo) {
  const char* one[] = {
      "", "[[shape]]\nname = \"ball\"\nspheres = [0, 0, 0, 0.002]\n",
      "[[shape]]\nname = \"ball\"\nkind = \"superquadric\"\nsemi_axes = [0.002, 0.002, 0.002]\n",
      "[[shape]]\nname = \"ball\"\nkind = \"superquadric\"\nsemi_axes = [0.002, 0.002, 0.002000000002]\n"};
  std::vector<double> total, high;
  for (const char* shape : one) {
    const std::string ball = *shape == 0 ? "" : "shape = \"ball\"\n";
    const char *low = "[0, 0, 0]", *most = "[0.05, 0.05, 0.05]";
    Simulation sim(
        scene_of(shape + source("hot", 60, low, most, ball + "velocity_jitter = 0.4\ntemperature = 600", "0.004") +
                     source("cold", 60, low, most, ball + "velocity_jitter = 0.4", "0.004"),
                 "every = 20\nfriction = true\n[heat.gas]\ntemperature = 450\n[heat.radiation]\nenclosure = 350\n"
                 "[[heat.wall]]\nwall = \"domain_z_lower\"\ntemperature = 400\n",
                 "gravity = [0, 0, -9.81]"),
        {});
    sim.run(2000);
    EXPECT_GT(sim.counters().wall_contacts, 0);
    total.push_back(value_of(sim, "heat.total"));
    high.push_back(value_of(sim, "heat.highest"));
    EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-12 * total.back());
  }
  for (std::size_t k = 1; k < total.size(); ++k) {
    EXPECT_NEAR(total[k] / total[0], 1, k < 3 ? 1e-9 : 1e-6) << k;
    EXPECT_NEAR(high[k] / high[0], 1, k < 3 ? 1e-9 : 1e-6) << k;
  }
}

TEST(BodyHeat, AClosedBoxKeepsItsHeatAndEvensOut) {
  const char *low = "[0, 0, 0]", *high = "[0.03, 0.03, 0.03]";
  const std::string rest =
      std::string(k_egg) + k_rod + source("eggs", 20, low, high, "shape = \"egg\"\ntemperature = 900") +
      source("rods", 20, low, high, "shape = \"rod\"\ntemperature = 400") +
      source("balls", 20, low, high, "temperature = 300", "0.004") +
      "[[group]]\nname = \"eggs\"\nids = [0, 9]\n[[event]]\ntime = 0.02\naction = \"freeze\"\ngroup = \"eggs\"\n";
  Simulation sim(scene_of(rest, "every = 10\n[material.heat]\nconductivity = 500\n", "gravity = [-9, -9, -90]"), {});
  const double before = value_of(sim, "heat.total"), hottest = value_of(sim, "heat.highest");
  sim.run(8000);
  EXPECT_GT(sim.counters().contacts, 30);
  EXPECT_NEAR(value_of(sim, "heat.total") / before, 1, 1e-12);
  EXPECT_LT(value_of(sim, "heat.highest"), hottest - 1) << "heat has moved";
  EXPECT_GE(value_of(sim, "heat.lowest"), 300);
  // what every sphere of a body shows
  const Frame f = sim.frame();
  ASSERT_FALSE(f.extra.empty());
  const std::vector<double>*body = nullptr, *T = nullptr;
  for (const ExtraColumn& e : f.extra) (e.name == "body" ? body : T) = &e.values;
  std::map<double, double> of;
  for (std::size_t k = 0; k < body->size(); ++k)
    EXPECT_EQ(of.emplace((*body)[k], (*T)[k]).first->second, (*T)[k]) << "sphere " << k;
  EXPECT_EQ(of.size(), 60U);
}

TEST(BodyHeat, WhatKnowsSpheresAloneIsRefused) {
  const auto refusal = [](const std::string& heat, const std::string& rest = {}) {
    try {
      scene_of(k_egg + source("eggs", 2, "[0, 0, 0]", "[0.05, 0.05, 0.05]", "shape = \"egg\"") + rest, heat);
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal(""), "accepted");
  EXPECT_NE(refusal("[heat.gap]\nconductivity = 0.02\n").find("heat.gap"), std::string::npos);
  EXPECT_NE(refusal("[heat.radiation]\ngrains = true\n").find("heat.radiation.grains"), std::string::npos);
  EXPECT_EQ(refusal("[heat.radiation]\nenclosure = 500\n"), "accepted");
}

}  // namespace
}  // namespace talus
