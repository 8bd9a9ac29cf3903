// Part "tracer": what one grain gains its partner loses; the values depend on the trajectory alone; a resume goes on to
// the bit; a scene without it has nothing of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/part_final.hpp"
#include "tests/determinism/shaped_bed.hpp"

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

/// Eggs begin with 1, rods and balls with 0; a stream brings more, others leave through an open side.
Scene traced_shapes() {
  const Scene s = parse_scene(bed_text("", "", k_law), "traced shapes", "", {});
  return traced(s, usual_rate(s));
}

TEST(TracerOfBodies, TotalIsConservedToRoundingAndABodyHasOneValue) {
  Simulation sim(traced_shapes(), RunOptions{});
  sim.run(k_run);
  EXPECT_GT(sim.counters().inserted, 20);
  EXPECT_LT(std::fabs(value_of(sim, "tracer.residual")), 1e-12 * static_cast<double>(sim.particles()));
  const Frame f = sim.frame();
  ASSERT_EQ(f.extra.size(), 2U);
  int between = 0;
  double total = 0;
  for (std::size_t i = 0; i < f.id.size(); ++i) {
    const auto first = static_cast<std::size_t>(
        std::lower_bound(f.id.begin(), f.id.end(), static_cast<ParticleId>(f.extra[0].values[i])) - f.id.begin());
    const double c = f.extra[1].values[i];
    EXPECT_EQ(c, f.extra[1].values[first]) << "of all its spheres";
    EXPECT_GE(c, 0);
    EXPECT_LE(c, 1);
    if (first == i) total += c, between += c > 0.001 && c < 0.999 ? 1 : 0;
  }
  EXPECT_GT(between, 20);
  EXPECT_NEAR(total, value_of(sim, "tracer.total"), 1e-12 * total);
}

TEST(TracerOfBodies, DependsOnTheTrajectoryAlone) {
  const Scene s = traced_shapes();
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
  Simulation first(plain.apply(s), plain.options());
  first.run(k_run);
  expect_same_in_other_ways(s, k_run, final_of(first));
}

TEST(TracerOfBodies, ResumeGoesOnToTheBit) { expect_same_after_resume(traced_shapes(), k_run, {10, 733}); }

/// Two rods side by side touch with both spheres, two ellipsoids at one point; spheres that hold them mix nothing.
TEST(TracerOfBodies, PairsExchangeAtTheRateOfTheirContacts) {
  struct Case {
    const char* shape;
    double x;
    int contacts;
  };
  for (const Case& c : {Case{"rod", 0.00999, 2}, {"egg", 0.00999, 1}, {"egg", 0.0101, 0}}) {
    const std::string first = temporary_file("first.csv", "x,y,z,shape,scale\n0,0,0," + std::string(c.shape) + ",1\n"),
                      second =
                          temporary_file("second.csv", fmt::format("x,y,z,shape,scale\n{},0,0,{},1\n", c.x, c.shape));
    Scene s = parse_scene(
        "gravity = [0, 0, 0]\n[domain]\nlower = [-1, -1, -1]\nupper = [1, 1, 1]\nboundary = \"open\"\n"
        "[time]\nstep = 1e-6\nduration = 1\n[[material]]\nname = \"m\"\ndensity = 2000\n[contact]\n"
        "normal_stiffness = 100\nrestitution = 1\nfriction = 0\n[[shape]]\nname = \"rod\"\n"
        "spheres = [0, 0, -0.005, 0.005, 0, 0, 0.005, 0.005]\n[[shape]]\nname = \"egg\"\nkind = \"superquadric\"\n"
        "semi_axes = [0.005, 0.006, 0.01]\n[[source]]\nkind = \"file\"\nfile = \"" +
            first + "\"\n[[source]]\nkind = \"file\"\nfile = \"" + second + "\"\n",
        "two", "", {});
    s = traced(s, 0.01 / s.dt);
    Simulation sim(s, RunOptions{});
    sim.run(10);
    const Frame f = sim.frame();
    const std::vector<double>& value = f.extra[1].values;
    EXPECT_NEAR(value.front() - value.back(), std::pow(1 - 2 * 0.01 * c.contacts, 10), 1e-14) << c.shape << c.x;
    EXPECT_NEAR(value.front() + value.back(), 1, 1e-15);
  }
}

}  // namespace
}  // namespace talus::determinism
