// Claims about time step limits: closed forms, minimum over all pairs, refusal and warning.
#include "core/rules/timestep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "core/base/error.hpp"

namespace talus {
namespace {

constexpr double k_pi = 3.14159265358979323846;

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << text

Scene linear_scene() {
  Scene s;
  s.file = "t.toml";
  s.domain.boundary = {{{Boundary::periodic, Boundary::periodic},
                        {Boundary::periodic, Boundary::periodic},
                        {Boundary::periodic, Boundary::periodic}}};
  s.materials = {{"light", 1000, 0, 0}, {"heavy", 8000, 0, 0}};
  s.pairs.assign(4, {});
  s.contact.friction = false;
  s.contact.normal_stiffness = 1e5;
  s.contact.normal_damping = 1e-9;  // as good as none, and not none
  s.dt = 1e-9;
  return s;
}

double mass(double density, double r) { return density * 4.0 / 3.0 * k_pi * r * r * r; }

TEST(TimeStep, LinearLimitsFollowTheLightestPair) {
  const TimeStepReport t = time_step_limits(linear_scene(), 0.001, 0.002);
  const double m = mass(1000, 0.001) / 2;
  EXPECT_NEAR(t.contact.seconds / (k_pi * std::sqrt(m / 1e5)), 1, 1e-12);
  EXPECT_NEAR(t.isolated_pair.seconds / (2 * std::sqrt(m / 1e5)), 1, 1e-12);
  EXPECT_NEAR(t.packing.seconds / t.isolated_pair.seconds, 0.5, 1e-12);  // fcc: omega^2 = 8 k/m
  EXPECT_EQ(t.rayleigh.seconds, k_never);
  EXPECT_EQ(t.packing.pair, "light (r = 0.001) - light (r = 0.001)");
  EXPECT_TRUE(t.warning.empty());
  EXPECT_EQ(t.lines.size(), 4u);
}

TEST(TimeStep, WallCountsAsInfiniteMass) {
  Scene s = linear_scene();
  s.materials.resize(1);
  s.pairs.resize(1);
  const double free = time_step_limits(s, 0.001, 0.001).isolated_pair.seconds;
  // Alone with a wall the limit is sqrt(2) longer, so the pair of particles still rules.
  s.domain.boundary[2][0] = Boundary::wall;
  EXPECT_EQ(time_step_limits(s, 0.001, 0.001).isolated_pair.seconds, free);
  // A stiff wall under Hertz contacts rules.
  s.contact.model = ContactModel::hertz_mindlin;
  s.materials = {{"soft", 1000, 1e6, 0.3}, {"stiff", 1000, 1e11, 0.3}};
  s.pairs.assign(4, {0, 1});
  s.domain.wall_material = 1;
  s.sources.emplace_back();
  s.sources[0].velocity = {0, 0, -2};
  const TimeStepReport t = time_step_limits(s, 0.001, 0.001);
  EXPECT_EQ(t.velocity, 2);
  EXPECT_EQ(t.isolated_pair.pair, "soft (r = 0.001) on wall stiff");
}

TEST(TimeStep, DampedContactLastsLonger) {
  Scene s = linear_scene();
  const double m = mass(1000, 0.001) / 2, rate = 6000;
  s.contact.normal_damping = rate;
  const TimeStepReport t = time_step_limits(s, 0.001, 0.001);
  EXPECT_NEAR(t.contact.seconds / (k_pi / std::sqrt(1e5 / m - rate * rate / 4)), 1, 1e-12);
  // centred: (k dt^2/m + 4 g dt) / (1 + g dt) = 1 in a packing whose mode has four pairs' stiffness
  const double dt = t.packing.seconds;
  EXPECT_NEAR((1e5 / m * dt * dt + 4 * rate * dt) / (1 + rate * dt), 1, 1e-12);
  s.contact.dashpot = Dashpot::pairwise;
  const double pairwise = time_step_limits(s, 0.001, 0.001).packing.seconds;
  EXPECT_NEAR((1e5 / m * pairwise * pairwise + 2 * rate * pairwise) / (1 + 0.5 * rate * pairwise), 1, 1e-12);
  s.contact.dashpot = Dashpot::lagged;
  const double lagged = time_step_limits(s, 0.001, 0.001).packing.seconds;
  EXPECT_NEAR(1e5 / m * lagged * lagged + 2 * rate * lagged, 1, 1e-12);
  // The same damping stated by restitution gives the same limits.
  Scene e = linear_scene();
  e.contact.by_restitution = true;
  for (PairCoefficients& k : e.pairs) k.restitution = std::exp(-0.5 * rate * t.contact.seconds);
  EXPECT_NEAR(time_step_limits(e, 0.001, 0.001).contact.seconds / t.contact.seconds, 1, 1e-12);
  EXPECT_NEAR(time_step_limits(e, 0.001, 0.001).packing.seconds / t.packing.seconds, 1, 1e-12);
}

TEST(TimeStep, TangentialSpringsLowerThePackingLimitAsInAnFccCrystal) {
  // omega^2 = max(8 k_n + 8 k_t, 40 k_t) / m: the edge of the Brillouin zone, and all grains turning alike
  Scene s = linear_scene();
  s.contact.friction = true;
  for (const double ratio : {0.0, 0.1, 0.25, 2.0 / 7.0, 0.8, 1.0}) {
    s.contact.tangential_stiffness = ratio * 1e5;
    const TimeStepReport t = time_step_limits(s, 0.001, 0.001);
    const double omega2 = std::max(8 + 8 * ratio, 40 * ratio) * 1e5 / mass(1000, 0.001);
    EXPECT_NEAR(t.packing.seconds * std::sqrt(omega2), 2, 1e-12) << ratio;
  }
  s.contact.friction = false;  // no tangential force, no such mode
  EXPECT_NEAR(time_step_limits(s, 0.001, 0.001).packing.seconds * std::sqrt(8e5 / mass(1000, 0.001)), 2, 1e-12);
  // Cundall's damping brakes with a share of the force, drag with v(n-1/2)
  s.local_damping = 0.21;
  EXPECT_NEAR(time_step_limits(s, 0.001, 0.001).packing.seconds * std::sqrt(1.21 * 8e5 / mass(1000, 0.001)), 2, 1e-12);
  s.local_damping = 0;
  s.viscous_damping = 1e4;
  const double dt = time_step_limits(s, 0.001, 0.001).packing.seconds;
  EXPECT_NEAR(8e5 / mass(1000, 0.001) * dt * dt + 2e4 * dt, 4, 1e-11);
}

// Chung and Ooi, test 1: two glass spheres of 10 mm at +-10 m/s touch for 40.34 us.
TEST(TimeStep, HertzContactTimeIsTheClosedForm) {
  Scene s = linear_scene();
  s.contact.model = ContactModel::hertz_mindlin;
  s.materials = {{"glass", 2800, 4.8e10, 0.2}};
  s.pairs.assign(1, {0, 1});
  const TimeStepReport t = time_step_limits(s, 0.010, 0.010, 20);
  EXPECT_NEAR(t.contact.seconds * 1e6, 40.34, 0.01);
  const double shear = 4.8e10 / 2.4;
  EXPECT_NEAR(t.rayleigh.seconds, k_pi * 0.010 * std::sqrt(2800 / shear) / (0.1631 * 0.2 + 0.8766), 1e-12);
}

TEST(TimeStep, HertzSpeedComesFromGravityAndHeight) {
  Scene s = linear_scene();
  s.contact.model = ContactModel::hertz_mindlin;
  s.materials = {{"glass", 2500, 5e7, 0.25}};
  s.pairs.assign(1, {0, 0.8});
  s.gravity = {0, 0, -9.81};
  s.domain.upper = {1, 1, 4};
  EXPECT_NEAR(time_step_limits(s, 0.001, 0.001).velocity, std::sqrt(2 * 9.81 * 4), 1e-12);
  s.gravity = {};
  const TimeStepReport still = time_step_limits(s, 0.001, 0.001);
  EXPECT_TRUE(std::isfinite(still.packing.seconds));
  EXPECT_GT(still.packing.seconds, 0);
}

TEST(TimeStep, MaterialsThatOnlyWallsHaveDoNotMeetEachOther) {
  Scene s = linear_scene();
  s.contact.model = ContactModel::hertz_mindlin;
  s.materials = {{"soft", 2500, 1e6, 0.3}, {"steel", 7800, 2e11, 0.3}};
  s.pairs.assign(4, {0, 0.8});
  s.sources.emplace_back();  // material 0
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.walls.emplace_back();
  s.walls[0].material = 1;
  const TimeStepReport t = time_step_limits(s, 0.001, 0.001);
  EXPECT_EQ(t.rayleigh.pair, "soft (r = 0.001)");
  s.sources[0].kind = Source::Kind::file;  // a file may name any material
  EXPECT_EQ(time_step_limits(s, 0.001, 0.001).rayleigh.pair, "steel (r = 0.001)");
}

TEST(TimeStep, StepAboveThePackingLimitIsRefusedUnlessAllowed) {
  Scene s = linear_scene();
  const TimeStepReport t = time_step_limits(s, 0.001, 0.001);
  s.dt = t.packing.seconds * 1.001;
  try {
    time_step_limits(s, 0.001, 0.001);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    EXPECT_CONTAINS(e.what(), "above the packing limit");
    EXPECT_CONTAINS(e.what(), "light (r = 0.001) - light (r = 0.001)");
    EXPECT_CONTAINS(e.what(), "allow_unstable_step");
  }
  s.allow_unstable_step = true;
  EXPECT_CONTAINS(time_step_limits(s, 0.001, 0.001).warning, "above the packing limit");
  s.allow_unstable_step = false;
  s.dt = 0.21 * t.contact.seconds;
  EXPECT_CONTAINS(time_step_limits(s, 0.001, 0.001).warning, "21 % of the contact time");
  s.dt = 0.19 * t.contact.seconds;
  EXPECT_EQ(time_step_limits(s, 0.001, 0.001).warning, "");
}

/// Grains given one by one: material, radius, velocity.
Population grains_of(const std::vector<std::tuple<int, double, Vec3>>& list) {
  Population p;
  for (const auto& [material, r, v] : list) {
    p.add(material, false, r, r, 1);
    p.add_velocity(v, v);
  }
  return p;
}

TEST(TimeStep, WithoutAnyDampingEightStepsPerContactAreAsked) {
  Scene s = linear_scene();
  s.contact.normal_damping = 0;
  const TimeStepReport t = time_step_limits(s, 0.001, 0.001);
  EXPECT_NEAR(t.packing.seconds / t.contact.seconds, 0.125, 1e-12);
  EXPECT_CONTAINS(t.packing.pair, "without damping");
  s.contact.friction = true;  // rubbing takes energy out
  EXPECT_GT(time_step_limits(s, 0.001, 0.001).packing.seconds, 0.15 * t.contact.seconds);
  s.contact.friction = false;
  s.local_damping = 0.01;
  EXPECT_GT(time_step_limits(s, 0.001, 0.001).packing.seconds, 0.15 * t.contact.seconds);
}

TEST(TimeStep, PairsOnlyGrainsThatExist) {
  // soft grains of 2 mm and one steel sphere of 20 mm: no steel grain of 1 mm radius, no second steel sphere
  Scene s = linear_scene();
  s.contact.model = ContactModel::hertz_mindlin;
  s.contact.friction = true;
  s.gravity = {0, 0, -9.81};
  s.materials = {{"soft", 2500, 5e7, 0.3}, {"steel", 7800, 2e11, 0.3}};
  s.pairs.assign(4, {0.5, 0.8});
  const WallSet none;
  Population p;
  p.add(0, false, 0.001, 0.001, 5000);
  p.add(1, false, 0.010, 0.010, 1);
  const TimeStepReport t = time_step_limits(s, p, none);
  EXPECT_EQ(t.packing.pair, "soft (r = 0.001) - steel (r = 0.01)");
  // without knowing there might be steel grains of 1 mm: stiffer by the root and more
  EXPECT_LT(time_step_limits(s, 0.001, 0.010).packing.seconds, 0.1 * t.packing.seconds);
  p.add(1, false, 0.010, 0.010, 1);  // two steel spheres can meet
  EXPECT_EQ(time_step_limits(s, p, none).packing.pair, "steel (r = 0.01) - steel (r = 0.01)");
  // the two smallest grains of a kind make its smallest pair
  Scene springs = s;
  springs.contact.model = ContactModel::linear;
  springs.contact.normal_stiffness = 1e4;
  EXPECT_EQ(time_step_limits(springs, grains_of({{0, 0.001, {}}, {0, 0.003, {}}, {0, 0.004, {}}}), none).contact.pair,
            "soft (r = 0.001) - soft (r = 0.003)");
  // fixed grains never meet each other, and their mass is infinite
  Population bumps;
  bumps.add(0, false, 0.001, 0.001, 5000);
  const TimeStepReport smooth = time_step_limits(s, bumps, none);
  bumps.add(0, true, 0.0001, 0.0001, 1000);
  EXPECT_EQ(time_step_limits(s, bumps, none).rayleigh.pair, "soft (r = 0.001)");
  EXPECT_EQ(time_step_limits(s, bumps, none).packing.seconds, smooth.packing.seconds);
  Population lone = grains_of({{0, 0.001, {}}});
  lone.add(1, true, 0.1, 0.1, 50);
  EXPECT_EQ(time_step_limits(s, lone, none).packing.pair, "soft (r = 0.001) - fixed steel (r = 0.1)");
  // a wall's material meets the grains that there are
  s.domain.boundary[2][0] = Boundary::wall;
  s.domain.wall_material = 1;
  EXPECT_EQ(time_step_limits(s, grains_of({{0, 0.001, {}}}), none).packing.pair, "soft (r = 0.001) on wall steel");
}

TEST(TimeStep, FewGrainsCannotSurroundOne) {
  Scene s = linear_scene();
  const WallSet none;
  const double m = mass(1000, 0.001), k = 1e5;
  std::vector<std::tuple<int, double, Vec3>> list(1, {0, 0.001, {}});
  EXPECT_EQ(time_step_limits(s, grains_of(list), none).packing.seconds, k_never);  // nothing to touch
  for (const int n : {2, 3, 8, 20}) {
    list.assign(static_cast<std::size_t>(n), {0, 0.001, {}});
    // n grains that all touch each other swing with omega^2 = n k/m at most
    EXPECT_NEAR(time_step_limits(s, grains_of(list), none).packing.seconds * std::sqrt(std::min(n, 8) * k / m), 2, 1e-9)
        << n;
  }
  s.domain.boundary[2] = {Boundary::wall, Boundary::wall};
  list.resize(1);  // held between two plates: 2 k/m
  EXPECT_NEAR(time_step_limits(s, grains_of(list), none).packing.seconds * std::sqrt(2 * k / m), 2, 1e-9);
}

TEST(TimeStep, PrintedLimitsAreWithinTheLimit) {
  Scene s = linear_scene();
  for (double density = 1000; density < 1100; density += 0.7) {
    s.materials[0].density = density;
    const double limit = time_step_limits(s, 0.001, 0.001).packing.seconds, printed = std::stod(at_most(limit));
    EXPECT_LE(printed, limit) << density;
    EXPECT_GT(printed, 0.998 * limit) << density;
  }
}

WallSpec blade(Vec3 lower, Vec3 upper) {
  WallSpec w;
  w.name = "blade";
  w.shape = WallShape::box;
  w.lower = lower;
  w.upper = upper;
  return w;
}

double fastest(const Scene& s) { return WallSet(s, 0.001).fastest_point(0); }

TEST(TimeStep, FastestWallPointIsThatOfTheFarthestVertexOverTheRun) {
  Scene s = linear_scene();
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.domain.lower = {-2, -2, -2};
  s.domain.upper = {2, 2, 2};
  s.walls = {blade({0.1, -0.01, -0.2}, {0.3, 0.04, 0.2})};
  WallMotion& m = s.walls[0].motion;
  m.rotation_axis = {0, 0, 5};
  m.rotation_rate = -20;
  const double arm = std::hypot(0.3, 0.04);
  EXPECT_NEAR(fastest(s), 20 * arm, 1e-12);
  m.velocity = {3, 0, 4};  // 3 adds to the tip once per turn, 4 stands at right angles to it
  EXPECT_NEAR(fastest(s), std::hypot(20 * arm + 3, 4), 1e-12);
  m.velocity = {};
  m.amplitude = {0.001, 0, 0};
  m.frequency = 50;
  EXPECT_NEAR(fastest(s), 20 * arm + 2 * k_pi * 0.05, 1e-12);
  m.amplitude = {};
  m.rotation_origin = {-0.5, 0, 0};
  EXPECT_NEAR(fastest(s), 20 * std::hypot(0.8, 0.04), 1e-12);
  m.rotation_origin = {100, 0, 0};
  EXPECT_NEAR(fastest(s), 20 * std::hypot(99.9, 0.04), 1e-9);
  // what lies outside the domain touches nothing
  m.rotation_origin = {};
  s.walls[0].upper.x = 50;
  EXPECT_NEAR(fastest(s), 20 * std::hypot(2, 2), 0.1);
  s.walls[0].upper.x = 0.3;
  // schedules: what moves only while it is not there, or after the end, does not count
  m.rotation_origin = {};
  m.start = 1;
  m.end = 2;
  EXPECT_NEAR(fastest(s), 20 * arm, 1e-12);
  s.walls[0].appear = 2;
  EXPECT_EQ(fastest(s), 0);
  s.walls[0].appear = 0;
  s.walls[0].vanish = 1;
  EXPECT_EQ(fastest(s), 0);
  s.walls[0].vanish = k_never;
  s.steps = 1000;
  s.dt = 1e-3;
  EXPECT_EQ(fastest(s), 0);
  s.steps = 1001;
  EXPECT_NEAR(fastest(s), 20 * arm, 1e-12);
}

TEST(TimeStep, FastestPointOfRoundAndInfiniteWalls) {
  Scene s = linear_scene();
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.domain.lower = {-2, -2, -2};
  s.domain.upper = {2, 2, 2};
  s.walls.resize(1);
  WallSpec& w = s.walls[0];
  w.shape = WallShape::cylinder;
  w.point = {0, 0, -0.5};
  w.axis = {0, 0, 1};
  w.length = 1;
  w.radius = 0.2;
  w.motion.rotation_rate = 10;
  EXPECT_NEAR(fastest(s), 2, 1e-3);  // a drum about its own axis
  w.motion.rotation_axis = {1, 0, 0};
  EXPECT_NEAR(fastest(s), 10 * std::hypot(0.5, 0.2), 1e-2);  // a tumbling one
  w.shape = WallShape::cone;
  w.radius_end = 0.6;
  EXPECT_NEAR(fastest(s), 10 * std::hypot(0.5, 0.6), 1e-2);
  w.shape = WallShape::plane;  // as far as the domain's corner
  w.point = {};
  EXPECT_NEAR(fastest(s), 10 * std::hypot(2, 2), 0.1);
  w.motion.rotation_rate = 0;
  w.motion.amplitude = {0, 0, 0.1};
  w.motion.frequency = 3;
  w.motion.velocity = {0, 0, -1};
  EXPECT_NEAR(fastest(s), 1 + 0.6 * k_pi, 1e-12);
}

TEST(TimeStep, StepIsJudgedByTheFastestGrainOfFilesSourcesAndEvents) {
  Scene s = linear_scene();
  s.contact.model = ContactModel::hertz_mindlin;
  s.contact.friction = true;
  s.materials = {{"glass", 2500, 5e7, 0.25}};
  s.pairs.assign(1, {0.5, 0.8});
  const WallSet none;
  const auto closing = [&](const Population& p) { return time_step_limits(s, p, none).velocity; };
  EXPECT_NEAR(closing(grains_of({{0, 0.001, {3, 0, 4}}, {0, 0.001, {}}})), 5, 1e-12);
  EXPECT_NEAR(closing(grains_of({{0, 0.001, {10, 0, 0}}, {0, 0.001, {-10, 0, 0}}})), 20, 1e-12);  // head on
  Population spinning = grains_of({{0, 0.001, {}}, {0, 0.001, {}}});
  spinning.add_velocity({}, {}, 7);
  EXPECT_NEAR(closing(spinning), 7, 1e-12);
  Event e;
  e.action = Event::Action::set_velocity;
  e.time = 0.5;
  e.vector = {0, 6, 8};
  s.events = {e};
  EXPECT_NEAR(time_step_limits(s, 0.001, 0.001).velocity, 10, 1e-12);
  s.dt = 1e-6;
  s.steps = 400000;  // over before
  EXPECT_LT(time_step_limits(s, 0.001, 0.001).velocity, 1);
  s.steps = 0;
  e.action = Event::Action::gravity;
  e.vector = {0, -50, 0};
  s.events = {e};
  EXPECT_NEAR(time_step_limits(s, 0.001, 0.001).velocity, 10, 1e-12);  // a fall of 1 m
}

TEST(TimeStep, GrainsAndTurningWallsThatOutrunTheStepAreRefused) {
  Scene s = linear_scene();
  s.dt = 1e-5;
  s.contact.normal_stiffness = 10;
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.walls = {blade({0.1, 0, -0.2}, {0.3, 0.001, 0.2})};
  const auto verdict = [&](const Population& p) {
    try {
      return time_step_limits(s, p, WallSet(s, 0.001)).warning;
    } catch (const Error& e) {
      return std::string("refused: ") + e.what();
    }
  };
  const Population still = grains_of({{0, 0.001, {}}, {0, 0.001, {}}});
  EXPECT_EQ(verdict(still), "");
  s.walls[0].motion.rotation_rate = 50;  // 15 m/s: 0.15 radii
  EXPECT_CONTAINS(verdict(still), "wall 'blade' moves 0.15 of the smallest radius");
  s.walls[0].motion.rotation_rate = 350;
  EXPECT_CONTAINS(verdict(still), "refused: t.toml: wall 'blade' moves 1.05 of the smallest radius");
  s.walls.clear();
  Population shot = still;
  shot.movers.push_back({"particle 1", "g.csv:3", 105, 105, 0.001, 0.001});
  EXPECT_CONTAINS(verdict(shot), "refused: t.toml: particle 1 moves 1.05 of its radius in one step (g.csv:3; 105 m/s)");
  // a source of several sizes is refused where every grain is too fast, else warned of
  Population mixed = still;
  mixed.movers.push_back({"source 'feed'", "", 105, 105, 0.001, 0.002});
  EXPECT_CONTAINS(verdict(mixed), "source 'feed' moves by up to 1.05");
  EXPECT_EQ(verdict(mixed).find("refused"), std::string::npos);
}

TEST(TimeStep, StiffnessOfARowCountsDashpotsAndTangentialSprings) {
  Scene s = linear_scene();
  s.materials.resize(1);
  s.pairs.resize(1);
  s.dt = 1e-6;
  const TimeStepReport plain = time_step_limits(s, 0.001, 0.001);
  const double row = 12 * 1e5 / mass(1000, 0.001);
  EXPECT_NEAR(effective_stiffness(s, plain.ruler, row, 1e-6) / (row * 1e-12), 1, 1e-12);
  EXPECT_NEAR(largest_row(s, plain, 2) * 1e-12, 2, 1e-9);
  s.contact.friction = true;
  s.contact.tangential_stiffness = 1e5;  // turning grains: five times
  EXPECT_NEAR(effective_stiffness(s, time_step_limits(s, 0.001, 0.001).ruler, row, 1e-6) / (row * 1e-12), 5, 1e-9);
  s.contact.normal_damping = 2e4;
  const TimeStepReport damped = time_step_limits(s, 0.001, 0.001);
  const double step = step_for_row(s, damped, row, 6);
  EXPECT_NEAR(step / damped.packing.seconds, 1, 1e-9);  // twelve contacts: a full packing at its limit
}

}  // namespace
}  // namespace talus
