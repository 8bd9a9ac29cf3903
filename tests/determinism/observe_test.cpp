// Making output is const: frames hold what is there, and no bit of the run depends on whether they are made.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <set>

#include "scheduler/lists/skin.hpp"
#include "scheduler/lists/skin_check.hpp"
#include "scheduler/step/access.hpp"
#include "tests/determinism/random_scenes.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

/// Touching pairs of the stored positions by brute force: ids, the lower row first.
std::set<std::pair<ParticleId, ParticleId>> touching(const World& w) {
  std::set<std::pair<ParticleId, ParticleId>> found;
  for (Row i = 0; i < w.rows.n; ++i)
    for (Row j = i + 1; j < w.rows.n; ++j) {
      if (!w.rows.is_alive(i) || !w.rows.is_alive(j)) continue;
      if (w.rules.has.fixed && w.rows.fixed[i] != 0 && w.rows.fixed[j] != 0) continue;
      const double *a = w.rows.p.data() + 4L * i, *b = w.rows.p.data() + 4L * j;
      double d2 = 0;
      for (int k = 0; k < 3; ++k) {
        double d = a[k] - b[k];
        if (w.rules.scene.domain.periodic(k))
          d = d > 0.5 * w.rules.size[k] ? d - w.rules.size[k] : (d < -0.5 * w.rules.size[k] ? d + w.rules.size[k] : d);
        d2 += d * d;
      }
      if (d2 < (a[3] + b[3]) * (a[3] + b[3])) found.insert({w.rows.id[i], w.rows.id[j]});
    }
  return found;
}

std::set<std::pair<ParticleId, ParticleId>> pairs_of(const Frame& f) {
  std::set<std::pair<ParticleId, ParticleId>> found;
  for (const ContactRecord& c : f.contacts)
    if (c.b >= 0) found.insert({c.a, c.b});
  return found;
}

std::int64_t walls_of(const Frame& f) {
  return std::count_if(f.contacts.begin(), f.contacts.end(), [](const ContactRecord& c) { return c.b < 0; });
}

struct Looks {
  std::int64_t frames = 0, expired = 0, pairs = 0, walls = 0;
};

/// Steps a scene one by one and looks at random steps, and at steps whose lists have just expired.
void watch(const Scene& s, const RunOptions& o, int seed, Looks& looks) {
  Simulation sim(s, o), undisturbed(s, o);
  std::uint64_t random = static_cast<std::uint64_t>(seed) * 0x9e3779b97f4a7c15ULL + 1;
  std::int64_t expired_here = 0;
  for (int n = 0; n < static_cast<int>(k_audit_steps); ++n) {
    const World& w = EngineAccess::world(sim);
    random = random * 6364136223846793005ULL + 1442695040888963407ULL;
    const bool expired = n > 0 && lists_expired(w.rules, w.clock, w.contacts, w.lists, w.walls) && expired_here < 4;
    if (!expired && (random >> 33) % 24 != 0) {
      sim.run(1);
      continue;
    }
    const Frame f = sim.frame({.contacts = true});
    ASSERT_EQ(pairs_of(f), touching(w)) << s.title << ", " << policy_of(s.list.policy).name() << ", step " << f.step;
    ++looks.frames;
    looks.expired += expired ? 1 : 0;
    expired_here += expired ? 1 : 0;
    looks.pairs += static_cast<std::int64_t>(pairs_of(f).size());
    looks.walls += walls_of(f);
    // the next step finds the same contacts, unless a source or an event acts before
    const std::int64_t inserted = sim.counters().inserted;
    sim.run(1);
    if (sim.counters().inserted != inserted || !s.events.empty()) continue;
    EXPECT_EQ(sim.counters().contacts, static_cast<std::int64_t>(pairs_of(f).size())) << s.title << " " << f.step;
    EXPECT_EQ(sim.counters().wall_contacts, walls_of(f)) << s.title << " " << f.step;
  }
  undisturbed.run(k_audit_steps);
  EXPECT_EQ(sim.state_hash(), undisturbed.state_hash()) << s.title;
}

class EveryPolicy : public testing::TestWithParam<ListPolicy> {};

TEST_P(EveryPolicy, FramesHoldEveryTouchingPairAtAnyStepAlsoWhereListsHaveExpired) {
  Looks looks;
  for (int k = 0; k < 16; ++k)
    watch(with_random_list(random_scene(k).scene, GetParam(), k), random_options(k), k, looks);
  EXPECT_GT(looks.frames, 100);
  EXPECT_GT(looks.pairs, 300);
  EXPECT_GT(looks.walls, 50);
  if (GetParam() != ListPolicy::always) {
    EXPECT_GT(looks.expired, 15) << "looks that fell on a step whose lists had expired";
  }
}

INSTANTIATE_TEST_SUITE_P(Policies, EveryPolicy, testing::ValuesIn(exact_policies()),
                         [](const testing::TestParamInfo<ListPolicy>& i) { return policy_of(i.param).name(); });

TEST(Observe, FrameHoldsEveryTouchingPairAlsoAtSortEpochs) {
  for (Scene (*build)() : {sheared_bed, gas}) {
    Scene s = build();
    s.list.policy = ListPolicy::paper;  // lists expire often
    s.list.verlet_k = 3;
    s.list.automatic = false;
    s.sort_every = 40;
    RunOptions o;
    o.threads = 2;
    o.chunk = 64;
    Simulation sim(s, o);
    std::size_t all = 0;
    for (int k = 0; k < 12; ++k) {
      sim.run(20);  // every second stop is an epoch
      const Frame f = sim.frame({.contacts = true});
      EXPECT_EQ(pairs_of(f), touching(EngineAccess::world(sim))) << "step " << f.step;
      all += pairs_of(f).size();
    }
    EXPECT_GT(all, 100U);
  }
}

/// What a run reports at one step, to the bit.
struct Report {
  std::uint64_t hash = 0, planes = 0;
  std::array<std::uint64_t, 12> numbers{};
  std::array<std::int64_t, 8> counts{};
  std::vector<std::uint64_t> loads;
  bool operator==(const Report&) const = default;
};

Report report(const Simulation& sim) {
  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x); };
  const Energies e = sim.energies();
  const Counters c = sim.counters();
  Report r;
  r.hash = sim.state_hash();
  r.planes = sim.planes_hash();
  r.numbers = {bits(e.kinetic_translation),
               bits(e.kinetic_rotation),
               bits(e.potential),
               bits(e.elastic),
               bits(e.dissipated_damping),
               bits(e.dissipated_friction),
               bits(e.wall_work),
               bits(e.dissipated_background),
               bits(e.inserted),
               bits(e.residual),
               bits(c.removed_mass),
               bits(sim.kinetic_energy())};
  r.counts = {c.contacts, c.wall_contacts, c.inserted, c.removed,
              c.rebuilds, c.rebuilds_skin, c.pairs,    sim.particles()};
  for (const WallLoad& l : sim.frame({.wall_loads = true}).wall_loads)
    for (int k = 0; k < 3; ++k) {
      r.loads.push_back(bits(l.force[k]));
      r.loads.push_back(bits(l.torque[k]));
    }
  return r;
}

class Output : public testing::TestWithParam<NamedScene> {};

TEST_P(Output, OfAnyKindAtAnyStepChangesNoBitOfStateLedgerCountersAndSeries) {
  constexpr std::int64_t every = 250, end = 1500;
  Scene s = Variant{ListPolicy::local, 200, 1, 64, Isa::automatic}.apply(GetParam().build());
  s.output.energies = true;
  const Vec3 middle = 0.5 * (s.domain.lower + s.domain.upper);
  s.output.flux_planes = {{"x", middle, {1, 0, 0}}, {"z", middle, {0, 0, 1}}};
  RunOptions o;
  o.threads = 2;
  o.chunk = 64;
  std::vector<Report> reference;
  Simulation plain(s, o);
  for (std::int64_t n = every; n <= end; n += every) {
    plain.run(every);
    reference.push_back(report(plain));
  }
  // contacts, coordination, stress, walls, wall_loads: each alone, then all; at odd steps, and twice in a row
  const FrameRequest requests[] = {{true, false, false, false, false},
                                   {false, true, false, false, false},
                                   {false, false, true, false, false},
                                   {false, false, false, true, false},
                                   {true, true, true, true, true}};
  for (const FrameRequest& q : requests) {
    Simulation watched(s, o);
    std::size_t row = 0;
    watched.frame(q);
    for (std::int64_t n = 0; n < end;) {
      const std::int64_t to = std::min((n / every + 1) * every, n + 37);
      watched.run(to - n);
      n = to;
      watched.frame(q);
      watched.frame(q);
      watched.energies();
      if (n % every == 0) {
        EXPECT_TRUE(report(watched) == reference[row]) << "step " << n;
        ++row;
      }
    }
  }
  // no ledger and no planes: the trajectory is the same
  Scene bare = s;
  bare.output = {};
  Simulation without(bare, o);
  without.run(end);
  EXPECT_EQ(without.state_hash(), plain.state_hash());
}

TEST_P(Output, FrameAtTheStepOfAResumeIsThatOfTheUninterruptedRun) {
  const Scene s = GetParam().build();
  const Variant way{ListPolicy::local, 200, 1, 64, Isa::automatic},
      other{ListPolicy::paper, 20, 2, 257, Isa::automatic};
  Simulation sim(way.apply(s), way.options());
  for (const std::int64_t step : {333, 700}) {
    sim.run(step - sim.step());
    const std::string path = temporary_file("frame.checkpoint");
    CheckpointWriter out;
    sim.save(out);
    out.commit(path);
    const Simulation resumed(other.apply(s), other.options(), CheckpointReader(path));
    const FrameRequest all{.contacts = true, .coordination = true, .stress = true, .walls = true};
    const Frame a = sim.frame(all), b = resumed.frame(all);
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.coordination, b.coordination);
    EXPECT_EQ(a.stress, b.stress) << "sums in one order, whatever the chunks";
    ASSERT_EQ(a.contacts.size(), b.contacts.size());
    EXPECT_GT(a.contacts.size(), 10U);
    for (std::size_t k = 0; k < a.contacts.size(); ++k) {
      const ContactRecord &x = a.contacts[k], &y = b.contacts[k];
      ASSERT_TRUE(x.a == y.a && x.b == y.b && x.overlap == y.overlap) << k;
      for (int q = 0; q < 3; ++q)
        ASSERT_TRUE(x.normal_force[q] == y.normal_force[q] && x.tangential_force[q] == y.tangential_force[q]) << k;
    }
    ASSERT_EQ(a.walls.size(), b.walls.size());
    for (std::size_t k = 0; k < a.walls.size(); ++k)
      for (std::size_t q = 0; q < a.walls[k].points.size(); ++q)
        ASSERT_EQ(norm2(a.walls[k].points[q] - b.walls[k].points[q]), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Output, testing::ValuesIn(scenes()),
                         [](const testing::TestParamInfo<NamedScene>& i) { return std::string(i.param.name); });

// The forces of a frame are those of the step to come: the loads on walls that this step leaves are their sums.
TEST(Observe, WallForcesOfAFrameAreTheLoadsOfTheNextStep) {
  for (Scene (*build)() : {pile_on_mesh, hertz_drum, sticky_drum}) {
    Simulation sim(build(), RunOptions{});
    sim.run(1200);
    const Frame f = sim.frame({.contacts = true});
    sim.run(1);
    const Frame after = sim.frame({.wall_loads = true});
    std::vector<Vec3> sum(after.wall_loads.size());
    double scale = 0;
    for (const ContactRecord& c : f.contacts)
      if (c.b < 0) {
        const auto wall = static_cast<std::size_t>(-1 - c.b);
        sum[wall] = sum[wall] - (c.normal_force + c.tangential_force);
        scale += norm(c.normal_force);
      }
    EXPECT_GT(scale, 0);
    for (std::size_t k = 0; k < sum.size(); ++k)
      EXPECT_LT(norm(sum[k] - after.wall_loads[k].force), 1e-12 * scale) << k;
  }
}

}  // namespace
}  // namespace talus::determinism
