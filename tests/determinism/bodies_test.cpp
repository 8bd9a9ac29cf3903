// Bodies of several spheres: complete lists, the same bits for every way of running, exact resumes; a scene without
// them has nothing of them.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "core/base/error.hpp"
#include "core/base/rng.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/random_scenes.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

constexpr const char* k_shapes = R"(
[[shape]]
name = "rod"
spheres = [0, 0, -0.0015, 0.001, 0, 0, 0, 0.001, 0, 0, 0.0015, 0.001]
[[shape]]
name = "tee"
spheres = [0, 0, 0, 0.001, 0.0015, 0, 0, 0.0008, -0.0015, 0, 0, 0.0008, 0, 0.0015, 0, 0.0006, 0, 0.002, 0.0004, 0.0005]
density = 1500
)";

/// Rods, bodies of five spheres of many sizes and, where `mixed`, spheres rain into a box that is periodic in x and
/// open at the far end; a stream brings more, a paddle moves, an event turns some.
Scene bodies(bool mixed) {
  std::string text = R"(
gravity = [1, 0, -9.81]
seed = 11
sort_every = 250
[domain]
lower = [-0.01, 0, 0]
upper = [0.01, 0.016, 0.03]
boundary = ["periodic", ["wall", "open"], "wall"]
[time]
step = 1e-5
duration = 1
[[material]]
name = "m"
density = 2000
[contact]
normal_stiffness = 2000
tangential_stiffness = 600
restitution = 0.6
friction = 0.4
[[group]]
name = "few"
[[source]]
name = "rods"
kind = "random"
number = 90
shape = "rod"
velocity = [0, 0.3, -1]
velocity_jitter = 0.3
group = "few"
[source.region]
lower = [-0.01, 0, 0]
upper = [0.01, 0.016, 0.018]
[source.size]
kind = "uniform"
min = 0.0022
max = 0.0032
[[source]]
name = "tees"
kind = "stream"
shape = "tee"
orientation = "axis"
orientation_axis = [1, 1, 0]
number_rate = 12000
interval = 0.0007
velocity = [0.2, 0.2, -1]
[source.region]
lower = [-0.01, 0, 0.022]
upper = [0.01, 0.016, 0.0295]
[[wall]]
name = "paddle"
shape = "plane"
point = [0, 0.0005, 0]
normal = [0, 1, 0.1]
[wall.motion]
velocity = [0, 0.3, 0]
[[event]]
time = 0.004
action = "set_velocity"
group = "few"
velocity = [0.1, 0, -1]
spin = [50, -80, 20]
)";
  if (mixed)
    text += R"([[source]]
name = "balls"
kind = "random"
number = 70
velocity_jitter = 0.4
[source.region]
lower = [-0.01, 0, 0]
upper = [0.01, 0.016, 0.021]
[source.size]
kind = "uniform"
min = 0.0016
max = 0.0024
)";
  return parse_scene(text + k_shapes, "bodies", "", {});
}

constexpr std::int64_t k_run = 900;  // with three sort epochs

std::uint64_t hash_after(const Scene& scene, const Variant& variant, std::int64_t steps) {
  Simulation sim(variant.apply(scene), variant.options());
  sim.run(steps);
  return sim.state_hash();
}

class BodyTrajectory : public testing::TestWithParam<bool> {};

TEST_P(BodyTrajectory, SameBitsForEveryPairOfPolicyKThreadsChunkAndIsa) {
  const Scene scene = bodies(GetParam());
  const Levels counts = level_counts();
  const std::vector<Levels> rows = full_requested() ? full_product(counts) : pairwise_cover(counts);
  std::map<std::uint64_t, int> seen;
  const std::uint64_t reference = hash_after(scene, {ListPolicy::always, 0, 1, 0, Isa::scalar}, k_run);
  seen[reference] = 1;
  for (const Levels& row : rows) {
    const Variant v = variant_of(row);
    const std::uint64_t hash = hash_after(scene, v, k_run);
    ++seen[hash];
    EXPECT_EQ(hash, reference) << v.text();
  }
  std::printf("bodies%s: %zu combinations, %zu %s\n", GetParam() ? " and spheres" : "", rows.size() + 1, seen.size(),
              seen.size() == 1 ? "hash" : "hashes");
}

TEST_P(BodyTrajectory, RunsAcrossRebuildsSortEpochsChunkBordersAndRemovals) {
  const Variant way{ListPolicy::local, 200, 1, 64, Isa::automatic};
  Simulation sim(way.apply(bodies(GetParam())), way.options());
  double border = 0;
  std::size_t chunks = 0;
  for (int k = 0; k < 9; ++k) {
    sim.run(k_run / 9);
    border += sim.counters().border_contact_share;
    World& w = EngineAccess::world(sim);
    chunks = w.contacts.chunks.size();
    for (const auto& c : w.contacts.chunks)  // no border cuts a body
      if (c->lo > 0 && c->lo < w.rows.n && w.rows.body_of(c->lo) >= 0) {
        EXPECT_TRUE(w.rows.leads(c->lo));
      }
  }
  EXPECT_GT(chunks, 6U);
  EXPECT_GT(border, 0.1);
  EXPECT_GT(sim.counters().rebuilds_skin, 3);
  EXPECT_GT(sim.counters().sort_epochs, 2);
  EXPECT_GT(sim.counters().inserted, 50);
  EXPECT_GT(sim.counters().removed, 3);
  EXPECT_GT(sim.counters().contacts + sim.counters().wall_contacts, 25);
}

TEST_P(BodyTrajectory, ResumesToTheBitFromAnyStepUnderAnotherWayOfRunning) {
  const Scene scene = bodies(GetParam());
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic}, other{ListPolicy::paper, 50, 2, 64, Isa::sse2};
  Simulation whole(plain.apply(scene), plain.options());
  whole.run(k_run);
  for (const std::int64_t at : {1, 249, 250, 437, 700}) {
    Simulation first(other.apply(scene), other.options());
    first.run(at);
    const std::string path = temporary_file("bodies.ckpt", checkpoint_bytes(first));
    const CheckpointReader in(path);
    Simulation second(plain.apply(scene), plain.options(), in);
    EXPECT_EQ(second.state_hash(), first.state_hash()) << at;
    EXPECT_EQ(second.particles(), first.particles()) << at;
    second.run(k_run - at);
    EXPECT_EQ(second.state_hash(), whole.state_hash()) << at;
    EXPECT_EQ(checkpoint_bytes(second), checkpoint_bytes(whole)) << at;
  }
}

TEST_P(BodyTrajectory, BodiesOfADamagedCheckpointAreRefused) {
  const Scene scene = bodies(GetParam());
  Simulation sim(scene, {});
  sim.run(10);
  World& w = EngineAccess::world(sim);
  const auto refused = [&] {
    const std::string path = temporary_file("damaged.ckpt", checkpoint_bytes(sim));
    try {
      const CheckpointReader in(path);
      Simulation again(scene, {}, in);
    } catch (const Error& e) {
      return e.code() == ErrorCode::io;
    }
    return false;
  };
  EXPECT_FALSE(refused());
  const auto broken = [&](auto& column, std::size_t at, auto value) {
    const auto before = column[at];
    column[at] = value;
    EXPECT_TRUE(refused());
    column[at] = before;
  };
  broken(w.rows.bodies.turn, 0, 0.3);
  broken(w.rows.bodies.x, 5, std::nan(""));
  broken(w.rows.bodies.size, 1, -1.0);
  broken(w.rows.bodies.shape, 0, 7);
  broken(w.rows.body, 1, 3);
  broken(w.rows.body, 0, 1 << 29);
  EXPECT_FALSE(refused());
}

INSTANTIATE_TEST_SUITE_P(All, BodyTrajectory, testing::Bool(),
                         [](const auto& p) { return p.param ? "WithSpheres" : "Alone"; });

/// A random scene some of whose sources make bodies.
Scene with_bodies(const Scene& from, int index) {
  Scene s = from;
  s.shapes = bodies(false).shapes;
  s.output.stress = s.output.grid.on = false;
  s.output.regions.clear();
  const CounterRng rng(42, static_cast<std::uint64_t>(index));
  for (std::size_t k = 0; k < s.sources.size(); ++k) {
    Source& q = s.sources[k];
    if (q.kind == Source::Kind::file || rng.uniform(k) < 0.2) continue;
    q.shape = static_cast<int>(rng.bits(100 + k) % 2);
    q.number = q.number / 3 + 1;
    q.number_rate = q.number_rate / 3;
    q.mass = 0;
  }
  return s;
}

class BodyLists : public testing::TestWithParam<ListPolicy> {};

TEST_P(BodyLists, HoldEveryTouchingPairOfRandomScenes) {
  std::int64_t contacts = 0, missed = 0, made = 0;
  for (int index = 0; index < (full_requested() ? 1000 : 60); ++index) {
    const Scene scene = with_random_list(with_bodies(random_scene(index).scene, index), GetParam(), index);
    RunOptions options = random_options(index);
    options.audit = true;
    try {
      Simulation sim(scene, options);
      made += EngineAccess::world(sim).rows.bodies.n;
      for (int part = 0; part < 2; ++part) {
        sim.run(k_audit_steps / 2);
        contacts += sim.counters().contacts;
      }
      EXPECT_EQ(sim.counters().missed_contacts, 0) << scene.title;
      missed += sim.counters().missed_contacts;
    } catch (const Error& e) {
      // what does not fit is refused before a step is made
      if (e.code() != ErrorCode::scene) ADD_FAILURE() << scene.title << ": " << e.what();
    }
  }
  std::printf("%lld bodies, %lld contacts, %lld missed\n", static_cast<long long>(made),
              static_cast<long long>(contacts), static_cast<long long>(missed));
  EXPECT_GT(made, 200);
  EXPECT_GT(contacts, 200);
}

INSTANTIATE_TEST_SUITE_P(All, BodyLists, testing::ValuesIn(exact_policies()),
                         [](const auto& p) { return policy_of(p.param).name(); });

TEST(BodiesLeftOut, SceneOfSpheresHasNoneOfTheirColumns) {
  Simulation sim(hopper(), {});
  const World& w = EngineAccess::world(sim);
  EXPECT_FALSE(w.rows.bodies.in);
  EXPECT_EQ(w.rows.body.capacity(), 0U);
  EXPECT_EQ(w.rows.bodies.columns.bytes(), 0U);
  EXPECT_TRUE(sim.frame().extra.empty());
}

}  // namespace
}  // namespace talus::determinism
