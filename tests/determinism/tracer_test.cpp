// Part "tracer": what one grain gains its partner loses; the values depend on the trajectory alone; a resume goes on to
// the bit; a scene without it has nothing of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/part_final.hpp"

namespace talus::determinism {
namespace {

constexpr std::int64_t k_run = 1500;  // with two sort epochs

/// The first source's grains carry 1, the others' 0.
Scene traced(Scene s, double rate) {
  s.tracer_rate = rate;
  for (std::size_t k = 0; k < s.sources.size(); ++k) s.sources[k].tracer = k == 0 ? 1 : 0;
  return s;
}
double usual_rate(const Scene& s) { return 0.004 / s.dt; }

std::vector<double> column_of(const Simulation& sim) {
  const Frame f = sim.frame();
  EXPECT_EQ(f.extra.size(), 1U);
  return f.extra.empty() ? std::vector<double>{} : f.extra[0].values;
}

TEST(Tracer, TotalIsConservedToRoundingWhileContactsMixAndGrainsComeAndGo) {
  for (Scene (*build)() : {hopper, hertz_drum}) {
    const Scene s = traced(build(), usual_rate(build()));
    Simulation sim(s, RunOptions{});
    const std::vector<double> before = column_of(sim);
    sim.run(k_run);
    EXPECT_LT(std::fabs(value_of(sim, "tracer.residual")), 1e-12 * static_cast<double>(sim.particles()));
    const std::vector<double> c = column_of(sim);
    const auto between = std::count_if(c.begin(), c.end(), [](double x) { return x > 0.01 && x < 0.99; });
    EXPECT_GT(between, 20) << s.title << ": contacts between grains of both kinds have mixed something";
    for (const double x : c) {
      EXPECT_GE(x, 0);
      EXPECT_LE(x, 1);
    }
    if (s.title == hopper().title) {
      EXPECT_GT(sim.counters().inserted, 0);
    }
  }
}

TEST(Tracer, PairExchangesAtTheStatedRate) {
  // two equal grains pressed together at rest: the difference decays as (1 - 2 rate dt)^n
  Scene s = hertz_drum();
  s.gravity = {};
  s.walls.clear();
  s.events.clear();
  s.groups.clear();
  const std::string table = temporary_file("pair.csv", "x,y,z,radius\n0,0,0,0.001\n0.00199,0,0,0.001\n");
  Source a;
  a.kind = Source::Kind::file;
  a.file = table;
  s.sources = {a};
  s.domain.lower = {-1, -1, -1};
  s.domain.upper = {1, 1, 1};
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.contact.friction = false;
  s.output.energies = false;
  s.viscous_damping = 0;
  s.tracer_rate = 0.01 / s.dt;
  s.sources[0].tracer = 1;
  Simulation sim(s, RunOptions{});
  World& w = EngineAccess::world(sim);
  for (const Columns::Entry& e : w.rows.columns.all())
    if (e.info.name == "tracer") reinterpret_cast<double*>(e.data())[0] = 0;
  sim.run(10);
  ASSERT_EQ(sim.counters().contacts, 1) << "the grains still touch";
  const std::vector<double> c = column_of(sim);
  EXPECT_NEAR(c[1] - c[0], std::pow(1 - 2 * 0.01, 10), 1e-14);
  EXPECT_NEAR(c[0] + c[1], 1, 1e-15);
}

TEST(Tracer, ValuesDependOnTheTrajectoryAlone) {
  for (Scene (*build)() : {hopper, hertz_drum}) {
    const Scene s = traced(build(), usual_rate(build()));
    const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
    Simulation first(plain.apply(s), plain.options());
    first.run(k_run);
    const Final wanted = final_of(first);
    expect_same_in_other_ways(s, k_run, wanted);
  }
}

TEST(Tracer, ResumeGoesOnToTheBit) {
  const Scene s = traced(hopper(), usual_rate(hopper()));
  expect_same_after_resume(s, k_run, {733});
}

TEST(Tracer, WithoutMixingOnlyTheMotionOfGrainsRaisesTheIndex) {
  Scene s = traced(hertz_drum(), 0);
  Simulation sim(s, RunOptions{});
  const double before = value_of(sim, "tracer.mixing_index");
  sim.run(k_steps);
  for (const double x : column_of(sim)) EXPECT_TRUE(x == 0 || x == 1);
  const double after = value_of(sim, "tracer.mixing_index");
  EXPECT_LT(before, 0.5) << "the sources are apart";
  EXPECT_GT(after, before);
}

TEST(Tracer, ChangesNoMotionAndIsLeftOutWhereTheSceneDoesNotAsk) {
  Scene s = hopper();
  Simulation without(s, RunOptions{}), with(traced(s, usual_rate(s)), RunOptions{});
  without.run(300);
  with.run(300);
  EXPECT_TRUE(without.part_values().empty());
  EXPECT_TRUE(without.frame().extra.empty());
  EXPECT_EQ(without.plan().graph.find("tracer"), std::string::npos);
  EXPECT_NE(with.plan().graph.find("wall_contact[c] -> tracer_mixing[c] -> integrate[c]"), std::string::npos);
  EXPECT_EQ(checkpoint_bytes(without).find("tracer"), std::string::npos);
  EXPECT_NE(checkpoint_bytes(with).find("tracer"), std::string::npos);
  for (const auto& a : without.plan().arrays) EXPECT_EQ(a.name.find("tracer"), std::string::npos);
  const Frame a = without.frame(), b = with.frame();
  ASSERT_EQ(a.id, b.id);
  for (std::size_t k = 0; k < a.x.size(); ++k) EXPECT_EQ(norm2(a.x[k] - b.x[k]), 0);
  EXPECT_NE(without.state_hash(), with.state_hash()) << "its values are state";
}

TEST(Tracer, RefusesAStepThatWouldLeaveTheRangeOfTheValues) {
  const Scene s = traced(hopper(), 1 / hopper().dt);
  EXPECT_THROW(Simulation(s, RunOptions{}), Error);
}

}  // namespace
}  // namespace talus::determinism
