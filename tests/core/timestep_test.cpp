// Claims about time step limits: closed forms, minimum over all pairs, refusal and warning.
#include "core/timestep.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"

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
  s.dt = 1e-9;
  return s;
}

double mass(double density, double r) { return density * 4.0 / 3.0 * k_pi * r * r * r; }

TEST(TimeStep, LinearLimitsFollowTheLightestPair) {
  const TimeStepReport t = time_step_limits(linear_scene(), 0.001, 0.002);
  const double m = mass(1000, 0.001) / 2;
  EXPECT_NEAR(t.contact.seconds / (k_pi * std::sqrt(m / 1e5)), 1, 1e-12);
  EXPECT_NEAR(t.isolated_pair.seconds / (2 * std::sqrt(m / 1e5)), 1, 1e-12);
  EXPECT_NEAR(t.packing.seconds / t.isolated_pair.seconds, 0.4, 1e-12);
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
  EXPECT_LT(t.packing.seconds, 0.4 * t.isolated_pair.seconds);
  // The same damping stated by restitution gives the same limits.
  Scene e = linear_scene();
  e.contact.by_restitution = true;
  for (PairCoefficients& k : e.pairs) k.restitution = std::exp(-0.5 * rate * t.contact.seconds);
  EXPECT_NEAR(time_step_limits(e, 0.001, 0.001).contact.seconds / t.contact.seconds, 1, 1e-12);
  EXPECT_NEAR(time_step_limits(e, 0.001, 0.001).packing.seconds / t.packing.seconds, 1, 1e-12);
}

TEST(TimeStep, StiffTangentialSpringsLowerThePackingLimit) {
  Scene s = linear_scene();
  s.contact.friction = true;
  s.contact.tangential_stiffness = 2.0 / 7.0 * 1e5;
  EXPECT_NEAR(
      time_step_limits(s, 0.001, 0.001).packing.seconds / time_step_limits(s, 0.001, 0.001).isolated_pair.seconds, 0.4,
      1e-12);
  s.contact.tangential_stiffness = 1e5;
  const double stiff = time_step_limits(s, 0.001, 0.001).packing.seconds;
  EXPECT_LT(stiff, 0.4 * time_step_limits(s, 0.001, 0.001).isolated_pair.seconds * 0.8);
  s.contact.friction = false;  // no tangential force, no such mode
  EXPECT_GT(time_step_limits(s, 0.001, 0.001).packing.seconds, stiff);
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
  EXPECT_NEAR(time_step_limits(s, 0.001, 0.001).velocity, std::sqrt(9.81 * 4), 1e-12);
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

}  // namespace
}  // namespace talus
