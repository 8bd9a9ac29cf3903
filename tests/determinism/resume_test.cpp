// Stop and resume: a run resumed under another K, policy, thread count, chunk size and instruction set ends with the
// hash and the checkpoint bytes of the uninterrupted run (I6); a checkpoint's bytes depend on the trajectory alone.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

/// Odd steps, none a sort epoch; in the hopper they lie before, within (step 325 to 724) and after the gate's motion
/// and between batches of the stream.
constexpr std::int64_t k_stops[] = {1, 333, 701, 1399, 1777};

const Variant k_ways[] = {
    {ListPolicy::local, 200, 1, 64, Isa::automatic}, {ListPolicy::paper, 50, 2, 257, Isa::sse2},
    {ListPolicy::uniform, 1000, 3, 0, Isa::scalar},  {ListPolicy::always, 0, 1, 64, Isa::automatic},
    {ListPolicy::local, 5000, 8, 100, Isa::sse2},    {ListPolicy::paper, 1, 1, 0, Isa::automatic}};

class Resume : public testing::TestWithParam<NamedScene> {};

TEST_P(Resume, EndsWithHashAndBytesOfTheUninterruptedRunUnderAnyOtherWay) {
  const Scene scene = GetParam().build();
  const Variant plain{ListPolicy::local, 200, 1, 64, Isa::automatic};
  std::uint64_t hash = 0;
  std::string bytes;
  {
    Simulation sim(plain.apply(scene), plain.options());
    sim.run(k_steps);
    hash = sim.state_hash();
    bytes = checkpoint_bytes(sim);
  }
  // A chain: each leg of the run goes on from the file of the last one, in another way.
  const std::string path = temporary_file("resume.checkpoint");
  std::int64_t at = 0;
  bool between_rebuilds = false;
  for (std::size_t leg = 0; leg <= std::size(k_stops); ++leg) {
    const Variant& way = k_ways[leg % std::size(k_ways)];
    std::unique_ptr<Simulation> sim;
    if (leg == 0) {
      sim = std::make_unique<Simulation>(way.apply(scene), way.options());
    } else {
      const CheckpointReader in(path);
      sim = std::make_unique<Simulation>(way.apply(scene), way.options(), in);
    }
    ASSERT_EQ(sim->step(), at);
    const std::int64_t to = leg < std::size(k_stops) ? k_stops[leg] : k_steps;
    sim->run(to - at);
    at = to;
    const Counters c = sim->counters();
    // the last list was built before the last step: the stop falls between two rebuilds
    between_rebuilds = between_rebuilds || (!c.interval_steps.empty() && c.interval_steps.back() < at - 1);
    if (at == k_steps) {
      EXPECT_EQ(sim->state_hash(), hash);
      EXPECT_TRUE(checkpoint_bytes(*sim) == bytes) << "final checkpoints differ";
    } else {
      CheckpointWriter out;
      sim->save(out);
      out.commit(path);
    }
  }
  EXPECT_TRUE(between_rebuilds);
}

TEST_P(Resume, OneStopAtAnyOddStepChangesNothing) {
  const Scene scene = GetParam().build();
  const Variant first{ListPolicy::local, 200, 1, 257, Isa::automatic},
      second{ListPolicy::paper, 200, 2, 64, Isa::automatic};
  constexpr std::int64_t end = 900;
  Simulation through(first.apply(scene), first.options());
  through.run(end);
  const std::uint64_t hash = through.state_hash();
  const std::string bytes = checkpoint_bytes(through);
  for (const std::int64_t stop : {3, 57, 251, 485, 699, 701, 899}) {
    const std::string path = temporary_file("one_stop.checkpoint");
    Simulation before(first.apply(scene), first.options());
    before.run(stop);
    CheckpointWriter out;
    before.save(out);
    out.commit(path);
    const CheckpointReader in(path);
    Simulation after(second.apply(scene), second.options(), in);
    EXPECT_EQ(after.state_hash(), before.state_hash()) << "loading changed the state of step " << stop;
    EXPECT_TRUE(checkpoint_bytes(after) == read_bytes(path)) << "saving again changed the bytes of step " << stop;
    after.run(end - stop);
    EXPECT_EQ(after.state_hash(), hash) << "stopped at " << stop;
    EXPECT_TRUE(checkpoint_bytes(after) == bytes) << "stopped at " << stop;
  }
}

TEST_P(Resume, CheckpointBytesDependOnTheTrajectoryAlone) {
  const Scene scene = GetParam().build();
  for (const std::int64_t step : {1, 777}) {
    std::string bytes;
    for (const Variant& way : k_ways) {
      Simulation sim(way.apply(scene), way.options());
      sim.run(step);
      const std::string mine = checkpoint_bytes(sim);
      if (bytes.empty()) bytes = mine;
      EXPECT_TRUE(mine == bytes) << "step " << step << ", " << way.text();
    }
  }
}

// Steps in one call or in many, with every kind of observation in between: looking does not touch the trajectory.
TEST_P(Resume, ObservingAndCuttingTheRunIntoCallsChangesNothing) {
  const Scene scene = Variant{ListPolicy::local, 200, 1, 64, Isa::automatic}.apply(GetParam().build());
  RunOptions options;
  options.threads = 2;
  options.chunk = 64;
  Simulation through(scene, options), watched(scene, options);
  through.run(1000);
  std::int64_t at = 0;
  for (const std::int64_t to : {1, 2, 99, 100, 350, 699, 700, 701, 1000}) {
    watched.run(to - at);
    at = to;
    const Frame f = watched.frame({true, true, true, true, true});
    EXPECT_EQ(static_cast<std::int64_t>(f.id.size()), watched.particles());
    watched.energies();
    watched.plan();
    watched.state_hash();
    checkpoint_bytes(watched);
  }
  EXPECT_EQ(watched.state_hash(), through.state_hash());
  EXPECT_TRUE(checkpoint_bytes(watched) == checkpoint_bytes(through));
}

INSTANTIATE_TEST_SUITE_P(Scenes, Resume, testing::ValuesIn(scenes()),
                         [](const testing::TestParamInfo<NamedScene>& i) { return std::string(i.param.name); });

// The hopper's stops lie where they are said to: gate in motion, grains still to come, some gone.
TEST(ResumeScene, HopperStopsWithMovingGateAndInserter) {
  const Scene s = hopper();
  Simulation sim(s, RunOptions{});
  sim.run(k_stops[1]);
  EXPECT_GT(sim.time(), s.walls[2].motion.start);
  const std::int64_t inserted = sim.counters().inserted;
  EXPECT_GT(inserted, 0);
  sim.run(k_stops[2] - k_stops[1]);
  EXPECT_LT(sim.time(), s.walls[2].motion.end);
  EXPECT_GT(sim.counters().inserted, inserted);
  sim.run(k_stops[4] - k_stops[2]);
  EXPECT_GT(sim.counters().removed, 0);
}

}  // namespace
}  // namespace talus::determinism
