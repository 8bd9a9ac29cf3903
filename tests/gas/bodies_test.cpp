// Bodies that are no spheres in the gas: their volume in the cells, drag, pressure force, heat.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/gas/drag.hpp"
#include "core/gas/species.hpp"
#include "core/scene/scene_file.hpp"
#include "core/shapes/surface_area.hpp"
#include "tests/part_values.hpp"
#include "tests/shapes/body_support.hpp"

namespace talus::gas {
namespace {

constexpr const char* k_shapes =
    "[[shape]]\nname = \"egg\"\nkind = \"superquadric\"\nsemi_axes = [0.001, 0.001, 0.002]\n"
    "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.001, 0.001, 0, 0, 0, 0.001, 0, 0, 0.001, 0.001]\n"
    "[[shape]]\nname = \"disc\"\nkind = \"superquadric\"\nsemi_axes = [0.003, 0.003, 0.0005]\nexponents = [4, 2]\n"
    "[[shape]]\nname = \"hook\"\nspheres = [0, 0, 0, 0.001, 0, 0, 0.0013, 0.0006, 0.0011, 0, 0, 0.0008]\n";

/// Domain [0, upper], periodic in x and y.
Scene scene_of(Vec3 upper, const std::string& gas, const std::string& rest, const std::string& head = {},
               const std::string& law = "normal_stiffness = 200\nrestitution = 0.5\nfriction = 0.3") {
  return parse_scene(
      fmt::format("{}{}seed = 5\n[domain]\nlower = [0, 0, 0]\nupper = [{}, {}, {}]\nboundary = [\"periodic\", "
                  "\"periodic\", \"wall\"]\n[time]\nstep = 1e-5\nduration = 10\n[[material]]\nname = \"m\"\ndensity = "
                  "2000\n[contact]\n{}\n[gas]\n{}\n",
                  head, head.find("gravity") == std::string::npos ? "gravity = [0, 0, 0]\n" : "", upper.x, upper.y,
                  upper.z, law, gas) +
          k_shapes + rest,
      "bodies", "", {});
}

const std::vector<double>& cells_of(const GridData& g, const std::string& name) {
  for (const PolyColumn& c : g.cell_data)
    if (c.name == name) return std::get<std::vector<double>>(c.values);
  throw std::runtime_error("no " + name);
}

double volume_of(Simulation& sim) {
  const World& w = EngineAccess::world(sim);
  double sum = 0;
  for (Row i = 0; i < w.rows.n; ++i)
    if (w.rows.leads(i)) sum += mass_of(w.rules, w.rows, i) / 2000;
  return sum;
}

TEST(GasBodies, TheirTrueVolumeIsInTheCells) {
  // a disc that lies on the floor: the ball of its volume would reach through it
  const Table disc("x,y,z,shape,scale\n0.02,0.0001,0.0005,disc,1\n0.005,0.01,0.006,disc,0.9\n");
  const std::string rest = disc.source() + source("eggs", 30, "[0, 0, 0]", "[0.03, 0.03, 0.03]", "shape = \"egg\"") +
                           source("rods", 30, "[0, 0, 0]", "[0.03, 0.03, 0.03]", "shape = \"rod\"") +
                           source("hooks", 30, "[0, 0, 0]", "[0.03, 0.03, 0.03]", "shape = \"hook\"", "0.004") +
                           source("balls", 10, "[0, 0, 0]", "[0.03, 0.03, 0.03]", "", "0.003");
  for (const char* cells : {"[1, 1, 1]", "[6, 5, 7]"}) {
    Simulation sim(scene_of({0.03, 0.03, 0.03}, fmt::format("cells = {}\nleast_porosity = 0.05", cells), rest), {});
    const GridData grid = sim.part_grids()[0].second;
    double solid = 0, least = 1;
    for (const double e : cells_of(grid, "porosity"))
      solid += (1 - e) * grid.spacing.x * grid.spacing.y * grid.spacing.z, least = std::fmin(least, e);
    EXPECT_GT(least, 0.06);
    EXPECT_NEAR(solid / volume_of(sim), 1, 1e-12) << cells;
  }
}

TEST(GasBodies, ACellThatGetsMoreThanItHoldsIsSaid) {
  const Table table("x,y,z,shape,scale,fixed\n0.015,0.015,0.015,box,1,1\n");
  const std::string box =
      "[[shape]]\nname = \"box\"\nkind = \"superquadric\"\nsemi_axes = [0.003, 0.003, 0.003]\nexponents = [20, 20]\n";
  for (const char* cells : {"[18, 18, 18]", "[5, 5, 5]"}) {
    Simulation sim(scene_of({0.03, 0.03, 0.03}, fmt::format("cells = {}\nevery = 1", cells), box + table.source()), {});
    sim.run(1);
    int said = 0;
    for (const Warning& w : sim.warnings()) said += w.text.find("of its volume of grains") != std::string::npos;
    EXPECT_EQ(said, cells[1] == '1' ? 1 : 0) << "its ellipsoid is fuller than the box";
  }
}

/// Bodies held in a lattice, 2 x 2 x 2 to a cell.
std::string lattice(const char* shape) {
  std::string rows = "x,y,z,shape,scale,fixed\n";
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i)
        rows += fmt::format("{},{},{},{},1.2,1\n", 0.0025 + 0.005 * i, 0.0025 + 0.005 * j, 0.0025 + 0.005 * k, shape);
  return rows;
}

constexpr const char* k_blown =
    "every = 1\n[[gas.inlet]]\nside = \"bottom\"\nvelocity = 2\n[[gas.inlet]]\nside = \"top\"\nkind = \"pressure\"\n";

TEST(GasBodies, ABedTakesErgunsDropAtSphericityTimesDiameter) {
  const double e2 = std::sqrt(0.75), egg_area = 2 * M_PI * (1 + 2 / e2 * std::asin(e2)) * 1e-6,
               egg_volume = 4.0 / 3 * M_PI * 2e-9;
  for (const char* shape : {"egg", "rod"}) {
    const Table table(lattice(shape));
    for (const char* law : {"ergun", "gidaspow"}) {
      Simulation sim(scene_of({0.01, 0.01, 0.05},
                              fmt::format("cells = [1, 1, 5]\nmost_porosity = 0.999\ndrag = \"{}\"\n{}", law, k_blown),
                              table.source()),
                     {});
      sim.run(20);
      const BodyShape& body = *rules_of(sim).scene.shapes[shape[0] == 'e' ? 0 : 1].body;
      const double area = shape[0] == 'e' ? egg_area : shapes::surface_area(body.spheres),
                   volume = shape[0] == 'e' ? egg_volume : body.volume;
      const double d_v = std::cbrt(6 * volume / M_PI), psi = M_PI * d_v * d_v / area, d = 1.2 * psi * d_v;
      EXPECT_LT(psi, 0.95);
      const GridData g = sim.part_grids()[0].second;
      for (std::size_t c = 0; c < 5; ++c) {
        const double e = cells_of(g, "porosity")[c], u = cells_of(g, "velocity")[3 * c + 2];
        const double mu = viscosity(cells_of(g, "temperature")[c]), rho = cells_of(g, "density")[c];
        EXPECT_NEAR(e, 1 - 8 * 1.728 * volume / 1e-6, 1e-9);
        const double drop =
            150 * mu * (1 - e) * (1 - e) / (e * e * e * d * d) * u + 1.75 * rho * (1 - e) / (e * e * e * d) * u * u;
        const double ratio = -cells_of(g, "pressure_gradient")[3 * c + 2] / drop;
        if (law[0] == 'e') {
          EXPECT_NEAR(ratio, 1, 1e-6) << shape << ' ' << c;
        }
      }
      // what grains get and what the gas loses are one sum
      EXPECT_NEAR(value_of(sim, "gas.force_z") / (value_of(sim, "gas.pressure_drop") * 1e-4), 1, 1e-11);
      EXPECT_LT(std::fabs(value_of(sim, "gas.mass_residual")), 1e-12 * value_of(sim, "gas.mass_in"));
    }
  }
}

TEST(GasBodies, ForceActsOnTheCentreAndTurnsNothing) {
  const Table table("x,y,z,shape,scale,qw,qx,qy,qz\n0.005,0.005,0.01,hook,1,0.8,0.36,0.48,0\n");
  for (const char* friction : {"false", "0.3"}) {  // without it spheres have no rotation
    const std::string law =
        std::string("normal_stiffness = 200\nrestitution = 0.5\n") + (friction[0] == '0' ? "friction = 0.3" : "");
    Simulation sim(scene_of({0.01, 0.01, 0.05}, std::string("cells = [1, 1, 5]\n") + k_blown, table.source(), {}, law),
                   {});
    sim.run(2);
    const double force = value_of(sim, "gas.force_z");
    const Sums before = sums_of(sim);
    sim.run(1);
    EXPECT_NEAR((sums_of(sim).momentum.z - before.momentum.z) / (force * 1e-5), 1, 1e-9);
    sim.run(2000);
    const Sums s = sums_of(sim);
    const Bodies& b = bodies_of(sim);
    EXPECT_GT(b.v[2], 0.01);
    const double turn = norm(momentum_in_space(rules_of(sim), b, 0)), arm = 1e-3 * s.momentum.z;
    EXPECT_LT(turn, 1e-12 * arm) << friction;
    EXPECT_LT(std::fabs(b.v[0]) + std::fabs(b.v[1]), 1e-12 * b.v[2]);
  }
}

/// Blown from rest, a body has the energy that the gas has brought; the trapezium rule errs by less than the steps of
/// gas, over which the force is a line in the velocity.
TEST(GasBodies, TheWorkOfTheGasIsInTheLedger) {
  const Table table("x,y,z,shape,scale,qw,qx,qy,qz\n0.005,0.005,0.01,hook,1,0.8,0.36,0.48,0\n");
  Scene s = scene_of({0.01, 0.01, 0.05}, std::string("cells = [1, 1, 5]\n") + k_blown, table.source());
  s.output.energies = true;
  Simulation sim(s, {});
  sim.run(2000);
  const Energies e = sim.energies();
  EXPECT_GT(e.kinetic_translation, 0);
  EXPECT_NEAR(e.wall_work / e.kinetic_translation, 1, 1e-3);
  EXPECT_LT(std::fabs(e.residual), 1e-3 * e.kinetic_translation);
}

/// C_D of a sphere as the law has it, by Reynolds' number.
double sphere_drag(GasDrag law, double re) {
  if (law == GasDrag::di_felice) return std::pow(0.63 + 4.8 / std::sqrt(re), 2);
  return re < 1000 ? 24 / re * (1 + 0.15 * std::pow(re, 0.687)) : 0.44;
}

TEST(GasBodies, AFallingBodyReachesTheTerminalSpeedOfGansersCorrelation) {
  const double rho = 101325 / (specific_gas_constant(k_air) * 300), mu = viscosity(300);
  for (const GasDrag law : {GasDrag::gidaspow, GasDrag::di_felice})
    for (const char* shape : {"egg", "rod", "disc"}) {
      const Table table(fmt::format("x,y,z,shape,scale\n0.012,0.012,1.98,{},0.06\n", shape));
      Scene s = scene_of({0.024, 0.024, 2}, fmt::format("cells = [1, 1, 50]\ndrag = \"{}\"", enum_word(law)),
                         table.source(), "gravity = [0, 0, -9.81]\n", "normal_stiffness = 0.1\nrestitution = 0.5");
      Simulation sim(s, {});
      sim.run(60000);
      ASSERT_EQ(sim.particles(), 1);
      const Bodies& b = bodies_of(sim);
      const double v = -b.v[2], mass = b.mass(0), volume = mass / 2000;
      const BodyShape& body = shape_of(rules_of(sim), b, 0);
      const double area =
          0.06 * 0.06 *
          (body.quadric ? shapes::surface_area(body.quadric->surface) : shapes::surface_area(body.spheres));
      const double d = std::cbrt(6 * volume / M_PI), psi = M_PI * d * d / area;
      const double k1 = std::sqrt(psi), k2 = std::pow(10, 1.8148 * std::pow(-std::log10(psi), 0.5743));
      double low = 0, high = 20;
      for (int k = 0; k < 80; ++k) {
        const double u = 0.5 * (low + high), re = rho * u * d / mu;
        const double drag = k2 * sphere_drag(law, k1 * k2 * re) * 0.5 * rho * u * u * M_PI / 4 * d * d;
        (drag < (mass - rho * volume) * 9.81 ? low : high) = u;
      }
      EXPECT_NEAR(v / low, 1, 0.005) << enum_word(law) << ' ' << shape;
      RecordProperty(fmt::format("{} {}", enum_word(law), shape), fmt::format("{:.6g} {:.6g} {:.4g}", v, low, psi));
      std::printf("terminal speed, %s, %s of sphericity %.4f, d_v %.4g m: %.6f m/s, closed form %.6f\n",
                  std::string(enum_word(law)).c_str(), shape, psi, d, v, low);
    }
}

/// A clump of one sphere and a superquadric that is a ball are spheres to the gas.
TEST(GasBodies, BallsOfEveryKindDoWhatSpheresDo) {
  const char* kinds[] = {"", "[[shape]]\nname = \"ball\"\nspheres = [0, 0, 0, 0.002]\n",
                         "[[shape]]\nname = \"ball\"\nkind = \"superquadric\"\nsemi_axes = [0.002, 0.002, 0.002]\n"};
  std::vector<std::vector<PartValue>> all;
  std::vector<double> height;
  for (const char* kind : kinds) {
    const std::string ball = *kind == 0 ? "" : "shape = \"ball\"\n";
    Simulation sim(scene_of({0.03, 0.03, 0.06},
                            "cells = [3, 3, 6]\nevery = 20\ntemperature = 900\n[[gas.inlet]]\nside = \"bottom\"\n"
                            "velocity = 3\n[[gas.inlet]]\nside = \"top\"\nkind = \"pressure\"\n[heat]\n"
                            "temperature = 300\ncapacity = 800\nconductivity = 2\nevery = 20\n",
                            kind + source("balls", 200, "[0, 0, 0]", "[0.03, 0.03, 0.05]",
                                          ball + "velocity = [0, 0.1, 0]", "0.004"),
                            "gravity = [0, 0, -9.81]\n"),
                   {});
    sim.run(400);
    all.push_back(sim.part_values());
    double sum = 0;
    for (const Vec3& x : sim.frame().x) sum += x.z;
    height.push_back(sum);
  }
  for (std::size_t k = 1; k < all.size(); ++k) {
    ASSERT_EQ(all[k].size(), all[0].size());
    EXPECT_NEAR(height[k] / height[0], 1, 1e-12);
    for (const char* name : {"gas.force_z", "gas.heat_from_grains", "gas.pressure_drop", "heat.total", "heat.lowest",
                             "gas.temperature_min", "gas.enthalpy"})
      for (std::size_t q = 0; q < all[0].size(); ++q)
        if (all[0][q].name == name) {
          EXPECT_NEAR(all[k][q].value / all[0][q].value, 1, 1e-12) << kinds[k] << name;
        }
  }
}

TEST(GasBodies, HeatPassesTheTrueSurfaceByTheLawOfTheSphereOfEqualVolume) {
  for (const char* shape : {"egg", "rod"}) {
    const Table table(fmt::format("x,y,z,shape,scale,fixed\n0.015,0.015,0.015,{},1.5,1\n", shape));
    Simulation sim(scene_of({0.03, 0.03, 0.03},
                            "cells = [1, 1, 1]\nevery = 1\nnusselt = \"wakao\"\ntemperature = 300\n[heat]\n"
                            "temperature = 400\ncapacity = 800\nconductivity = 2\nevery = 1\n",
                            table.source()),
                   {});
    sim.run(1);
    const BodyShape& body = *rules_of(sim).scene.shapes[shape[0] == 'e' ? 0 : 1].body;
    const double area =
        2.25 * (body.quadric ? shapes::surface_area(body.quadric->surface) : shapes::surface_area(body.spheres));
    // at rest Nu = 2; the gas takes it implicitly and is hardly warmed in a step
    const double flow = 2 * conductivity(k_air, 300) / (2 * 1.5 * body.equal_radius) * area * 100;
    EXPECT_NEAR(value_of(sim, "gas.heat_from_grains") / (flow * 1e-5), 1, 1e-5) << shape;
  }
}

TEST(GasBodies, AClosedBoxKeepsItsEnergyAndItsGas) {
  Scene s = scene_of({0.03, 0.03, 0.03},
                     "cells = [3, 4, 3]\nevery = 10\ntemperature = 600\n[heat]\ntemperature = 300\ncapacity = 8\n"
                     "conductivity = 2\nevery = 10\n",
                     source("eggs", 40, "[0, 0, 0]", "[0.03, 0.03, 0.03]", "shape = \"egg\"\ntemperature = 900") +
                         source("rods", 40, "[0, 0, 0]", "[0.03, 0.03, 0.03]", "shape = \"rod\"") +
                         source("balls", 20, "[0, 0, 0]", "[0.03, 0.03, 0.03]", "", "0.003"),
                     "gravity = [1, 2, -90]\n");
  Simulation sim(s, {});
  sim.run(10);
  const auto energy = [&] {
    return value_of(sim, "heat.total") + value_of(sim, "gas.enthalpy") - value_of(sim, "gas.pressure_work");
  };
  const double before = energy(), heat = value_of(sim, "heat.total"), low = value_of(sim, "heat.lowest");
  sim.run(3000);
  EXPECT_GT(sim.counters().contacts, 5);
  EXPECT_GT(value_of(sim, "heat.lowest"), low + 1) << "heat has passed";
  EXPECT_NEAR(energy() / before, 1, 1e-12) << heat;
  EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-12 * heat);
  EXPECT_EQ(value_of(sim, "gas.mass_in"), 0);
  EXPECT_LT(value_of(sim, "gas.element_residual"), 1e-17);
}

TEST(GasBodies, ALawFittedToSpheresIsRefused) {
  const std::string egg = source("eggs", 2, "[0, 0, 0]", "[0.03, 0.03, 0.03]", "shape = \"egg\"");
  try {
    scene_of({0.03, 0.03, 0.03}, "cells = [2, 2, 2]\ndrag = \"beetstra\"", egg);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("gas.drag"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("di_felice"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace talus::gas
