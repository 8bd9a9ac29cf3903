// What `talus check` makes of a measured cost: particles that come later, grains that still fall, outputs.
#include <gtest/gtest.h>

#include <cmath>

#include "cases/program/cli_check_time.hpp"

namespace talus::cli {
namespace {

/// 2 s of 20,000 steps in a box of 1 m; no outputs.
Scene two_seconds() {
  Scene s;
  s.dt = 1e-4;
  s.steps = 20000;
  s.materials = {Material{}};
  s.output.particles_every = s.output.csv_every = 0;
  return s;
}

Cost measured(std::int64_t last, double spent) {
  Cost c;
  c.last = last;
  c.spent = spent;
  c.per_particle_step = 1e-8;
  c.dense = 3e-8;
  return c;
}

TEST(CheckTime, ParticlesThatComeLaterCountForTheTimeThatTheyAreThere) {
  Scene s = two_seconds();
  Source stream;
  stream.kind = Source::Kind::stream;
  stream.number = 500;
  stream.number_rate = 1000;  // all are there after 0.5 s
  stream.size.diameter = 0.01;
  s.sources = {stream};
  EXPECT_DOUBLE_EQ(arrivals_of(s).most, 500);
  EXPECT_DOUBLE_EQ(arrivals_of(s).mean, 500 * 1.75 / 2);
  s.sources[0].number = 0;  // goes on to the end
  EXPECT_DOUBLE_EQ(arrivals_of(s).most, 2000);
  EXPECT_DOUBLE_EQ(arrivals_of(s).mean, 1000);
  s.sources[0] = stream;
  s.sources[0].kind = Source::Kind::lattice;  // at once, half way
  s.sources[0].number_rate = 0;
  s.sources[0].start = 1;
  EXPECT_DOUBLE_EQ(arrivals_of(s).mean, 250);
  s.sources[0].start = 3;
  EXPECT_EQ(arrivals_of(s).most, 0) << "after the end";
  s.sources[0].start = 0;
  EXPECT_EQ(arrivals_of(s).most, 0) << "there at step 0";
}

TEST(CheckTime, WhatHasComeBeforeIsNotCountedAgain) {
  Scene s = two_seconds();
  Source stream;
  stream.kind = Source::Kind::stream;
  stream.number = 500;
  stream.number_rate = 500;  // all are there after 1 s
  stream.size.diameter = 0.01;
  s.sources = {stream};
  EXPECT_DOUBLE_EQ(arrivals_of(s, 0.5).mean, 250 * (1.5 - 0.25) / 1.5) << "half of them are there by then";
  EXPECT_DOUBLE_EQ(arrivals_of(s, 1.5).mean, 0);
  EXPECT_DOUBLE_EQ(arrivals_of(s, 2).mean, 0) << "at the end";
  EXPECT_DOUBLE_EQ(arrivals_of(s, 1.5).most, 500) << "in the whole run";
  const RunTime t = predict(s, measured(15000, 1), 500, arrivals_of(s, 1.5));
  EXPECT_DOUBLE_EQ(t.seconds, 1 + 5000 * 500 * 1e-8);
}

TEST(CheckTime, WhatWasRunIsNotPredicted) {
  const Scene s = two_seconds();
  EXPECT_DOUBLE_EQ(predict(s, measured(s.steps, 3.25), 1000, {}).seconds, 3.25);
  EXPECT_DOUBLE_EQ(predict(s, measured(s.steps, 3.25), 1000, {500, 250}).seconds, 3.25);
}

TEST(CheckTime, WithoutGravityTheMeasuredCostGoesOn) {
  const Scene s = two_seconds();
  const RunTime t = predict(s, measured(5000, 1), 1000, {});
  EXPECT_DOUBLE_EQ(t.seconds, 1 + 15000 * 1000 * 1e-8);
  EXPECT_EQ(t.loose, 1);
}

TEST(CheckTime, UnderGravityGrainsFallForAWhileAndThenLieInABed) {
  Scene s = two_seconds();
  s.gravity = {0, 0, -9.81};
  const RunTime t = predict(s, measured(0, 0), 1000, {});
  const double fall = std::sqrt(2 / 9.81);  // through the domain [s]
  EXPECT_NEAR(t.loose, fall / 2, 1e-12);
  EXPECT_NEAR(t.seconds, 1000 * (1e-8 * fall + 3e-8 * (2 - fall)) / s.dt, 1e-9);
  EXPECT_EQ(predict(s, measured(10000, 1), 1000, {}).loose, 0) << "they lie by then";
  s.steps = 1000;
  EXPECT_EQ(predict(s, measured(0, 0), 1000, {}).loose, 1) << "the run ends before";
}

TEST(CheckTime, OutputsAreCounted) {
  Scene s = two_seconds();
  s.output.particles_every = 0.1;
  s.output.csv_every = 0.5;
  Cost c = measured(s.steps, 1);
  c.frame = 0.01;
  c.row = 0.1;
  EXPECT_NEAR(predict(s, c, 1000, {}).outputs, 21 * 0.01 + 5 * 0.1, 1e-12);
  EXPECT_NEAR(predict(s, c, 1000, {}).seconds, 1 + 21 * 0.01 + 5 * 0.1, 1e-12);
}

}  // namespace
}  // namespace talus::cli
