// Superquadrics, alone and among spheres and clumps: lists that are complete for their true surfaces, the same bits for
// every way of running, exact resumes; a scene without them has nothing of them.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <set>

#include "core/base/error.hpp"
#include "core/base/rng.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/nodes/surface.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/random_scenes.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

constexpr const char* k_shapes = R"(
[[shape]]
name = "egg"
kind = "superquadric"
semi_axes = [0.002, 0.001, 0.0014]
[[shape]]
name = "dice"
kind = "superquadric"
semi_axes = [0.001, 0.001, 0.0012]
exponents = [8, 5]
density = 1500
[[shape]]
name = "rod"
spheres = [0, 0, -0.0015, 0.001, 0, 0, 0, 0.001, 0, 0, 0.0015, 0.001]
)";

/// Eggs and dice of many sizes and, where `mixed`, rods and spheres rain into a box that is periodic in x and open at
/// the far end; a stream brings more, a paddle moves past a step with edges, an event turns some.
Scene shaped(bool mixed) {
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
young = 1e6
poisson = 0.3
[contact]
model = "hertz_mindlin"
restitution = 0.6
friction = 0.4
[[group]]
name = "few"
[[source]]
name = "eggs"
kind = "random"
number = 80
shape = "egg"
velocity = [0, 0.3, -1]
velocity_jitter = 0.3
group = "few"
[source.region]
lower = [-0.01, 0, 0.003]
upper = [0.01, 0.016, 0.021]
[source.size]
kind = "uniform"
min = 0.0018
max = 0.0026
[[source]]
name = "dice"
kind = "stream"
shape = "dice"
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
[[wall]]
name = "step"
shape = "box"
lower = [-0.003, 0.005, 0]
upper = [0.003, 0.011, 0.0025]
[[wall]]
name = "roller"
shape = "cylinder"
point = [-0.01, 0.0125, 0.0045]
axis = [1, 0, 0]
length = 0.02
radius = 0.0015
[wall.motion]
rotation_axis = [1, 0, 0]
rotation_origin = [0, 0.0125, 0.0045]
rotation_rate = 100
[[event]]
time = 0.004
action = "set_velocity"
group = "few"
velocity = [0.1, 0, -1]
spin = [50, -80, 20]
)";
  if (mixed)
    text += R"([[source]]
name = "rods"
kind = "random"
number = 30
shape = "rod"
velocity_jitter = 0.4
[source.region]
lower = [-0.01, 0, 0.003]
upper = [0.01, 0.016, 0.021]
[source.size]
kind = "uniform"
min = 0.0018
max = 0.0024
[[source]]
name = "balls"
kind = "random"
number = 40
velocity_jitter = 0.4
[source.region]
lower = [-0.01, 0, 0.003]
upper = [0.01, 0.016, 0.021]
[source.size]
kind = "uniform"
min = 0.0014
max = 0.002
)";
  return parse_scene(text + k_shapes, "superquadrics", "", {});
}

constexpr std::int64_t k_run = 900;  // with three sort epochs

struct Outcome {
  std::uint64_t hash = 0;
  std::int64_t solved = 0, safe = 0;
  auto operator<=>(const Outcome&) const = default;
};

Outcome outcome_after(const Scene& scene, const Variant& variant, std::int64_t steps) {
  Simulation sim(variant.apply(scene), variant.options());
  sim.run(steps);
  const Counters c = sim.counters();
  return {sim.state_hash(), c.solved_pairs, c.safe_pairs};
}

class ShapedTrajectory : public testing::TestWithParam<bool> {};

TEST_P(ShapedTrajectory, SameBitsForEveryPairOfPolicyKThreadsChunkAndIsa) {
  const Scene scene = shaped(GetParam());
  const Levels counts = level_counts();
  const std::vector<Levels> rows = full_requested() ? full_product(counts) : pairwise_cover(counts);
  std::map<std::uint64_t, int> seen;
  const Outcome first = outcome_after(scene, {ListPolicy::always, 0, 1, 0, Isa::scalar}, k_run);
  seen[first.hash] = 1;
  EXPECT_GT(first.solved, 100);
  for (std::size_t k = 0; k < rows.size(); k += GetParam() || full_requested() ? 1 : 3) {
    const Levels& row = rows[k];
    const Variant v = variant_of(row);
    const Outcome other = outcome_after(scene, v, k_run);
    ++seen[other.hash];
    EXPECT_TRUE(other == first) << v.text() << ": pairs " << other.solved << " of " << first.solved << ", safe "
                                << other.safe << " of " << first.safe;
  }
  int ways = 0;
  for (const auto& [hash, count] : seen) ways += count;
  std::printf("superquadrics%s: %d combinations, %zu %s; %lld pairs, %lld by the safe method\n",
              GetParam() ? ", rods and spheres" : "", ways, seen.size(), seen.size() == 1 ? "hash" : "hashes",
              static_cast<long long>(first.solved), static_cast<long long>(first.safe));
}

TEST_P(ShapedTrajectory, RunsAcrossRebuildsSortEpochsChunkBordersAndRemovals) {
  const Variant way{ListPolicy::local, 200, 1, 64, Isa::automatic};
  Simulation sim(way.apply(shaped(GetParam())), way.options());
  double border = 0;
  std::int64_t touching = 0, walls = 0;
  for (int k = 0; k < 9; ++k) {
    sim.run(k_run / 9);
    border += sim.counters().border_contact_share;
    touching += sim.counters().contacts;
    walls += sim.counters().wall_contacts;
  }
  EXPECT_GT(border, 0.1);
  EXPECT_GT(sim.counters().rebuilds_skin, 3);
  EXPECT_GT(sim.counters().sort_epochs, 2);
  EXPECT_GT(sim.counters().inserted, 50);
  EXPECT_GT(sim.counters().removed, 0);
  EXPECT_GT(touching, 30);
  EXPECT_GT(walls, 30);
}

TEST_P(ShapedTrajectory, ResumesToTheBitFromAnyStepUnderAnotherWayOfRunning) {
  const Scene scene = shaped(GetParam());
  const Variant plain{ListPolicy::local, 200, 1, 0, Isa::automatic}, other{ListPolicy::paper, 50, 2, 64, Isa::sse2};
  Simulation whole(plain.apply(scene), plain.options());
  whole.run(k_run);
  for (const std::int64_t at : {1, 249, 250, 437, 700}) {
    Simulation first(other.apply(scene), other.options());
    first.run(at);
    const std::string path = temporary_file("shaped.ckpt", checkpoint_bytes(first));
    const CheckpointReader in(path);
    Simulation second(plain.apply(scene), plain.options(), in);
    EXPECT_EQ(second.state_hash(), first.state_hash()) << at;
    EXPECT_EQ(second.particles(), first.particles()) << at;
    second.run(k_run - at);
    EXPECT_EQ(second.state_hash(), whole.state_hash()) << at;
    EXPECT_EQ(checkpoint_bytes(second), checkpoint_bytes(whole)) << at;
    EXPECT_EQ(first.counters().solved_pairs + second.counters().solved_pairs, whole.counters().solved_pairs) << at;
    EXPECT_EQ(first.counters().safe_pairs + second.counters().safe_pairs, whole.counters().safe_pairs) << at;
  }
}

TEST_P(ShapedTrajectory, FramesChangeNothing) {
  const Scene scene = shaped(GetParam());
  Simulation watched(scene, {}), alone(scene, {});
  for (int k = 0; k < 6; ++k) {
    watched.run(100);
    alone.run(100);
    watched.frame({.contacts = true, .coordination = true});
    EXPECT_EQ(watched.state_hash(), alone.state_hash());
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShapedTrajectory, testing::Bool(),
                         [](const auto& p) { return p.param ? "Mixed" : "Alone"; });

/// Boxes with sharp edges in a heap: deeper than they are round, pairs are searched over all directions.
Scene sharp() {
  return parse_scene(R"(
gravity = [0, 0, -9.81]
seed = 5
sort_every = 100
[domain]
lower = [0, 0, 0]
upper = [0.016, 0.016, 0.012]
boundary = ["periodic", "periodic", "wall"]
[time]
step = 4e-6
duration = 1
[[material]]
name = "m"
density = 2000
[contact]
normal_stiffness = 4000
tangential_stiffness = 1200
restitution = 0.3
friction = 0.3
[[shape]]
name = "box"
kind = "superquadric"
semi_axes = [0.001, 0.001, 0.0006]
exponents = [20, 20]
[[source]]
kind = "random"
number = 60
shape = "box"
velocity_jitter = 3
region = { lower = [0, 0, 0], upper = [0.016, 0.016, 0.012] }
)",
                     "sharp", "", {});
}

TEST(SafePairs, AreCountedOnceWhateverTheWayOfRunning) {
  const Scene scene = sharp();
  const Outcome first = outcome_after(scene, {ListPolicy::local, 200, 1, 0, Isa::automatic}, 300);
  EXPECT_GT(first.safe, 10);
  EXPECT_LT(first.safe, first.solved);
  for (const Variant& v :
       {Variant{ListPolicy::always, 0, 1, 64, Isa::automatic}, {ListPolicy::paper, 50, 2, 64, Isa::scalar}}) {
    const Outcome other = outcome_after(scene, v, 300);
    EXPECT_TRUE(other == first) << v.text() << ": " << other.safe << " of " << other.solved << ", not " << first.safe
                                << " of " << first.solved;
  }
  std::printf("%lld pairs, %lld by the safe method\n", static_cast<long long>(first.solved),
              static_cast<long long>(first.safe));
}

/// A random scene whose sources make superquadrics, clumps and spheres, dense enough to meet.
Scene with_shapes(const Scene& from, int index) {
  Scene s = from;
  s.shapes = shaped(false).shapes;
  s.output.stress = s.output.grid.on = false;
  s.output.regions.clear();
  s.contact.rolling = Rolling::none;
  s.contact.twisting = false;
  s.contact.cohesion = Cohesion::none;
  std::erase_if(s.walls,
                [](const WallSpec& w) { return w.shape == WallShape::cylinder || w.shape == WallShape::cone; });
  const CounterRng rng(43, static_cast<std::uint64_t>(index));
  for (std::size_t k = 0; k < s.sources.size(); ++k) {
    Source& q = s.sources[k];
    if (q.kind == Source::Kind::file || rng.uniform(k) < 0.2) continue;
    q.shape = static_cast<int>(rng.bits(100 + k) % 3);
    q.number = q.number / 2 + 1;
    q.number_rate = q.number_rate / 2;
    q.mass = 0;
  }
  return s;
}

using Pairs = std::set<std::pair<ParticleId, ParticleId>>;

/// All pairs of true surfaces that overlap, by every pair of rows; `doubt`: those within rounding of touch.
Pairs touching(Simulation& sim, Pairs& doubt) {
  const World& w = EngineAccess::world(sim);
  const Box box = w.rules.scene.domain.box();
  Pairs all;
  for (Row i = 0; i < w.rows.n; ++i)
    for (Row j = i + 1; j < w.rows.n; ++j) {
      if (!w.rows.is_alive(i) || !w.rows.is_alive(j)) continue;
      const double *p = w.rows.p.data() + 4L * i, *o = w.rows.p.data() + 4L * j;
      const Vec3 d = box.nearest({o[0] - p[0], o[1] - p[1], o[2] - p[2]});
      if (!(norm(d) < p[3] + o[3])) continue;
      if (superquadric_of(w.rules, w.rows, i) == nullptr && superquadric_of(w.rules, w.rows, j) == nullptr) continue;
      shapes::PairMemory none;
      shapes::PairCount count;
      const auto c = shapes::solve_pair(surface_of(w.rules, w.rows, i).body({}), surface_of(w.rules, w.rows, j).body(d),
                                        none, count);
      const std::pair key{std::min(w.rows.id[i], w.rows.id[j]), std::max(w.rows.id[i], w.rows.id[j])};
      if (std::fabs(c.overlap) < 1e-10 * (p[3] + o[3])) doubt.insert(key);
      if (c.overlap > 0) all.insert(key);
    }
  return all;
}

/// Pairs with a superquadric that the last step has found in touch: they keep the sum of their arms.
Pairs found(Simulation& sim) {
  const World& w = EngineAccess::world(sim);
  Pairs all;
  for (const auto& c : w.contacts.chunks)
    for (const ContactEntry& e : contacts_of(w.rules, *c, false)) {
      const double* arms = e.h + w.rules.has.law_columns + 3;
      if (arms[0] == 0 && arms[1] == 0 && arms[2] == 0) continue;
      all.insert({std::min(w.rows.id[e.a], w.rows.id[e.b]), std::max(w.rows.id[e.a], w.rows.id[e.b])});
    }
  return all;
}

/// Pairs of those are not listed. An event changes them within a step.
void add_held(Simulation& sim, std::set<ParticleId>& ids) {
  const Rows& rows = EngineAccess::world(sim).rows;
  for (Row i = 0; i < rows.n; ++i)
    if (rows.v[static_cast<long>(rows.stride) * (i + 1) - 1] == 0) ids.insert(rows.id[i]);
}

class ShapedLists : public testing::TestWithParam<ListPolicy> {};

// TALUS_FULL=1: 200 scenes, compared in every one of 200 steps; else a few in every eighth step.
TEST_P(ShapedLists, HoldEveryTouchingPairOfTrueSurfacesOfRandomScenes) {
  const bool full = full_requested();
  std::int64_t contacts = 0, missed = 0, made = 0, steps = 0;
  for (int index = 0; index < (full ? 200 : 16); ++index) {
    RunOptions options = random_options(index);
    options.audit = true;
    std::string title = "scene " + std::to_string(index);
    try {
      const Scene scene = with_random_list(with_shapes(random_scene(index).scene, index), GetParam(), index);
      if (!makes_superquadrics(scene)) continue;
      Simulation sim(scene, options);
      made += EngineAccess::world(sim).rows.bodies.n;
      for (std::int64_t step = 0; step < k_audit_steps; ++step) {
        const bool compare = full || step % 8 == 7;
        Pairs doubt, there;
        std::set<ParticleId> fixed;
        if (compare) there = touching(sim, doubt), add_held(sim, fixed);
        const std::int64_t before = sim.counters().inserted + sim.counters().removed;
        sim.run(1);
        if (!compare || sim.counters().inserted + sim.counters().removed != before) continue;
        add_held(sim, fixed);
        const Pairs held = found(sim);
        const auto counts = [&](const std::pair<ParticleId, ParticleId>& p) {
          return doubt.count(p) == 0 && (fixed.count(p.first) == 0 || fixed.count(p.second) == 0);
        };
        ++steps;
        for (const auto& p : there)
          if (held.count(p) == 0 && counts(p)) ++missed, ADD_FAILURE() << title << ", step " << step;
        for (const auto& p : held) EXPECT_TRUE(there.count(p) != 0 || !counts(p)) << title << ", step " << step;
        contacts += static_cast<std::int64_t>(there.size());
      }
      EXPECT_EQ(sim.counters().missed_contacts, 0) << title;
    } catch (const Error& e) {
      // what does not fit is refused before a step is made
      if (e.code() != ErrorCode::scene) ADD_FAILURE() << title << ": " << e.what();
    }
  }
  std::printf("%lld bodies, %lld steps compared, %lld contacts, %lld missed\n", static_cast<long long>(made),
              static_cast<long long>(steps), static_cast<long long>(contacts), static_cast<long long>(missed));
  EXPECT_GT(made, 100);
  EXPECT_GT(contacts, 50);
}

INSTANTIATE_TEST_SUITE_P(All, ShapedLists, testing::ValuesIn(exact_policies()),
                         [](const auto& p) { return policy_of(p.param).name(); });

TEST(SuperquadricsLeftOut, SceneOfSpheresAndClumpsHasNothingOfThem) {
  Simulation sim(hopper(), {});
  sim.run(20);
  const World& w = EngineAccess::world(sim);
  EXPECT_FALSE(w.rules.has.superquadrics);
  EXPECT_EQ(w.rules.has.history_columns, w.rules.has.law_columns);
  EXPECT_EQ(w.rules.law.solver, nullptr);
  for (const auto& c : w.contacts.chunks) EXPECT_EQ(c->wall.arm.capacity(), 0U);
}

}  // namespace
}  // namespace talus::determinism
