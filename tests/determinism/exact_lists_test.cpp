// Exact lists: over 200 random scenes x 200 steps the audit (scheduler/lists/audit.cpp, checked against all pairs
// below) finds no touching pair, grain or wall, that the list lacks, for every policy. TALUS_FULL=1 runs ten times as
// many scenes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/error.hpp"
#include "core/scene/scene_file.hpp"
#include "kernels/kernel_table.hpp"
#include "scheduler/lists/audit.hpp"
#include "scheduler/lists/skin.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/random_scenes.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"
#include "tests/faults.hpp"

namespace talus::determinism {
namespace {

int scene_count() { return full_requested() ? 2000 : 200; }

Counters audited(const Scene& scene, RunOptions options, std::int64_t steps) {
  options.audit = true;
  Simulation sim(scene, options);
  try {
    sim.run(steps);
  } catch (const Error&) {
    // a grain that a broken list lost may fly through a closed side: the counters stay readable
    EXPECT_NE(hooks_of_tests.skin, 1);
  }
  return sim.counters();
}

class Lists : public testing::TestWithParam<ListPolicy> {};

TEST_P(Lists, HoldEveryTouchingPairOfRandomScenes) {
  struct {
    std::int64_t steps = 0, missed = 0, contacts = 0, wall_contacts = 0, inserted = 0, removed = 0, rebuilds = 0,
                 forced = 0;
    std::int64_t most = 0;
    int periodic = 0, open = 0, moving = 0, inserts = 0, mesh = 0, events = 0;
    double slowest = 1e300, fastest = 0, ratio = 1;
  } t;
  for (int index = 0; index < scene_count(); ++index) {
    const RandomScene r = random_scene(index);
    RunOptions options = random_options(index);
    options.audit = true;
    try {
      Simulation sim(with_random_list(r.scene, GetParam(), index), options);
      for (int part = 0; part < 4; ++part) {
        sim.run(k_audit_steps / 4);
        t.contacts += sim.counters().contacts;
        t.wall_contacts += sim.counters().wall_contacts;
        t.most = std::max(t.most, sim.particles());
      }
      const Counters c = sim.counters();
      EXPECT_EQ(c.missed_contacts, 0) << r.scene.title;
      ASSERT_EQ(c.steps, k_audit_steps);
      t.steps += c.steps;
      t.missed += c.missed_contacts;
      t.inserted += c.inserted;
      t.removed += c.removed;
      t.rebuilds += c.rebuilds;
      t.forced += c.rebuilds_forced;
    } catch (const Error& e) {
      ADD_FAILURE() << r.scene.title << ": " << e.what();
    }
    t.periodic += r.periodic ? 1 : 0;
    t.open += r.open ? 1 : 0;
    t.moving += r.moving_walls ? 1 : 0;
    t.inserts += r.inserts ? 1 : 0;
    t.mesh += r.mesh ? 1 : 0;
    t.events += r.events ? 1 : 0;
    t.slowest = fmin2(t.slowest, r.speed);
    t.fastest = fmax2(t.fastest, r.speed);
    t.ratio = fmax2(t.ratio, r.ratio);
  }
  std::printf(
      "%d scenes (%d periodic, %d open, %d with moving walls, %d inserting, %d with meshes, %d with events; %g to %g "
      "m/s; size "
      "ratio to %.1f; at most %lld grains): %lld audited steps, %lld rebuilds (%lld forced), %lld + %lld grain and "
      "wall contacts at "
      "4 samples per scene, %lld inserted, %lld removed, %lld missed\n",
      scene_count(), t.periodic, t.open, t.moving, t.inserts, t.mesh, t.events, t.slowest, t.fastest, t.ratio,
      static_cast<long long>(t.most), static_cast<long long>(t.steps), static_cast<long long>(t.rebuilds),
      static_cast<long long>(t.forced), static_cast<long long>(t.contacts), static_cast<long long>(t.wall_contacts),
      static_cast<long long>(t.inserted), static_cast<long long>(t.removed), static_cast<long long>(t.missed));
  std::fflush(stdout);
  EXPECT_EQ(t.missed, 0);
  // The scenes must contain what the claim names.
  const int n = scene_count();
  EXPECT_GE(t.fastest / t.slowest, 999);
  EXPECT_GE(t.ratio, 3.5);
  EXPECT_LE(t.most, 500);
  EXPECT_GE(t.periodic, n / 4);
  EXPECT_LE(t.periodic, n * 9 / 10);
  EXPECT_GE(t.open, n / 4);
  EXPECT_GE(t.moving, n / 4);
  EXPECT_GE(t.inserts, n / 4);
  EXPECT_GE(t.mesh, n / 10);
  EXPECT_GE(t.events, n / 10);
  EXPECT_GE(t.contacts, 20 * n);
  EXPECT_GE(t.wall_contacts, 4 * n);
  EXPECT_GE(t.inserted, 5 * n);
  EXPECT_GE(t.removed, n);
  if (GetParam() != ListPolicy::always) {
    EXPECT_LT(t.rebuilds, t.steps * 3 / 4) << "lists must be reused, or nothing is tested";
  }
}

// What the audit sees: with all pairs struck off the lists it misses exactly those that touch, which are counted here
// pair by pair.
TEST(ListAudit, SeesEveryTouchingPairOnce) {
  std::int64_t touching = 0;
  int periodic = 0;
  for (int index = 0; index < 400; ++index) {
    const RandomScene made = random_scene(index);
    Simulation sim(made.scene, random_options(index));
    sim.run(k_audit_steps / 3);
    SCOPED_TRACE("scene " + std::to_string(index));
    const World& w = EngineAccess::world(sim);
    for (const auto& c : w.contacts.chunks) std::fill(std::begin(c->list.end), std::end(c->list.end), 0);
    std::int64_t wanted = 0;
    for (Row i = 0; i < w.rows.n; ++i)
      for (Row j = i + 1; j < w.rows.n; ++j) {
        if (!w.rows.is_alive(i) || !w.rows.is_alive(j)) continue;
        if (w.rules.has.fixed && w.rows.fixed[i] != 0 && w.rows.fixed[j] != 0) continue;
        double d2 = 0;
        for (int k = 0; k < 3; ++k) {
          double d = std::abs(w.rows.p[4L * i + k] - w.rows.p[4L * j + k]);
          if (w.rules.scene.domain.periodic(k)) d = std::min(d, std::abs(d - w.rules.size[k]));
          d2 += d * d;
        }
        const double ri = w.rows.p[4L * i + 3], rj = w.rows.p[4L * j + 3];
        const double r = ri + w.lists.skin.range(ri) + rj + w.lists.skin.range(rj);
        wanted += d2 < r * r ? 1 : 0;
      }
    const std::int64_t missed = audit_lists(w.rules, w.rows, w.contacts, w.lists, w.walls);
    EXPECT_EQ(missed, wanted);
    touching += wanted;
    periodic += made.periodic ? 1 : 0;
  }
  std::printf("%lld touching pairs, %d of 400 scenes periodic\n", static_cast<long long>(touching), periodic);
  EXPECT_GT(touching, 1000);
  EXPECT_GT(periodic, 100);
}

// The audit can fail: a check against three times the skin that the list was built for loses contacts.
TEST_P(Lists, AuditFindsWhatAListWithTooLargeASkinLacks) {
  std::int64_t missed = 0;
  int caught = 0, scenes = 0;
  for (int index = 0; index < 40; ++index) {
    Scene s = with_random_list(random_scene(index).scene, GetParam(), index);
    s.list.verlet_k = 200;
    s.list.automatic = false;
    s.list.uniform_skin = 1;
    RunOptions options = random_options(index);
    options.audit = true;
    const faults::SeededFault seeded(faults::Fault::skin);
    Simulation sim(s, options);
    try {
      sim.run(k_audit_steps);
    } catch (const Error&) {
      // a grain that no list holds may fly through a closed wall: the counters stay readable
    }
    ++scenes;
    missed += sim.counters().missed_contacts;
    caught += sim.counters().missed_contacts > 0 ? 1 : 0;
  }
  std::printf("broken skin: %d of %d scenes caught, %lld missed contacts\n", caught, scenes,
              static_cast<long long>(missed));
  if (GetParam() == ListPolicy::always) {
    EXPECT_EQ(missed, 0) << "without a skin there is nothing to break";
  } else {
    // mean_subtracted: next to walls its lists also end with the travel of the frame, mostly before a skin is used up
    EXPECT_GE(caught, GetParam() == ListPolicy::mean_subtracted ? scenes / 20 : scenes / 10);
  }
}

// Walls have their own part of the audit: grains that never meet each other fall on a moving mesh.
TEST_P(Lists, AuditSeesWallContactsThatTheListLacks) {
  Scene s = pile_on_mesh();
  s.sources[0].kind = Source::Kind::lattice;
  s.sources[0].spacing = 1.2;
  s.sources[0].number = 40;
  s.sources[0].region.upper.z = 0.009;
  s.sources[0].velocity_jitter = 0;
  s.list.policy = GetParam();
  RunOptions options;
  options.threads = 1;
  EXPECT_EQ(audited(s, options, 400).missed_contacts, 0);
  const faults::SeededFault seeded(faults::Fault::skin);
  if (GetParam() != ListPolicy::always) {
    EXPECT_GT(audited(s, options, 400).missed_contacts, 0);
  }
}

// A grain that wraps between two rebuilds meets the wall elements at the other end of the period.
TEST_P(Lists, HoldWallElementsBeyondAPeriodicBorder) {
  Scene s = pile_on_mesh();
  s.sources[0].number = 300;
  s.sources[0].velocity = {0, 3, -1.5};
  s.list.policy = GetParam();
  s.list.verlet_k = 1000;
  s.list.automatic = false;
  RunOptions options;
  options.threads = 1;
  const Counters c = audited(s, options, 1000);
  EXPECT_EQ(c.missed_contacts, 0);
  EXPECT_GT(c.wall_contacts, 0);
}

// The same for walls that move through the sides themselves.
TEST_P(Lists, HoldImagesOfWallsThatMoveThroughTheSides) {
  Scene s = crossing_walls();
  s.list.policy = GetParam();
  s.list.verlet_k = 400;
  s.list.automatic = false;
  RunOptions options;
  options.threads = 1;
  options.audit = true;
  Simulation sim(s, options);
  std::int64_t contacts = 0;
  for (int part = 0; part < 10; ++part) {
    sim.run(50);
    contacts += sim.counters().wall_contacts;
  }
  EXPECT_EQ(sim.counters().missed_contacts, 0);
  EXPECT_GT(contacts, 40);
}

// Nothing but the way between grains and wall may end the list here: no grain moves against another one. The first
// touch is 45 steps away, several times the life of a list, and beyond its reach.
TEST_P(Lists, HoldAWallThatComesToRestingGrainsAndOneThatDriftingGrainsReach) {
  const std::string text = R"(
domain = { lower = [0, 0, 0], upper = [0.06, 0.02, 0.02] }
time = { step = 1e-5, steps = 200 }
contact = { normal_stiffness = 4000, restitution = 0.5 }
[[material]]
name = "glass"
density = 2500
[[source]]
kind = "lattice"
spacing = 1.5
region = { lower = [0.011, 0, 0], upper = [0.03, 0.02, 0.02] }
size = { kind = "constant", diameter = 0.002 }
[[wall]]
name = "piston"
shape = "plane"
point = [0.0101, 0, 0]
normal = [1, 0, 0]
[list]
verlet_k = 20
)";
  for (const bool drift : {false, true}) {
    Scene s = parse_scene(text, "piston", ".");
    (drift ? s.sources.at(0).velocity : s.walls.at(0).motion.velocity) = {drift ? -2.0 : 2.0, 0, 0};
    s.list.policy = GetParam();
    s.list.automatic = false;
    const Counters c = audited(s, {}, 60);
    EXPECT_EQ(c.missed_contacts, 0) << (drift ? "drift" : "piston");
    EXPECT_GT(c.wall_contacts, 20);
    if (GetParam() != ListPolicy::always) {
      EXPECT_LT(c.rebuilds, 30) << "lists must be reused, or nothing is tested";
    }
  }
}

std::string policy_name(const testing::TestParamInfo<ListPolicy>& info) { return policy_of(info.param).name(); }

INSTANTIATE_TEST_SUITE_P(Policies, Lists, testing::ValuesIn(exact_policies()), policy_name);

}  // namespace
}  // namespace talus::determinism
