// The trajectory is a function of the scene alone. The scenes run under a cover of all pairs of {policy, K, threads,
// chunk, isa}: of its combinations each scene takes every second one, its neighbour in the table the others, so that
// each is run by four scenes or five. TALUS_FULL=1 runs the full product of every scene and prints "N combinations, 1
// hash". The reference is the plainest way: list rebuilt in every step, one thread, one chunk, scalar kernels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

const Variant k_reference{ListPolicy::always, 0, 1, 0, Isa::scalar};

std::uint64_t hash_after(const Scene& scene, const Variant& variant, std::int64_t steps) {
  Simulation sim(variant.apply(scene), variant.options());
  sim.run(steps);
  return sim.state_hash();
}

class Trajectory : public testing::TestWithParam<NamedScene> {};

std::size_t number_of(const NamedScene& scene) {
  const std::vector<NamedScene>& all = scenes();
  const auto same = [&](const NamedScene& s) { return std::string(s.name) == scene.name; };
  return static_cast<std::size_t>(std::find_if(all.begin(), all.end(), same) - all.begin());
}

TEST_P(Trajectory, SameBitsForEveryPairOfPolicyKThreadsChunkAndIsa) {
  const Scene scene = GetParam().build();
  const Levels counts = level_counts();
  const std::vector<Levels> rows = full_requested() ? full_product(counts) : pairwise_cover(counts);
  ASSERT_EQ(uncovered_pairs(counts, rows), 0);
  std::map<std::uint64_t, int> seen;
  const std::uint64_t reference = hash_after(scene, k_reference, k_steps);
  seen[reference] = 1;
  int runs = 1;
  const std::size_t every = full_requested() ? 1 : 2;
  for (std::size_t k = number_of(GetParam()) % every; k < rows.size(); k += every) {
    const Variant v = variant_of(rows[k]);
    const std::uint64_t hash = hash_after(scene, v, k_steps);
    ++seen[hash];
    ++runs;
    EXPECT_EQ(hash, reference) << v.text();
  }
  std::printf("%s: %d combinations, %zu %s\n", GetParam().name, runs, seen.size(),
              seen.size() == 1 ? "hash" : "hashes");
  std::fflush(stdout);
}

// The comparison above means something only if lists are reused and expire, storage is permuted, and contacts cross
// chunk borders while the trajectories run.
TEST_P(Trajectory, RunsAcrossRebuildsSortEpochsAndChunkBorders) {
  const Scene scene = Variant{ListPolicy::local, 200, 1, 64, Isa::automatic}.apply(GetParam().build());
  RunOptions options;
  options.threads = 1;
  options.chunk = 64;
  Simulation sim(scene, options);
  double border = 0;
  std::int64_t contacts = 0, wall_contacts = 0, samples = 0;
  int fewest_chunks = 1 << 30;
  for (std::int64_t at = 0; at < k_steps; at += 100, ++samples) {
    sim.run(100);
    const Counters c = sim.counters();
    border += c.border_contact_share * static_cast<double>(c.contacts);
    contacts += c.contacts;
    wall_contacts += c.wall_contacts;
    fewest_chunks = std::min(fewest_chunks, sim.plan().chunks);
  }
  const Counters c = sim.counters();
  EXPECT_GE(c.rebuilds_skin, 2);
  EXPECT_GE(c.sort_epochs, 3) << "two besides the one of step 0";
  EXPECT_LT(c.rebuilds, k_steps / 2) << "lists must be reused";
  EXPECT_GE(fewest_chunks, 8);
  EXPECT_GE(contacts, 20 * samples) << "too few contacts to tell anything";
  EXPECT_GE(border, 0.05 * static_cast<double>(contacts));
  if (!scene.walls.empty()) {
    EXPECT_GE(wall_contacts, 5 * samples);
  }
  std::printf(
      "%s: N=%lld, %lld skin and %lld forced rebuilds, %lld sort epochs, %d chunks, %.0f contacts/sample, %.0f %% "
      "across borders, "
      "%.0f wall contacts/sample, %lld inserted, %lld removed\n",
      GetParam().name, static_cast<long long>(sim.particles()), static_cast<long long>(c.rebuilds_skin),
      static_cast<long long>(c.rebuilds_forced), static_cast<long long>(c.sort_epochs), fewest_chunks,
      static_cast<double>(contacts) / static_cast<double>(samples), 100 * border / static_cast<double>(contacts),
      static_cast<double>(wall_contacts) / static_cast<double>(samples), static_cast<long long>(c.inserted),
      static_cast<long long>(c.removed));
}

// Floor, acceleration term, cap and cell size are list settings: they may not change a bit either.
TEST_P(Trajectory, SameBitsForEverySkinTermAndCellSize) {
  const Scene plain = GetParam().build();
  const std::uint64_t reference = hash_after(plain, k_reference, k_steps);
  for (int bits = 0; bits < 8; ++bits) {
    Scene s = plain;
    s.list.floor_on = (bits & 1) != 0;
    s.list.acceleration_on = (bits & 2) != 0;
    s.list.cap_on = (bits & 4) != 0;
    s.list.cell_factor = bits % 3 == 0 ? 0 : 1 + 0.25 * bits;
    const Variant v{ListPolicy::local, 20, 1 + bits % 2, 64, Isa::automatic};
    EXPECT_EQ(hash_after(s, v, k_steps), reference) << "bits " << bits;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Trajectory, testing::ValuesIn(scenes()),
                         [](const testing::TestParamInfo<NamedScene>& i) { return std::string(i.param.name); });

TEST(TrajectoryScene, HopperInsertsRemovesAndMovesItsGate) {
  Simulation sim(hopper(), RunOptions{});
  sim.run(k_steps);
  EXPECT_GE(sim.counters().inserted, 50);
  EXPECT_GE(sim.counters().removed, 10);
}

// A hash that forgets part of the state would make every comparison above empty.
TEST(TrajectoryHash, SeesOneBitOfVelocityAndOfAnInitialPosition) {
  const Scene base = sheared_bed();
  const Variant v{ListPolicy::local, 200, 1, 0, Isa::automatic};
  const std::uint64_t reference = hash_after(base, v, 300);
  Scene faster = base;
  faster.events[1].vector.x = faster.events[1].vector.x * (1 + 0x1p-52);
  EXPECT_NE(hash_after(faster, v, 300), reference);
  Scene seeded = base;
  seeded.seed = base.seed + 1;
  EXPECT_NE(hash_after(seeded, v, 300), reference);
  EXPECT_NE(hash_after(base, v, 299), reference);
}

}  // namespace
}  // namespace talus::determinism
