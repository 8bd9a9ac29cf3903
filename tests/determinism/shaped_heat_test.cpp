// Heat of clumps and superquadrics among spheres: a function of the trajectory alone, and exact across a resume.
#include <gtest/gtest.h>

#include <cmath>

#include "core/scene/scene_file.hpp"
#include "tests/determinism/part_final.hpp"

namespace talus::determinism {
namespace {

constexpr const char* k_scene = R"(
title = "heat of bodies"
gravity = [1, 0, -9.81]
seed = 11
sort_every = 250
[domain]
lower = [-0.01, 0, 0]
upper = [0.01, 0.016, 0.03]
boundary = ["periodic", ["wall", "open"], "wall"]
[time]
step = 8e-6
duration = 1
[[material]]
name = "m"
density = 2000
young = 1.5e6
poisson = 0.3
[material.heat]
latent_heat = 1e5
solidus = 320
liquidus = 340
[contact]
model = "hertz_mindlin"
restitution = 0.6
friction = 0.4
[heat]
temperature = 300
capacity = 800
conductivity = 200
emissivity = 0.8
every = 20
friction = true
[heat.gas]
temperature = 500
velocity = [0, 1, 0]
[heat.radiation]
enclosure = 900
[[heat.wall]]
wall = "domain_z_lower"
temperature = 700
[[heat.wall]]
wall = "paddle"
flux = 1e4
[[group]]
name = "few"
region = { lower = [-0.01, 0, 0], upper = [0, 0.016, 0.004] }
[[wall]]
name = "paddle"
shape = "plane"
point = [0, 0.0005, 0]
normal = [0, 1, 0.1]
[wall.motion]
velocity = [0, 0.1, 0]
[[event]]
time = 0.005
action = "freeze"
group = "few"
[[source]]
name = "eggs"
kind = "random"
number = 80
shape = "egg"
velocity = [0, 0.3, -1]
temperature = 400
[source.region]
lower = [-0.01, 0, 0.003]
upper = [0.01, 0.016, 0.021]
[source.size]
kind = "uniform"
min = 0.0018
max = 0.0026
[[source]]
name = "rods"
kind = "stream"
shape = "rod"
number_rate = 12000
interval = 0.0007
velocity = [0.2, 0.2, -1]
temperature = 310
[source.region]
lower = [-0.01, 0, 0.022]
upper = [0.01, 0.016, 0.0295]
[[source]]
name = "held"
kind = "random"
number = 10
shape = "rod"
velocity_jitter = 0.4
temperature = 600
hold_temperature = true
[source.region]
lower = [-0.01, 0, 0.001]
upper = [0.01, 0.016, 0.021]
[[source]]
name = "balls"
kind = "random"
number = 40
velocity_jitter = 0.4
[source.region]
lower = [-0.01, 0, 0.001]
upper = [0.01, 0.016, 0.021]
[source.size]
kind = "uniform"
min = 0.0014
max = 0.002
[[shape]]
name = "egg"
kind = "superquadric"
semi_axes = [0.002, 0.001, 0.0014]
exponents = [3, 2.5]
[[shape]]
name = "rod"
spheres = [0, 0, -0.0015, 0.001, 0, 0, 0, 0.001, 0, 0, 0.0015, 0.001]
)";

constexpr std::int64_t k_run = 900;  // with three sort epochs

TEST(ShapedHeat, DependsOnTheTrajectoryAloneGoesOnAfterAResumeAndBalances) {
  const Scene s = parse_scene(k_scene, "heat of bodies", "", {});
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  first.run(k_run);
  EXPECT_GT(first.counters().contacts, 5);
  EXPECT_GT(first.counters().inserted, 50);
  EXPECT_LT(std::fabs(value_of(first, "heat.residual")), 1e-12 * value_of(first, "heat.total"));
  for (const char* name : {"heat.in_by_walls", "heat.in_by_gas", "heat.in_by_radiation", "heat.in_by_friction",
                           "heat.in_by_held", "heat.flow.domain_z_lower", "heat.flow.paddle", "heat.molten"})
    EXPECT_NE(value_of(first, name), 0) << name;
  expect_same_in_other_ways(s, k_run, final_of(first));
  expect_same_after_resume(s, k_run, {333, 727});
}

}  // namespace
}  // namespace talus::determinism
