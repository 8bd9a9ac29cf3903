// Shells and conversion of clumps and superquadrics among spheres: books close, a body is so many equal spheres, its
// shape follows their radius; the same bits for every way of running, exact across a resume, no contact missed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "core/shapes/surface_area.hpp"
#include "scheduler/parts/doors.hpp"
#include "tests/breathing.hpp"
#include "tests/determinism/charring_wood.hpp"
#include "tests/determinism/part_final.hpp"
#include "tests/determinism/shaped_bed.hpp"
#include "tests/shapes/body_support.hpp"

namespace talus::determinism {
namespace {

const std::string k_wood = k_charring_wood + R"([surroundings]
gas = "air"
temperature = 1400
oxygen = 0.23
)";

constexpr const char* k_inert = R"(title = "stone with shells"
[time]
step = 0.001
duration = 1
[grain]
diameter = 0.002
temperature = 300
[material]
density = 700
initial = { stone = 1 }
[heat_capacity]
fuel = { polynomial = [800, 1.5], origin = 273.15, range = [273, 900] }
[conductivity]
fuel = 0.8
[[solid]]
name = "stone"
[surroundings]
gas = "air"
temperature = 300
)";

std::string heat_and_conversion(int every, double gone_below) {
  return fmt::format(
      "[heat]\ntemperature = 900\ncapacity = 800\nconductivity = 2\nevery = {0}\nfriction = true\n[heat.gas]\n"
      "temperature = 1400\nvelocity = [0, 20, 0]\n[heat.radiation]\nenclosure = 1300\n[[heat.wall]]\nwall = "
      "\"domain_z_lower\"\ntemperature = 1100\n[conversion]\nevery = {0}\nshells = 6\ngone_below = {1}\n",
      every, gone_below);
}

Scene burning_bed(double gone_below = 0) {
  return parse_scene(bed_text(heat_and_conversion(20, gone_below), "grain = \"" + grain_file(k_wood) + "\"", k_law),
                     "shaped", "", {});
}

constexpr std::int64_t k_run = 900;  // with three sort epochs

TEST(ShapedConversion, DependsOnTheTrajectoryAloneAndItsBooksClose) {
  const Scene s = burning_bed();
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  first.run(k_run);
  const double mass = value_of(first, "conversion.mass");
  EXPECT_GT(first.counters().contacts, 5);
  EXPECT_GT(first.counters().inserted, 50);
  EXPECT_GT(value_of(first, "conversion.oxygen_taken"), 1e-6 * mass);
  EXPECT_GT(value_of(first, "conversion.released_volatiles"), 1e-6 * mass);
  EXPECT_LT(std::fabs(value_of(first, "conversion.mass_residual")), 1e-12 * mass);
  for (const char* element : {"carbon", "hydrogen", "oxygen", "ash", "water"})
    EXPECT_LT(std::fabs(value_of(first, fmt::format("conversion.{}_residual", element))), 1e-12 * mass) << element;
  EXPECT_LT(std::fabs(value_of(first, "conversion.heat_residual")), 1e-12 * value_of(first, "conversion.heat"));
  EXPECT_NEAR(value_of(first, "heat.into_shells") / value_of(first, "conversion.heat_in"), 1, 1e-12);
  EXPECT_LT(std::fabs(value_of(first, "heat.residual")), 1e-12 * value_of(first, "conversion.heat"));
  expect_same_in_other_ways(s, k_run, final_of(first));
}

TEST(ShapedConversion, ResumeGoesOnToTheBitWhileBodiesComeShrinkAndGo) {
  expect_same_after_resume(burning_bed(0.9), k_run, {333, 727});
}

TEST(ShapedConversion, BurntOutBodiesLeaveWholeAndTheirAshIsCounted) {
  Simulation sim(burning_bed(0.93), {});
  const World& w = EngineAccess::world(sim);
  const std::int64_t before = w.rows.grains();
  sim.run(k_run);
  const Counters n = sim.counters();
  EXPECT_GT(n.removed, 100);
  EXPECT_EQ(w.rows.grains(), before + n.inserted - n.removed);
  Row rows = 0;
  for (Row i = 0; i < w.rows.n; ++i)
    if (const std::int32_t b = w.rows.body_of(i); w.rows.is_alive(i) && b >= 0 && w.rows.leads(i))
      rows += static_cast<Row>(shape_of(w.rules, w.rows.bodies, b).spheres.size());
  EXPECT_EQ(rows, w.rows.of_bodies);
  EXPECT_LT(std::fabs(value_of(sim, "conversion.ash_residual")), 1e-12 * value_of(sim, "conversion.mass"));
  EXPECT_LT(std::fabs(value_of(sim, "conversion.mass_residual")), 1e-12 * value_of(sim, "conversion.mass"));
}

/// Alone in a film, the body's spheres do what one sphere of their radius does; the shape follows their radius.
TEST(ShapedConversion, ABodyDoesWhatAsManySpheresOfItsVolumeOverSurfaceDo) {
  const std::string wood = grain_file(k_wood + "film = 3000\n");
  const std::string head = fmt::format(
      "gravity = [0, 0, 0]\n[domain]\nlower = [0, 0, 0]\nupper = [0.05, 0.05, 0.05]\n[time]\nstep = 1e-5\nduration = "
      "1\n"
      "[[material]]\nname = \"m\"\ndensity = 700\ngrain = \"{}\"\n[contact]\nnormal_stiffness = 100\nrestitution = "
      "0.5\n"
      "[conversion]\nevery = 20\nshells = 8\n",
      wood);
  for (const char* shape : {"egg", "rod"}) {
    const Table table(
        fmt::format("x,y,z,shape,scale,vx,vy,vz,wx,wy,wz\n0.02,0.02,0.02,{},1.5,0.1,0,0.2,3,5,7\n", shape));
    Simulation body(parse_scene(head + k_shapes + table.source(), "body", "", {}), {});
    const BodyShape& form = *rules_of(body).scene.shapes[shape == std::string("egg") ? 0 : 1].body;
    const double area = form.quadric ? shapes::surface_area(form.quadric->surface) : shapes::surface_area(form.spheres);
    const double radius = 1.5 * 3 * form.volume / area,
                 number = 1.5 * 1.5 * 1.5 * form.volume / (4.0 / 3 * M_PI * std::pow(radius, 3));
    EXPECT_GT(number, 1.05);
    Simulation ball(parse_scene(head + fmt::format("[[source]]\nkind = \"random\"\nnumber = 1\nsize = {{ diameter = "
                                                   "{:.17g} }}\n[source.region]\nlower = [0.02, 0.02, 0.02]\nupper = "
                                                   "[0.03, 0.03, 0.03]\n",
                                                   2 * radius),
                                "ball", "", {}),
                    {});
    const Bodies& bodies = bodies_of(body);
    const double scale = bodies.scale(0), mass = bodies.mass(0);
    const Vec3 spin = angular_velocity(rules_of(body), bodies, 0);
    body.run(4000);
    ball.run(4000);
    for (const char* name : {"conversion.mass", "conversion.fuel", "conversion.char", "conversion.heat",
                             "conversion.heat_in", "conversion.oxygen_taken", "conversion.released_volatiles"})
      EXPECT_NEAR(value_of(body, name) / (number * value_of(ball, name)), 1, 1e-9) << shape << ' ' << name;
    const World& w = EngineAccess::world(ball);
    const double shrunk = w.rows.p[3] / radius;
    EXPECT_LT(shrunk, 0.995);
    EXPECT_NEAR(bodies.scale(0) / scale, shrunk, 1e-9);
    EXPECT_NEAR(bodies.mass(0) / mass, mass_of(w.rules, w.rows, 0) / (4.0 / 3 * M_PI * 700 * std::pow(radius, 3)),
                1e-9);
    EXPECT_NEAR(bodies.v[4 * 0 + 2], 0.2, 1e-15) << "velocity stays";
    // free rotation changes the angular velocity, not its momentum over what its inertia has become
    const double inertia = bodies.mass(0) * std::pow(bodies.scale(0), 2) / (mass * scale * scale);
    Simulation still(parse_scene(head + "resize = false\n" + k_shapes + table.source(), "still", "", {}), {});
    const double before = norm(momentum_in_space(rules_of(still), bodies_of(still), 0));
    EXPECT_NEAR(norm(momentum_in_space(rules_of(body), bodies, 0)) / (inertia * before), 1, 1e-9) << norm(spin);
  }
}

TEST(ShapedConversion, AClosedBoxOfBodiesWithShellsKeepsItsHeat) {
  const std::string parts =
      "[heat]\ntemperature = 300\ncapacity = 800\nconductivity = 2\nevery = 20\n[conversion]\nevery = 20\nshells = 8\n";
  Scene s = parse_scene(bed_text(parts, "grain = \"" + grain_file(k_inert) + "\"", k_law), "closed", "", {});
  std::erase_if(s.sources, [](const Source& q) { return q.kind == Source::Kind::stream; });
  s.heat.sources.erase(s.heat.sources.begin() + 1);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  for (std::size_t k = 0; k < s.heat.sources.size(); ++k)
    s.heat.sources[k].temperature = 300 + 300 * static_cast<double>(k);
  Simulation sim(s, {});
  const double before = value_of(sim, "conversion.heat");
  sim.run(1500);
  EXPECT_NEAR(value_of(sim, "conversion.heat") / before, 1, 1e-12);
  const World& w = EngineAccess::world(sim);
  const Column<double>& T = part_as<GrainHeat>(w.parts)->temperature();
  int changed = 0;
  for (Row i = 0; i < w.rows.n; ++i)
    changed += w.rows.body_of(i) >= 0 && std::fabs(std::remainder(T[static_cast<std::size_t>(i)], 300)) > 1e-3 ? 1 : 0;
  EXPECT_GT(changed, 20) << "they have touched";
}

// --- sizes -----------------------------------------------------------------------------------------------------------

Scene plain_bed(const char* law = k_law, double dt = 8e-6) {
  Scene s = parse_scene(bed_text("", "", law, dt), "plain", "", {});
  std::erase_if(s.sources, [](const Source& q) { return q.kind == Source::Kind::stream; });
  return s;
}

class ResizedBodies : public ::testing::TestWithParam<ListPolicy> {};

TEST_P(ResizedBodies, MissNoContactAndHaveTheSameBits) {
  Scene s = plain_bed();
  s.output.energies = false;
  constexpr std::int64_t steps = 300;
  Simulation wanted(s, {});
  breathe(wanted, 0.2, steps);
  wanted.run(steps);
  Simulation fixed(s, {});
  fixed.run(steps);
  EXPECT_NE(fixed.state_hash(), wanted.state_hash());
  const Variant v{GetParam(), 60, 2, 64, Isa::automatic};
  RunOptions o = v.options();
  o.audit = true;
  Simulation sim(v.apply(s), o);
  breathe(sim, 0.2, steps);
  sim.run(steps);
  const Counters n = sim.counters();
  EXPECT_EQ(n.missed_contacts, 0) << v.text();
  EXPECT_GT(n.contacts, 0);
  if (GetParam() != ListPolicy::always) {
    EXPECT_LT(n.rebuilds, steps / 2) << "the lists have lasted";
  }
  EXPECT_EQ(sim.state_hash(), wanted.state_hash()) << v.text();
}

INSTANTIATE_TEST_SUITE_P(Policies, ResizedBodies, ::testing::ValuesIn(exact_policies()),
                         [](const auto& p) { return std::string(enum_word(p.param)); });

/// Elastic and smooth: what changing sizes bring in is all that the energy changes by, to the order of the integrator.
TEST(ResizedBodies, LedgerCountsWhatTheSizesBringIn) {
  const auto worst = [](const char* law, bool eggs, double dt, std::int64_t steps) {
    Scene s = plain_bed(law, dt);
    if (!eggs) s.sources.erase(s.sources.begin());
    s.gravity = {};
    s.output.energies = true;
    for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
    Simulation sim(s, {});
    breathe(sim, 0.15, steps);
    double most = 0;
    for (int k = 0; k < 10; ++k) {
      sim.run(steps / 10);
      most = std::max(most, std::fabs(sim.energies().residual / sim.energies().sizes));
    }
    EXPECT_GT(std::fabs(sim.energies().sizes), 1e-3 * sim.energies().kinetic_translation);
    return most;
  };
  // superquadrics keep energy with a constant stiffness alone: R* of Hertz follows their curvature
  const char *linear = "normal_stiffness = 100\nrestitution = 1\nfriction = 0",
             *hertz = "model = \"hertz_mindlin\"\nrestitution = 1\nfriction = 0";
  for (const bool eggs : {true, false}) {
    const double coarse = worst(eggs ? linear : hertz, eggs, 4e-6, 1000),
                 fine = worst(eggs ? linear : hertz, eggs, 2e-6, 2000);
    EXPECT_LT(coarse, 0.01);
    EXPECT_LT(fine, 0.4 * coarse);
  }
}

// --- refusals --------------------------------------------------------------------------------------------------------

TEST(ShapedConversion, WhatKnowsSpheresAloneIsRefused) {
  const std::string wood = "grain = \"" + grain_file(k_wood) + "\"", parts = heat_and_conversion(20, 0);
  const auto message = [&](std::string text) {
    try {
      Simulation sim(parse_scene(text, "refused", "", {}), {});
    } catch (const Error& e) {
      return std::string(e.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(message(bed_text(parts, wood, k_law)), "accepted");
  EXPECT_NE(message(bed_text(parts + "[heat.gap]\nconductivity = 0.03\n", wood, k_law)).find("gap"), std::string::npos);
  const std::string other = message(bed_text(parts, wood, k_law) + "density = 900\n");
  EXPECT_NE(other.find("shape 'rod'"), std::string::npos) << other;
}

}  // namespace
}  // namespace talus::determinism
