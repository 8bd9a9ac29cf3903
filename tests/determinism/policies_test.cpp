// What each list policy promises beside the bits (exact_trajectory_test, exact_lists_test): which rebuild more often
// than which, what a uniform drift costs, what a fixed interval misses; and that automatic K moves without touching
// the trajectory.
#include <gtest/gtest.h>

#include <cstdio>

#include "core/base/error.hpp"
#include "core/io/checkpoint.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/lists/skin.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

/// Grains of 10 mm flying about in a box of 0.3 m, all with `drift` on top [m/s].
Scene crowd(const std::string& boundary, const Vec3& drift, const std::string& list) {
  char velocity[96];
  std::snprintf(velocity, sizeof velocity, "[%g, %g, %g]", drift.x, drift.y, drift.z);
  return parse_scene(R"(
title = "crowd"
seed = 5
[domain]
lower = [0, 0, 0]
upper = [0.3, 0.3, 0.3]
boundary = )" + boundary +
                         R"(
[time]
step = 1e-5
steps = 4000
[[material]]
name = "grain"
density = 2500
[contact]
normal_stiffness = 2e5
friction = 0.5
restitution = 0.9
[[source]]
kind = "random"
number = 600
velocity = )" + velocity +
                         R"(
velocity_jitter = 1
[source.region]
lower = [0.01, 0.01, 0.01]
upper = [0.29, 0.29, 0.29]
[source.size]
diameter = 0.01
[list]
verlet_k = 200
)" + list,
                     "crowd", ".");
}

struct Outcome {
  Counters counters;
  std::uint64_t hash = 0;
};

Outcome outcome(const Scene& scene, std::int64_t steps, bool audit = false) {
  RunOptions options;
  options.threads = 1;
  options.chunk = 128;
  options.audit = audit;
  Simulation sim(scene, options);
  sim.run(steps);
  return {sim.counters(), sim.state_hash()};
}

constexpr const char* k_periodic = "\"periodic\"";

// Sum of the two largest <= 2 x largest, and a displacement <= the travels that lead to it, so for one and the same
// skin two_largest rebuilds least and accumulated most.
TEST(Policies, TwoLargestRebuildsNoMoreAndAccumulatedNoLessThanUniform) {
  const auto rebuilds = [](ListPolicy policy) {
    Scene s = pile_on_mesh();  // it rocks: grains turn back before they have used their skins
    s.list.policy = policy;
    s.list.uniform_skin = 0.3;
    return outcome(s, 3000).counters.rebuilds_skin;
  };
  const std::int64_t two = rebuilds(ListPolicy::two_largest), one = rebuilds(ListPolicy::uniform),
                     sum = rebuilds(ListPolicy::accumulated);
  std::printf("two_largest %lld, uniform %lld, accumulated %lld rebuilds\n", static_cast<long long>(two),
              static_cast<long long>(one), static_cast<long long>(sum));
  EXPECT_GT(two, 10);
  EXPECT_LE(two, one);
  EXPECT_LE(one, sum);
  EXPECT_LT(two, sum) << "the three rules must differ";
}

// 100 m/s carry everything 0.1 diameters per step: skins from absolute speeds are full at every turn.
TEST(Policies, MeanSubtractedDoesNotPayForAUniformDrift) {
  const auto run = [](const char* policy, double drift) {
    return outcome(crowd(k_periodic, {drift, 0.3 * drift, 0}, std::string("policy = \"") + policy + "\"\n"), 2000)
        .counters;
  };
  const Counters rest = run("mean_subtracted", 0), moving = run("mean_subtracted", 100), local = run("local", 100);
  EXPECT_GT(rest.rebuilds_skin, 5);
  // not the same trajectory to the bit, so not the same count
  EXPECT_LE(static_cast<double>(moving.rebuilds_skin), 1.2 * static_cast<double>(rest.rebuilds_skin) + 2);
  EXPECT_LE(static_cast<double>(moving.pairs), 1.2 * static_cast<double>(rest.pairs));
  EXPECT_GE(local.rebuilds_skin, 5 * moving.rebuilds_skin);
}

// The frame runs past walls at rest: they need their own margin, and lists expire when it is used up.
TEST(Policies, MeanSubtractedHoldsWallContactsWhileTheCrowdFallsOnThem) {
  const Scene scene = crowd("\"wall\"", {0, 4, -20}, "policy = \"mean_subtracted\"\n");
  const Outcome o = outcome(scene, 1500, true);
  EXPECT_EQ(o.counters.missed_contacts, 0);
  EXPECT_GT(o.counters.wall_contacts, 0);
  EXPECT_EQ(o.hash, outcome(Variant{ListPolicy::always, 0, 1, 128, Isa::automatic}.apply(scene), 1500).hash);
}

/// The crowd in six layers that flow past each other at 0 ... 5 m/s.
Scene sheared_crowd(const std::string& sides, const std::string& list) {
  Scene s = crowd("[\"periodic\", \"periodic\", \"" + sides + "\"]", {}, list);
  const Source layer = s.sources[0];
  s.sources.clear();
  for (int k = 0; k < 6; ++k) {
    Source& f = s.sources.emplace_back(layer);
    f.number = 100;
    f.velocity = {static_cast<double>(k), 0, 0};
    f.velocity_jitter = 0.2;
    f.region.lower.z = 0.01 + 0.05 * k;
    f.region.upper.z = 0.04 + 0.05 * k;
  }
  return s;
}

// Lists last as long as what is left beside the profile allows, though a layer runs a diameter past the next one.
TEST(Policies, VelocityProfileDoesNotPayForAShearFlow) {
  const auto run = [](const std::string& policy) {
    return outcome(sheared_crowd("open", "policy = \"" + policy + "\"\n"), 3000, true);
  };
  const Outcome local = run("local"), mean = run("mean_subtracted"), profile = run("velocity_profile");
  std::printf("rebuilds: local %lld, mean_subtracted %lld, velocity_profile %lld\n",
              static_cast<long long>(local.counters.rebuilds_skin), static_cast<long long>(mean.counters.rebuilds_skin),
              static_cast<long long>(profile.counters.rebuilds_skin));
  EXPECT_EQ(profile.counters.missed_contacts, 0);
  EXPECT_EQ(profile.hash, local.hash);
  EXPECT_GT(profile.counters.contacts, 0);
  EXPECT_GT(local.counters.rebuilds_skin, 3 * profile.counters.rebuilds_skin);
  EXPECT_GT(mean.counters.rebuilds_skin, 2 * profile.counters.rebuilds_skin);
  EXPECT_GT(profile.counters.rebuilds_skin, 5) << "lists must expire, or nothing is tested";
  const Outcome closed = outcome(sheared_crowd("wall", "policy = \"velocity_profile\"\n"), 3000, true);
  EXPECT_EQ(closed.counters.missed_contacts, 0);
  EXPECT_EQ(closed.hash, outcome(sheared_crowd("wall", "policy = \"local\"\n"), 3000).hash);
}

// Walls at rest see the whole travel, the profile's part of it too; and a drift may run over several periods.
TEST(Policies, VelocityProfileHoldsWallContactsAndPeriodsThatItRunsThrough) {
  const Scene falls = crowd("\"wall\"", {0, 4, -20}, "policy = \"velocity_profile\"\n");
  const Outcome o = outcome(falls, 1500, true);
  EXPECT_EQ(o.counters.missed_contacts, 0);
  EXPECT_GT(o.counters.wall_contacts, 0);
  EXPECT_EQ(o.hash, outcome(Variant{ListPolicy::always, 0, 1, 128, Isa::automatic}.apply(falls), 1500).hash);
  Scene fast = crowd("[\"periodic\", \"periodic\", \"open\"]", {200, -150, 0}, "policy = \"velocity_profile\"\n");
  fast.list.verlet_k = 1000;  // 2 m in a list's life, 7 periods
  const Outcome far = outcome(fast, 2000, true);
  EXPECT_EQ(far.counters.missed_contacts, 0);
  EXPECT_LT(far.counters.rebuilds_skin, 60);
  EXPECT_EQ(far.hash, outcome(Variant{ListPolicy::always, 0, 1, 128, Isa::automatic}.apply(fast), 2000).hash);
}

// Inner lists are cut out of the outer one instead of a search, with walls and inserted grains as without.
TEST(Policies, OuterInnerSearchesLessOftenThanItMakesLists) {
  for (const char* sides : {"wall", "open"}) {
    const auto run = [&](const std::string& policy) {
      Scene s = sheared_crowd(sides, "policy = \"" + policy + "\"\nouter = 4\n");
      s.list.verlet_k = 20;
      return outcome(s, 3000, true);
    };
    const Outcome local = run("local"), cut = run("outer_inner");
    std::printf("%s: local %lld rebuilds, outer_inner %lld and %lld cuts\n", sides,
                static_cast<long long>(local.counters.rebuilds), static_cast<long long>(cut.counters.rebuilds),
                static_cast<long long>(cut.counters.cuts));
    EXPECT_EQ(cut.counters.missed_contacts, 0) << sides;
    EXPECT_EQ(cut.hash, local.hash) << sides;
    EXPECT_EQ(local.counters.cuts, 0) << sides;
    EXPECT_GT(cut.counters.cuts, cut.counters.rebuilds) << sides;
    EXPECT_LT(2 * cut.counters.rebuilds, local.counters.rebuilds) << sides;
  }
}

// Grains that shake to and fro are slow at every turn: a skin from the speed of the moment is short there, one from
// what was travelled is not. A crystal of touching grains, each between its neighbours. The memory has to live through
// sort epochs: with one every 30 steps a rule that forgets would be back at the speed of the moment in each list.
TEST(Policies, DisplacementHistoryKeepsTheSkinsOfWhatShakesAlsoThroughSortEpochs) {
  const auto rebuilds = [](const char* policy, std::int64_t sort_every) {
    Scene s = crowd(k_periodic, {}, std::string("policy = \"") + policy + "\"\nfloor = 0\nacceleration = false\n");
    s.list.verlet_k = 50;
    const double side = 0.10000001;  // ten diameters and a little, so that ten fit
    s.domain.upper = {side, side, side};
    Source& crystal = s.sources[0];
    crystal.kind = Source::Kind::lattice;
    crystal.spacing = 1;
    crystal.number = 1000;
    crystal.velocity_jitter = 0.02;
    crystal.region.lower = {0, 0, 0};
    crystal.region.upper = {side, side, side};
    s.sort_every = sort_every;
    return static_cast<double>(outcome(s, 1000).counters.rebuilds_skin);
  };
  const double speed = rebuilds("local", 2000), history = rebuilds("displacement_history", 2000);
  const double speed_epochs = rebuilds("local", 30), history_epochs = rebuilds("displacement_history", 30);
  std::printf("rebuilds: by speed %g, by history %g; with sort epochs %g and %g\n", speed, history, speed_epochs,
              history_epochs);
  EXPECT_GT(history, 10);
  EXPECT_LT(1.1 * history, speed);
  EXPECT_LT(1.5 * history_epochs, speed_epochs);
}

TEST(Policies, OnlyThoseThatNeedAnArrayHaveIt) {
  const auto bytes = [](const char* policy, const char* array) {
    const Simulation s(crowd(k_periodic, {}, std::string("policy = \"") + policy + "\"\n"), RunOptions{});
    for (const auto& a : s.plan().arrays)
      if (a.name == array) return a.in ? a.bytes_per_particle : 0.0;
    return -1.0;
  };
  EXPECT_EQ(bytes("local", "next skin"), 0);
  EXPECT_EQ(bytes("displacement_history", "next skin"), 8);
  EXPECT_EQ(bytes("local", "drift"), 0);
  EXPECT_EQ(bytes("mean_subtracted", "drift"), 0);
  EXPECT_EQ(bytes("velocity_profile", "drift"), 16);
  EXPECT_EQ(bytes("local", "outer") + bytes("local", "near"), 0);
  EXPECT_EQ(bytes("outer_inner", "outer") + bytes("outer_inner", "near"), 64);
}

TEST(Policies, FixedIntervalMissesContactsAndTheAuditCountsThem) {
  const auto missed = [](int interval) {
    char list[96];
    std::snprintf(list, sizeof list, "policy = \"fixed\"\nuniform_skin = 0.02\ninterval = %d\n", interval);
    const Outcome o = outcome(crowd(k_periodic, {}, list), 1000, true);
    EXPECT_EQ(o.counters.rebuilds, 1000 / interval) << "nothing but the interval may rebuild";
    return o.counters.missed_contacts;
  };
  EXPECT_EQ(missed(1), 0);
  EXPECT_GT(missed(40), 0);
  const Scene s = crowd(k_periodic, {}, "policy = \"fixed\"\ninterval = 9\n");
  EXPECT_NE(std::string(Simulation(s, RunOptions{}).plan().guarantee).find("NOT exact"), std::string::npos);
  EXPECT_THROW(crowd(k_periodic, {}, "policy = \"fixed\"\n"), Error) << "the interval is for the user to choose";
}

TEST(AutomaticK, ChangesKAndFloorButNoBit) {
  Scene scene = sheared_bed(), fixed = scene;
  fixed.list.automatic = false;
  RunOptions options;
  options.threads = 1;
  Simulation sim(scene, options);
  sim.run(1500);
  const auto& series = sim.list_series();
  ASSERT_GT(series.size(), 8U);
  EXPECT_NE(series.front().k, 200) << "the first K is guessed from the speeds of the scene";
  EXPECT_NE(series.back().k, series.front().k);
  EXPECT_NE(series.back().floor, series.front().floor);
  for (const ListRecord& r : series) {
    EXPECT_GE(r.k, 1);
    EXPECT_LE(r.k, 5000);
    EXPECT_GE(r.pairs, r.contacts);
  }
  Simulation plain(fixed, options);
  plain.run(1500);
  EXPECT_EQ(sim.state_hash(), plain.state_hash());
}

// The K that a run has chosen follows measured times: a checkpoint with it would differ from run to run.
TEST(AutomaticK, CheckpointBytesAreThoseOfAnyOtherRunAndAResumedRunFindsItsOwnK) {
  Scene scene = sheared_bed();
  RunOptions options;
  options.threads = 1;
  const auto checkpoint = [&](bool automatic, const char* name) {
    scene.list.automatic = automatic;
    Simulation sim(scene, options);
    sim.run(900);
    EXPECT_EQ(sim.list_series().back().k == scene.list.verlet_k, !automatic);
    const std::string path = temporary_file(name, "");
    CheckpointWriter out;
    sim.save(out);
    out.commit(path);
    return path;
  };
  const std::string by_auto = checkpoint(true, "auto.ckpt"), by_hand = checkpoint(false, "hand.ckpt");
  EXPECT_TRUE(read_bytes(by_auto) == read_bytes(by_hand));
  std::uint64_t hash[2];
  for (const bool automatic : {false, true}) {
    scene.list.automatic = automatic;
    Simulation resumed(scene, options, CheckpointReader(by_auto));
    resumed.run(200);
    hash[automatic ? 1 : 0] = resumed.state_hash();
    EXPECT_GT(resumed.counters().rebuilds, 2) << "lists were made again, so that K could be chosen";
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(AutomaticK, SeriesIsThinnedEvenly) {
  Scene scene = crowd(k_periodic, {}, "policy = \"always\"\n");
  RunOptions options;
  options.threads = 1;
  Simulation sim(scene, options);
  sim.run(1500);
  const auto& series = sim.list_series();
  ASSERT_LE(series.size(), 512U);
  ASSERT_GE(series.size(), 256U);
  for (std::size_t k = 1; k < series.size(); ++k) EXPECT_EQ(series[k].step - series[k - 1].step, 4) << k;
}

}  // namespace
}  // namespace talus::determinism
