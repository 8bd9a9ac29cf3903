// Grains that grow and shrink while they move: lists miss no contact under any policy, the trajectory has the same bits
// for every way of running, velocity and spin stay, grains without size leave.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/breathing.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

struct Case {
  Scene scene;
  double growth;
};
/// Gas: grains meet at speed and grow by half; drum: a bed that rests and slides.
std::vector<Case> cases() {
  std::vector<Case> all{{gas(), 0.5}, {hertz_drum(), 0.1}};
  for (Case& c : all) {
    c.scene.output.energies = false;
    c.scene.max_overlap = 1;
    c.scene.allow_unstable_step = true;
  }
  return all;
}
constexpr std::int64_t k_run = 900;  // with a sort epoch
constexpr std::int64_t k_audited = 100;

class ResizedLists : public ::testing::TestWithParam<ListPolicy> {};

TEST_P(ResizedLists, MissNoContactOfGrowingAndShrinkingGrains) {
  for (const Case& c : cases()) {
    const Variant v{GetParam(), 60, 1, 0, Isa::automatic};
    RunOptions o = v.options();
    o.audit = true;
    Simulation sim(v.apply(c.scene), o);
    breathe(sim, c.growth, k_audited);
    sim.run(k_audited);
    const Counters n = sim.counters();
    EXPECT_EQ(n.missed_contacts, 0) << c.scene.title << ' ' << v.text();
    EXPECT_GT(n.contacts, 0) << c.scene.title;
    if (GetParam() != ListPolicy::always) {
      EXPECT_LT(n.rebuilds, k_audited / 2) << c.scene.title << ' ' << v.text() << ": the lists have lasted";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, ResizedLists, ::testing::ValuesIn(exact_policies()),
                         [](const auto& p) { return std::string(enum_word(p.param)); });

TEST(Resize, TrajectoryHasTheSameBitsForEveryWayOfRunning) {
  for (const Case& c : cases()) {
    Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic};
    Simulation first(plain.apply(c.scene), plain.options());
    breathe(first, c.growth, k_run);
    first.run(k_run);
    const std::uint64_t wanted = first.state_hash();
    Simulation still(plain.apply(c.scene), plain.options());
    still.run(k_run);
    EXPECT_NE(still.state_hash(), wanted);
    for (const Variant& way :
         {Variant{ListPolicy::paper, 10, 2, 64, Isa::sse2}, Variant{ListPolicy::always, 0, 3, 257, Isa::scalar},
          Variant{ListPolicy::two_largest, 200, 2, 100, Isa::automatic},
          Variant{ListPolicy::accumulated, 200, 2, 100, Isa::automatic},
          Variant{ListPolicy::outer_inner, 100, 8, 64, Isa::automatic}}) {
      Simulation sim(way.apply(c.scene), way.options());
      breathe(sim, c.growth, k_run);
      sim.run(k_run);
      EXPECT_EQ(sim.state_hash(), wanted) << c.scene.title << ": " << way.text();
    }
  }
}

TEST(Resize, VelocityAndSpinStayAndGrainsWithoutSizeLeave) {
  Scene s = hertz_drum();
  s.gravity = {};
  s.walls.clear();
  s.events.clear();
  s.groups.clear();
  Source a;
  a.kind = Source::Kind::file;
  a.file = temporary_file("three.csv",
                          "x,y,z,radius,vx,vy,vz,wx,wy,wz\n0,0,0,0.001,0.1,0,0,3,0,1\n0.1,0,0,0.001,0,0.2,0,0,5,0\n"
                          "0.2,0,0,0.001,0,0,0.3,0,0,7\n");
  s.sources = {a};
  s.domain.lower = {-1, -1, -1};
  s.domain.upper = {1, 1, 1};
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.output.energies = false;
  s.viscous_damping = 0;
  Simulation sim(s, RunOptions{});
  breathe(sim, 0.5, 40, 1);
  sim.run(40);
  const Frame f = sim.frame();
  ASSERT_EQ(f.id, (std::vector<ParticleId>{0, 2})) << "the second has left";
  EXPECT_EQ(sim.counters().removed, 1);
  EXPECT_NEAR(f.r[0], 0.0015, 1e-15);
  EXPECT_EQ(f.r[1], 0.001);
  EXPECT_EQ(f.v[0].x, 0.1);
  EXPECT_NEAR(f.w[0].x, 3, 1e-13);
  EXPECT_NEAR(f.w[0].z, 1, 1e-13);
  const World& w = EngineAccess::world(sim);
  const double density = s.materials[0].density;
  EXPECT_NEAR(mass_of(w.rules, w.rows, 0) / (density * 4.0 / 3 * M_PI * 0.0015 * 0.0015 * 0.0015), 1, 1e-12);
}

TEST(Resize, AGrainThatIsUsedUpInTheStepInWhichItLeavesIsRemovedOnce) {
  Scene s = hertz_drum();
  s.gravity = {};
  s.walls.clear();
  s.events.clear();
  s.groups.clear();
  Source a;
  a.kind = Source::Kind::file;
  // the first leaves through the upper side in step 20, the step in which the part takes its size away
  a.file = temporary_file("leaver.csv", fmt::format("x,y,z,radius,vx,vy,vz,wx,wy,wz\n{:.17g},0,0,0.001,0.1,0,0,0,0,0\n"
                                                    "0,0,0,0.001,0,0,0,0,0,0\n",
                                                    1 - 20.5 * 0.1 * s.dt));
  s.sources = {a};
  s.domain.lower = {-1, -1, -1};
  s.domain.upper = {1, 1, 1};
  for (auto& axis : s.domain.boundary) axis = {Boundary::open, Boundary::open};
  s.output.energies = false;
  s.viscous_damping = 0;
  Simulation sim(s, RunOptions{});
  breathe(sim, 0.5, 40, 0);
  sim.run(40);
  EXPECT_EQ(sim.counters().removed, 1);
  EXPECT_EQ(sim.particles(), 1);
}

TEST(Resize, WithoutSuchAPartThereIsNoNode) {
  const Simulation sim(hopper(), RunOptions{});
  EXPECT_EQ(sim.plan().graph.find("resize"), std::string::npos);
}

}  // namespace
}  // namespace talus::determinism
