// Events act at their time, not half a step beside it: free flight between them is the exact parabola at every step,
// and the balance of energies closes, along periodic axes too.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "core/scene/scene_file.hpp"
#include "scheduler/simulation.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_dt = 1e-4;

struct Kind {
  const char *name, *section;
};
void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }
constexpr Kind k_kinds[] = {
    {"sphere", ""},
    {"ball", "[[shape]]\nname = \"ball\"\nkind = \"superquadric\"\nsemi_axes = [1, 0.7, 0.5]\n"},
    {"pair", "[[shape]]\nname = \"pair\"\nkind = \"clump\"\nspheres = [0, 0, 0, 1, 1, 0, 0, 0.6]\n"}};

std::string scene_of(const Kind& kind, const std::string& boundary) {
  const std::string of = *kind.section == '\0' ? "" : fmt::format("shape = \"{}\"\n", kind.name);
  return "gravity = [0.5, 0, -9.81]\n[domain]\nlower = [-1, -1, -1]\nupper = [1, 1, 1]\nboundary = " + boundary +
         "\n[time]\nstep = 1e-4\nsteps = 500\n[[material]]\nname = \"glass\"\ndensity = 2500\n"
         "[contact]\nnormal_stiffness = 1e4\nfriction = 0.3\nrestitution = 0.5\n" +
         kind.section +
         "[[source]]\nkind = \"random\"\nnumber = 1\nvelocity = [0.1, 0.2, 0.3]\nsize = { diameter = 0.01 }\n"
         "region = { lower = [-0.1, -0.1, -0.1], upper = [0.1, 0.1, 0.1] }\n" +
         of +
         "[[group]]\nname = \"all\"\nregion = { lower = [-1, -1, -1], upper = [1, 1, 1] }\n"
         "[[event]]\ntime = 0.01\naction = \"gravity\"\ngravity = [-1, 2, 4]\n"
         "[[event]]\ntime = 0.02\naction = \"freeze\"\ngroup = \"all\"\n"
         "[[event]]\ntime = 0.03\naction = \"release\"\ngroup = \"all\"\n"
         "[[event]]\ntime = 0.04\naction = \"set_velocity\"\ngroup = \"all\"\nvelocity = [0.3, -0.1, 0.7]\n"
         "[output]\nenergies = true\n";
}

/// Displacement since the start at time t.
Vec3 path(double t) {
  const Vec3 g0{0.5, 0, -9.81}, g1{-1, 2, 4}, v0{0.1, 0.2, 0.3}, set{0.3, -0.1, 0.7};
  const auto flight = [](Vec3 v, Vec3 g, double s) { return s * v + (0.5 * s * s) * g; };
  Vec3 x = flight(v0, g0, std::min(t, 0.01));
  x = x + flight(v0 + 0.01 * g0, g1, std::clamp(t - 0.01, 0.0, 0.01));
  x = x + flight({}, g1, std::clamp(t - 0.03, 0.0, 0.01));
  return x + flight(set, g1, std::max(t - 0.04, 0.0));
}

class EventTimes : public ::testing::TestWithParam<Kind> {};

TEST_P(EventTimes, FreeFlightBetweenEventsIsTheParabolaAtEveryStep) {
  for (const char* boundary : {"\"open\"", "[\"periodic\", \"open\", \"open\"]"}) {
    Simulation sim(parse_scene(scene_of(GetParam(), boundary), "t.toml", "."), options());
    const Vec3 start = sim.frame().x[0];
    double off = 0, residual = 0;
    for (int n = 1; n <= 500; ++n) {
      sim.run(1);
      off = std::max(off, norm(sim.frame().x[0] - start - path(n * k_dt)));
      const Energies e = sim.energies();
      residual = std::max(residual, std::fabs(e.residual) / sphere_mass(2500, 0.005));
    }
    // 500 sums of rounding at lengths of 1; half a step too early is g dt t / 2 = 2e-5 by the end
    EXPECT_LT(off, 1e-13) << boundary;
    EXPECT_LT(residual, 1e-12) << boundary << " [J/kg], of some 0.5";
  }
}

/// Three grains of the group "bed"; the first is fixed in its file, the second is held by an event.
Scene scene_of_groups() {
  Scene s = open_scene({0, 0, 0}, {1, 1, 1}, k_dt);
  linear_law(s, 1e3, 0);
  add_grains(s, {{{0.2, 0.5, 0.5}, {}, 0.04, {}, 0, true}, {{0.5, 0.5, 0.5}, {}, 0.04}, {{0.8, 0.5, 0.5}, {}, 0.04}});
  s.sources[0].group = 0;
  s.groups.resize(3);
  s.groups[0].name = "bed";
  s.groups[1].name = "walls";
  s.groups[1].fixed_in_file = true;
  s.groups[2].name = "second";
  s.groups[2].ids = {{1, 1}};
  return s;
}

void add_event(Scene& s, Event::Action action, double time, int group, Vec3 velocity = {}) {
  Event e;
  e.action = action;
  e.time = time;
  e.group = group;
  e.vector = velocity;
  s.events.push_back(e);
}

TEST(EventGroups, FixedInFileMeansTheFileNotWhoeverIsHeldNow) {
  Scene s = scene_of_groups();
  add_event(s, Event::Action::freeze, 0, 2);
  add_event(s, Event::Action::drive, 0.01, 1, {1, 0, 0});
  Simulation sim(s, options());
  sim.run(300);
  const Frame f = sim.frame();
  EXPECT_NEAR(f.x[0].x, 0.22, 1e-12);
  EXPECT_EQ(f.x[1].x, 0.5) << "held, but not by its file";
  EXPECT_EQ(f.x[2].x, 0.8);
  EXPECT_EQ(f.fixed, (std::vector<std::uint8_t>{1, 1, 0}));
}

TEST(EventGroups, AFixedGrainBelongsToTheGroupOfItsSourceAsWell) {
  Scene s = scene_of_groups();
  add_event(s, Event::Action::freeze, 0, 2);
  add_event(s, Event::Action::release, 0.01, 1);
  add_event(s, Event::Action::remove, 0.02, 0);
  Simulation sim(s, options());
  sim.run(150);
  EXPECT_EQ(sim.frame().fixed, (std::vector<std::uint8_t>{0, 1, 0}));
  sim.run(150);
  EXPECT_EQ(sim.particles(), 0);
}

INSTANTIATE_TEST_SUITE_P(Grains, EventTimes, ::testing::ValuesIn(k_kinds),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace talus::physics
