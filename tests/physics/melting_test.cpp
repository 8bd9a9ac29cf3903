// Grains that melt and beams that heat them, against closed forms: a plateau as long as the latent heat asks, energy to
// rounding, what a grain takes of a Gaussian beam, shade, way points.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_R = 2e-5, k_rho = 7800, k_c = 500, k_latent = 2.5e5, k_melts = 1700;
const double k_mass = sphere_mass(k_rho, k_R);

/// Fixed grains at 300 K of a metal that melts at one temperature, heat steps of dt.
Scene metal(const std::vector<Vec3>& at, double dt, double solidus = k_melts) {
  Scene s = open_scene({-1e-3, -1e-3, -1e-3}, {1e-3, 1e-3, 1e-3}, dt);
  s.materials[0].density = k_rho;
  s.allow_unstable_step = s.allow_initial_overlap = true;
  linear_law(s, 1, 0);
  s.heat.on = true;
  s.heat.every = 1;
  s.heat.temperature = 300;
  MatterHeat m;
  m.capacity = Curve::constant(k_c);
  m.conductivity = Curve::constant(20);
  m.solidus = solidus;
  m.liquidus = k_melts;
  m.latent_heat = k_latent;
  s.heat.matter = {m};
  for (const Vec3& x : at) {
    Grain g;
    g.x = x;
    g.r = k_R;
    g.fixed = true;
    add_grains(s, {g});
    s.heat.sources.push_back({300, false});
  }
  return s;
}

Laser beam(double power, double radius, double absorptivity) {
  Laser l;
  l.power = TimeTable::constant(power);
  l.radius = radius;
  l.absorptivity = absorptivity;
  l.x = {0};
  l.y = {0};
  l.stop = k_never;
  return l;
}

double column(const Simulation& sim, const std::string& name, std::size_t i) {
  for (const ExtraColumn& c : sim.frame().extra)
    if (c.name == name) return c.values[i];
  ADD_FAILURE() << "no column " << name;
  return 0;
}

TEST(Melting, PlateauLastsAsLongAsTheLatentHeatAsks) {
  for (const double solidus : {k_melts, k_melts - 100}) {
    const double power = 0.1, to_solidus = k_mass * k_c * (solidus - 300) / power,
                 to_liquidus = to_solidus + k_mass * (k_c * (k_melts - solidus) + k_latent) / power;
    const double dt = to_solidus / 200;
    Scene s = metal({{0, 0, 0}}, dt, solidus);
    s.heat.lasers = {beam(power, k_R / 4, 1)};  // all of it meets the grain
    Simulation sim(s, options());
    while (static_cast<double>(sim.step()) * dt < 1.2 * to_liquidus) {
      sim.run(1);
      const double t = static_cast<double>(sim.step()) * dt;
      const double share = std::clamp((t - to_solidus) / (to_liquidus - to_solidus), 0.0, 1.0);
      const double T = t < to_solidus    ? 300 + power * t / (k_mass * k_c)
                       : t < to_liquidus ? solidus + share * (k_melts - solidus)
                                         : k_melts + power * (t - to_liquidus) / (k_mass * k_c);
      EXPECT_NEAR(column(sim, "temperature", 0), T, 1e-9 * T) << t;
      EXPECT_NEAR(column(sim, "molten", 0), share, 1e-9) << t;
    }
    EXPECT_NEAR(value_of(sim, "heat.molten"), k_mass, 1e-14 * k_mass);
    EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-12 * value_of(sim, "heat.total"));
  }
}

TEST(Melting, ATouchingPairSharesItsEnthalpyAndEndsAtTheMeltingPoint) {
  Scene s = metal({{0, 0, 0}, {1.98 * k_R, 0, 0}}, 2e-6);
  // the hot one holds what brings both to the melting point and melts a quarter of each
  const double excess = 2 * (k_c * (k_melts - 300) + 0.25 * k_latent);
  s.heat.sources[0].temperature = 300 + (excess - k_latent) / k_c;
  Simulation sim(s, options());
  const double before = value_of(sim, "heat.total");
  sim.run(20000);
  EXPECT_NEAR(value_of(sim, "heat.total"), before, 1e-12 * before);
  EXPECT_NEAR(column(sim, "temperature", 0), k_melts, 1e-6);
  EXPECT_NEAR(column(sim, "temperature", 1), k_melts, 1e-2);
  EXPECT_NEAR(value_of(sim, "heat.molten"), 2 * k_mass * 0.25, 2e-3 * k_mass);
}

TEST(Laser, AGrainTakesWhatAGaussianBeamShinesOnItsDiscAndShadesTheOneBelow) {
  const double w = 1.5 * k_R;
  double last = 1;
  for (const std::int64_t rays : {24, 96, 384}) {
    Scene s = metal({{0, 0, 0}, {0, 0, -3 * k_R}, {3 * k_R, 0, -3 * k_R}}, 1e-7);
    s.heat.lasers = {beam(2, w, 0.6)};
    s.heat.lasers[0].rays = rays;
    Simulation sim(s, options());
    sim.run(1);
    const double emitted = value_of(sim, "laser.emitted");
    EXPECT_NEAR(emitted, 2e-7, 1e-20);
    const double top = k_mass * k_c * (column(sim, "temperature", 0) - 300) / (0.6 * emitted);
    const double error = std::fabs(top - (1 - std::exp(-2 * k_R * k_R / (w * w))));
    figure("share of a Gaussian beam on a disc", error, std::to_string(rays) + " rays a side, error");
    EXPECT_LT(error, 0.5 / static_cast<double>(rays));
    EXPECT_LT(error, last + 1e-4);
    last = error;
    EXPECT_EQ(column(sim, "temperature", 1), 300) << "in the shade";
    EXPECT_GT(column(sim, "temperature", 2), 300) << "beside the upper one";
    EXPECT_NEAR(value_of(sim, "laser.absorbed") + value_of(sim, "laser.reflected") + value_of(sim, "laser.passed"),
                emitted, 1e-13 * emitted);
    EXPECT_NEAR(value_of(sim, "laser.absorbed"), 0.6 * (emitted - value_of(sim, "laser.passed")), 1e-13 * emitted);
    EXPECT_LT(std::fabs(value_of(sim, "heat.residual")), 1e-12 * value_of(sim, "heat.total"));
  }
}

TEST(Laser, FollowsItsWayPointsAndIsOffBeforeAndBehind) {
  // two legs at right angles; grains below their middles and far from both
  const double a = 4e-4, speed = 1, dt = 2e-6;
  Scene s = metal({{a / 2, 0, 0}, {a, a / 2, 0}, {0, a, 0}}, dt);
  Laser l = beam(0.5, k_R, 1);
  l.x = {0, a, a};
  l.y = {0, 0, a};
  l.speed = speed;
  l.start = 1e-4;
  s.heat.lasers = {l};
  Simulation sim(s, options());
  const auto run_to = [&](double t) { sim.run(static_cast<std::int64_t>(std::llround(t / dt)) - sim.step()); };
  run_to(l.start);
  EXPECT_EQ(value_of(sim, "laser.emitted"), 0);
  run_to(l.start + a / speed);
  const double first = column(sim, "temperature", 0);
  EXPECT_GT(first, 400);
  EXPECT_EQ(column(sim, "temperature", 1), 300);
  run_to(l.start + 3 * a / speed);
  EXPECT_EQ(column(sim, "temperature", 0), first);
  EXPECT_NEAR(column(sim, "temperature", 1), first, 1e-9 * first) << "the legs are alike";
  EXPECT_EQ(column(sim, "temperature", 2), 300);
  EXPECT_NEAR(value_of(sim, "laser.emitted"), 0.5 * 2 * a / speed, 1e-12);
  EXPECT_EQ(value_of(sim, "laser.power"), 0);
}

TEST(Laser, IsOnForItsTimeAndNotForWholeHeatSteps) {
  const double dt = 1e-6;
  Scene s = metal({{0, 0, 0}}, dt);
  s.heat.every = 10;
  Laser pulse = beam(2, k_R / 4, 1), late = pulse;
  pulse.start = 3.2e-6;  // within one heat step
  pulse.stop = 4.7e-6;
  late.start = 18e-6;  // over three
  late.stop = 44e-6;
  s.heat.lasers = {pulse, late};
  Simulation sim(s, options());
  sim.run(20);
  EXPECT_NEAR(value_of(sim, "laser.emitted"), 2 * (1.5e-6 + 2e-6), 1e-17);
  EXPECT_NEAR(value_of(sim, "laser.power"), 2 * 0.2, 1e-12) << "mean over the heat step";
  sim.run(80);
  EXPECT_NEAR(value_of(sim, "laser.emitted"), 2 * (1.5e-6 + 26e-6), 1e-16);
}

TEST(Laser, BeamsMeetGrainsThroughAnyNumberOfPeriods) {
  for (const double periods : {0.0, 1.0, -1.0, 3.0, -4.0}) {
    Scene s = metal({{0, 0, 0}}, 1e-7);
    s.domain.boundary[0] = {Boundary::periodic, Boundary::periodic};
    s.heat.lasers = {beam(2, k_R / 4, 1)};
    s.heat.lasers[0].x = {periods * (s.domain.upper.x - s.domain.lower.x)};
    Simulation sim(s, options());
    sim.run(1);
    EXPECT_NEAR(value_of(sim, "laser.absorbed"), 2e-7, 1e-18) << periods;
  }
}

TEST(Laser, ABeamBesideTheDomainIsSaid) {
  Scene s = metal({{0, 0, 0}}, 1e-6);
  s.steps = 100;
  s.heat.lasers = {beam(1, k_R, 1)};
  s.heat.lasers[0].x = {s.domain.upper.x + 3 * k_R};
  const Simulation sim(s, options());
  int said = 0;
  for (const Warning& w : sim.warnings()) said += w.text.find("beside the domain") != std::string::npos;
  EXPECT_EQ(said, 1);
}

TEST(Laser, HeatsNothingBeyondWhatAnyMatterBears) {
  for (const double power : {0.5, 1e6}) {  // [W]
    Scene s = metal({{0, 0, 0}}, 1e-6);
    s.heat.lasers = {beam(power, k_R, 1)};
    Simulation sim(s, options());
    std::string said;
    try {
      sim.run(200);
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::physics);
      said = e.what();
    }
    EXPECT_EQ(said.find("beyond all matter") != std::string::npos, power > 1) << said;
  }
}

TEST(Laser, ABeamThatIsNeverOnIsSaid) {
  for (const bool late : {false, true}) {
    Scene s = metal({{0, 0, 0}}, 1e-6);
    s.steps = 100;
    s.heat.lasers = {beam(1, k_R, 1)};
    s.heat.lasers[0].start = late ? 1e-4 : 9.9e-5;
    const Simulation sim(s, options());
    int said = 0;
    for (const Warning& w : sim.warnings()) said += w.text.find("switched on at 0.0001 s") != std::string::npos;
    EXPECT_EQ(said, late ? 1 : 0);
  }
}

}  // namespace
}  // namespace talus::physics
