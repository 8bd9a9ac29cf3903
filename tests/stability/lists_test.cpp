// Scenarios 24 to 31, 36, 37, 39 and 40: bad input, numbers that are none, cells and lists at their limits,
// determinism.
#include <xmmintrin.h>

#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "core/base/rng.hpp"
#include "core/scene/scene_file.hpp"
#include "scheduler/step/access.hpp"
#include "tests/breathing.hpp"
#include "tests/faults.hpp"
#include "tests/stability/stability_support.hpp"

namespace talus::stability {
namespace {

TEST(Stability, S24_BadNumbersAreRefusedWithLineAndRow) {
  const std::string good =
      "[domain]\nlower=[0,0,0]\nupper=[1,1,1]\n[time]\nstep=1e-5\nsteps=1\n[[material]]\nname=\"a\"\ndensity=2500\n"
      "[contact]\nnormal_stiffness=1e3\n";
  ASSERT_EQ(refusal([&] { parse_scene(good, "t.toml", ".", {}); }), "");
  int refused = 0;
  const std::pair<const char*, const char*> bad[] = {
      {"density=2500", "density=0"},      {"density=2500", "density=nan"},
      {"density=2500", "density=inf"},    {"step=1e-5", "step=0"},
      {"step=1e-5", "step=-1e-5"},        {"step=1e-5", "step=nan"},
      {"stiffness=1e3", "stiffness=-1"},  {"stiffness=1e3", "stiffness=0"},
      {"stiffness=1e3", "stiffness=inf"}, {"upper=[1,1,1]", "upper=[1,1,nan]"},
      {"upper=[1,1,1]", "upper=[1,1,0]"}};
  for (const auto& [from, to] : bad) {
    std::string text = good;
    text.replace(text.find(from), std::string(from).size(), to);
    const std::string message = refusal([&] { parse_scene(text, "t.toml", ".", {}); });
    EXPECT_NE(message.find("t.toml:"), std::string::npos) << to << " -> " << message;
    refused += message.empty() ? 0 : 1;
  }
  const char* rows[] = {"nan,0.5,0.5,0.01,0,0,0", "0.5,inf,0.5,0.01,0,0,0", "0.5,0.5,0.5,-0.01,0,0,0",
                        "0.5,0.5,0.5,0,0,0,0",    "0.5,0.5,0.5,nan,0,0,0",  "1e300,0.5,0.5,0.01,0,0,0"};
  for (const char* row_text : rows) {
    Scene s = parse_scene(good, "t.toml", ".", {});
    Source q;
    q.kind = Source::Kind::file;
    q.file = temporary("bad.csv", std::string("x,y,z,radius,vx,vy,vz\n0.2,0.2,0.2,0.01,0,0,0\n") + row_text + "\n");
    s.sources = {q};
    const std::string message = refusal([&] { Simulation(s, options()); });
    EXPECT_NE(message.find("bad.csv:3"), std::string::npos) << row_text << " -> " << message;
    refused += message.empty() ? 0 : 1;
  }
  row("NaN, Inf, non-positive radius, density, step: refused with file and line",
      std::to_string(refused) + " of 17 refused");
}

TEST(Stability, S25_NanBornInARunIsNamedAtOnceAndTheStateBeforeItKept) {
  for (const Boundary side : {Boundary::wall, Boundary::open, Boundary::periodic}) {
    Scene s = open_scene({0, 0, 0}, {0.2, 0.2, 0.2}, 1e-5);
    for (auto& axis : s.domain.boundary) axis = {side, side};
    linear_law(s, 1e4, 50);
    s.allow_initial_overlap = true;
    add_grains(s, {{{0.1, 0.1, 0.1}, {}, 0.01}, {{0.1199, 0.1, 0.1}, {}, 0.01}});
    const faults::SeededFault seeded(faults::Fault::force);  // in step 50
    Simulation sim(s, options());
    hooks_of_tests = {};  // the run that goes on is sound
    const std::string text = refusal([&] { sim.run(100); });
    EXPECT_NE(text.find("step 50: particle 0 in contact with particle 1 gets a non-finite"), std::string::npos) << text;
    EXPECT_EQ(sim.step(), 50);
    EXPECT_EQ(sim.particles(), 2);
    ASSERT_EQ(sim.culprits().size(), 1U);
    for (const Vec3& x : sim.frame().x) EXPECT_TRUE(std::isfinite(norm2(x)));
    EXPECT_EQ(sim.frame({.contacts = true}).contacts.size(), 1U);
    CheckpointWriter out;
    sim.save(out);
    const std::string path = temporary("nan.tcp", "");
    out.commit(path);
    const Simulation again(s, options(), CheckpointReader(path));
    EXPECT_EQ(again.step(), 50);
  }
  row("injected NaN: stopped in the same step with id, step and partner; the state before it saved and readable",
      "step 50 named, state of step 50 kept (wall, open, periodic)");
}

TEST(Stability, S26_ParticlesOnCellFacesAndCornersOneUlpEitherWay) {
  std::int64_t missed = 0, contacts = 0;
  int scenes = 0;
  const double ulps[3] = {-1, 0, 1};
  for (const Boundary side : {Boundary::periodic, Boundary::wall})
    for (int cells = 2; cells <= 7; ++cells)
      for (int shift = 0; shift < 3; ++shift) {
        // lattice of touching grains whose pitch is the cell edge or a half of it: every coordinate is a face
        const double edge = 0.015 * (1 + 1e-5 * cells), r = 0.5 * edge * 1.002;
        const double side_length = cells * 2 * edge;
        Scene s = open_scene({0, 0, 0}, {side_length, side_length, side_length}, 1e-7);
        for (auto& axis : s.domain.boundary) axis = {side, side};
        linear_law(s, 1e3, 0);
        s.list.cell_factor = cells % 2 == 0 ? 1 : 0;
        s.allow_initial_overlap = true;
        std::vector<Grain> grains;
        const int per = std::min(2 * cells, 6);
        for (int k = 0; k < per * per * per; ++k) {
          const auto place = [&](int c) {
            const double at = side == Boundary::periodic ? edge * c : edge * (c + 0.5);
            const double towards = at + ulps[shift] * 1;
            const double moved = ulps[shift] == 0 ? at : std::nextafter(at, towards);
            return moved < 0 ? std::nextafter(side_length, 0) : moved;
          };
          grains.push_back({{place(k % per), place(k / per % per), place(k / per / per)}, {}, r});
        }
        add_grains(s, grains);
        RunOptions o = options();
        o.audit = true;
        Simulation sim(s, o);
        sim.run(3);
        missed += sim.counters().missed_contacts;
        contacts += sim.counters().contacts;
        ++scenes;
      }
  EXPECT_EQ(missed, 0);
  EXPECT_GT(contacts, 1000);
  row("pair set = brute force for lattices on cell faces, box corners and periodic faces, -1, 0, +1 ulp",
      std::to_string(scenes) + " scenes, " + std::to_string(contacts) + " contacts, 0 missed");
}

TEST(Stability, S27_BoxesOfOneToThreeCellsHoldEveryPairOnce) {
  std::int64_t missed = 0;
  int wrong = 0, scenes = 0;
  const double r = 0.01;
  for (const double side : {4.001, 4.2, 5.0, 6.0, 6.3, 8.0, 9.0, 9.3, 12.6})
    for (int seed = 0; seed < 5; ++seed) {
      const double length = side * r;
      Scene s = open_scene({0, 0, 0}, {length, length, length}, 1e-6);
      for (auto& axis : s.domain.boundary) axis = {Boundary::periodic, Boundary::periodic};
      linear_law(s, 1e3, 0);
      s.allow_initial_overlap = true;
      s.max_overlap = 1;
      std::vector<Grain> grains;
      const auto distance = [&](Vec3 a, Vec3 b) {
        Vec3 d = a - b;
        for (int k = 0; k < 3; ++k) d[k] -= length * std::round(d[k] / length);
        return norm(d);
      };
      for (int k = 0; grains.size() < 12 && k < 4000; ++k) {
        const auto q = [&](int c) { return length * uniform(31 + seed, static_cast<std::uint64_t>(4 * k + c)); };
        const Grain g{{q(0), q(1), q(2)}, {}, r};
        bool deep = false;
        for (const Grain& o : grains) deep = deep || distance(o.x, g.x) < 1.3 * r;
        if (!deep) grains.push_back(g);
      }
      std::int64_t pairs = 0;
      for (std::size_t a = 0; a < grains.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) pairs += distance(grains[a].x, grains[b].x) < 2 * r ? 1 : 0;
      add_grains(s, grains);
      RunOptions o = options();
      o.audit = true;
      o.chunk = seed % 2 == 0 ? 5 : 0;
      Simulation sim(s, o);
      sim.run(1);
      missed += sim.counters().missed_contacts;
      wrong += sim.counters().contacts == pairs ? 0 : 1;
      ++scenes;
    }
  EXPECT_EQ(missed, 0);
  EXPECT_EQ(wrong, 0);
  for (const double side : {1.0, 3.0, 4.0}) {
    Scene s = open_scene({0, 0, 0}, {side * r, 1, 1}, 1e-6);
    s.domain.boundary[0] = {Boundary::periodic, Boundary::periodic};
    linear_law(s, 1e3, 0);
    add_grains(s, {{{0.5 * side * r, 0.5, 0.5}, {}, r}});
    const std::string text = refusal([&] { Simulation(s, options()); });
    EXPECT_NE(text.find("periodic side must be longer than twice the largest diameter"), std::string::npos) << text;
  }
  row("periodic boxes of 1, 2, 3 cells: each pair once; sides up to 4 R refused by name",
      std::to_string(scenes) + " boxes, 0 missed, 0 double");
}

TEST(Stability, S28_EscapersAreRemovedOrNamed) {
  const auto shot = [](Boundary side, double speed, double max_travel) {
    Scene s = open_scene({0, 0, 0}, {1, 1, 1}, 1e-5);
    for (auto& axis : s.domain.boundary) axis = {side, side};
    linear_law(s, 1e3, 0);
    s.monitor.max_travel = max_travel;
    add_grains(s, {{{0.5, 0.5, 0.5}, {speed, 0.3 * speed, -speed}, 0.01}, {{0.2, 0.2, 0.2}, {}, 0.01}});
    return s;
  };
  int named = 0, removed = 0, went_round = 0;
  for (const double speed : {1e4, 1e9, 1e30, 1e90}) {
    for (const Boundary side : {Boundary::open, Boundary::wall, Boundary::periodic}) {
      const std::string text = refusal([&] { Simulation(shot(side, speed, 1), options()).run(50); });
      EXPECT_NE(text.find("particle 0 moves"), std::string::npos) << speed << text;
      named += text.empty() ? 0 : 1;
    }
    // unguarded: open sides remove it, closed ones and impossible coordinates are named; nothing reads out of bounds
    Simulation open(shot(Boundary::open, speed, 1e300), options());
    const std::string from_open = refusal([&] { open.run(50); });
    EXPECT_TRUE(open.particles() == 1 || from_open.find("particle 0") != std::string::npos) << speed << from_open;
    const std::string closed = refusal([&] { Simulation(shot(Boundary::wall, speed, 1e300), options()).run(50); });
    EXPECT_NE(closed.find("particle 0"), std::string::npos) << speed << closed;
    // many periods in one step
    const std::string around = refusal([&] { Simulation(shot(Boundary::periodic, speed, 1e300), options()).run(50); });
    EXPECT_TRUE(around.empty() || around.find("particle 0") != std::string::npos) << speed << around;
    removed += from_open.empty() ? 1 : 0;
    went_round += around.empty() ? 1 : 0;
    named += (from_open.empty() ? 0 : 1) + (closed.empty() ? 0 : 1) + (around.empty() ? 0 : 1);
  }
  row("1e4 ... 1e90 m/s through open, closed and periodic sides: named or removed, never out of bounds",
      std::to_string(named) + " named, " + std::to_string(removed) + " removed, " + std::to_string(went_round) +
          " went round; of 24");
}

TEST(Stability, S29_BurstInsertionDeletionOfAllAndEmptyScenesRunOn) {
  const int n = full() ? 100000 : 20000;
  const double side = 0.02 * std::cbrt(n / 0.4 * 0.5236);
  Scene s = open_scene({0, 0, 0}, {side, side, side}, 1e-5);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  linear_law(s, 1e4, 10);
  Source burst;
  burst.kind = Source::Kind::lattice;
  burst.lattice = Source::Lattice::cubic;
  burst.region = {{0, 0, 0}, {side, side, side}};
  burst.size.diameter = 0.02;
  burst.number = n;
  burst.start = 1e-3;
  burst.velocity_jitter = 0.5;
  s.sources = {burst};
  s.groups = {{"all", false, Region{{0, 0, 0}, {side, side, side}}, {}}};
  s.events.resize(1);
  s.events[0].time = 1.5e-3;
  s.events[0].action = Event::Action::remove;
  s.events[0].group = 0;
  Simulation sim(s, options());
  sim.run(90);
  EXPECT_EQ(sim.particles(), 0);
  sim.run(20);
  const auto present = sim.particles();
  EXPECT_GT(present, n / 2);
  EXPECT_GT(sim.counters().rebuilds_forced, 0);
  sim.run(100);
  EXPECT_EQ(sim.particles(), 0);
  sim.run(1000);  // across a sort epoch, with nothing there
  EXPECT_EQ(sim.step(), 1210);
  row("empty -> burst -> empty: forced rebuild, time step finite, no crash",
      "0 -> " + std::to_string(present) + " -> 0 particles, " + std::to_string(sim.counters().rebuilds) + " rebuilds");
}

TEST(Stability, S30_RadiiGrowingAndShrinkingDuringARun) {
  constexpr double k_r = 0.01;
  constexpr std::int64_t k_steps = 400;
  const CounterRng rng(3, 1, 0);
  std::vector<Grain> grains;
  for (int k = 0; k < 125; ++k) {
    const auto u = [&](int q) { return rng.uniform(static_cast<std::uint64_t>(6 * k + q)) - 0.5; };
    grains.push_back(
        {{(k % 5 + 0.2 * u(0)) * 2.6 * k_r, (k / 5 % 5 + 0.2 * u(1)) * 2.6 * k_r, (k / 25 + 0.2 * u(2)) * 2.6 * k_r},
         {4 * u(3), 4 * u(4), 4 * u(5)},
         k_r});
  }
  Scene s = open_scene({-2 * k_r, -2 * k_r, -2 * k_r}, {13 * k_r, 13 * k_r, 13 * k_r}, 1e-5);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  linear_law(s, 1e4, 0);
  add_grains(s, grains);
  s.max_overlap = 1;
  std::int64_t missed = 0, contacts = 0;
  for (const ListPolicy policy : {ListPolicy::local, ListPolicy::paper, ListPolicy::two_largest,
                                  ListPolicy::accumulated, ListPolicy::outer_inner, ListPolicy::velocity_profile}) {
    s.list.policy = policy;
    RunOptions o = options();
    o.audit = true;
    Simulation sim(s, o);
    breathe(sim, 0.5, k_steps);
    sim.run(k_steps);
    missed += sim.counters().missed_contacts;
    contacts += sim.counters().contacts;
    EXPECT_LT(sim.counters().rebuilds, k_steps / 2) << "the lists have lasted";
  }
  EXPECT_EQ(missed, 0);
  EXPECT_GT(contacts, 100);
  row("contact set = brute force in every step while radii change by 50 %",
      std::to_string(missed) + " missed over 6 policies, " + std::to_string(contacts) + " contacts at the end");
}

TEST(Stability, S31_MeshFasterThanTheParticlesMissesNothing) {
  std::string obj;
  for (int y = 0; y <= 4; ++y)
    for (int x = 0; x <= 4; ++x)
      obj += std::to_string(0.025 * x) + " " + std::to_string(0.025 * y) + " " + std::to_string(0.001 * ((x + y) % 2)) +
             "\n";
  std::string text;
  for (std::size_t at = 0; at < obj.size();) {
    const std::size_t end = obj.find('\n', at);
    text += "v " + obj.substr(at, end - at + 1);
    at = end + 1;
  }
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) {
      const int a = 5 * y + x + 1;
      text += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(a + 6) + "\nf " +
              std::to_string(a) + " " + std::to_string(a + 6) + " " + std::to_string(a + 5) + "\n";
    }
  const auto scene = [&](ListPolicy policy, double k) {
    Scene s = open_scene({0, 0, 0}, {0.1, 0.1, 0.1}, 1e-5);
    for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
    linear_restitution(s, 2e4, 0.7, 5700, 0.3);
    s.gravity = {0, 0, -9.81};
    WallSpec mesh;
    mesh.name = "tray";
    mesh.shape = WallShape::mesh;
    mesh.file = temporary("tray.obj", text);
    mesh.motion.velocity = {0, 0, 2};  // grains fall at rest; the tray meets them at 2 m/s
    mesh.motion.end = 0.02;
    s.walls = {mesh};
    Source q;
    q.kind = Source::Kind::random;
    q.region = {{0, 0, 0.01}, {0.1, 0.1, 0.06}};
    q.size.diameter = 0.008;
    q.number = 150;
    s.sources = {q};
    s.list.policy = policy;
    s.list.verlet_k = k;
    s.list.automatic = false;
    return s;
  };
  std::uint64_t hash = 0;
  std::int64_t missed = 0, contacts = 0;
  for (const auto& [policy, k] :
       {std::pair(ListPolicy::always, 0.0), {ListPolicy::local, 5000.0}, {ListPolicy::paper, 200.0}}) {
    RunOptions o = options();
    o.audit = true;
    Simulation sim(scene(policy, k), o);
    sim.run(2500);
    if (hash == 0) hash = sim.state_hash();
    EXPECT_EQ(hash, sim.state_hash());
    missed += sim.counters().missed_contacts;
    contacts += sim.counters().wall_contacts;
  }
  EXPECT_EQ(missed, 0);
  row("tray of 2 m/s through grains at rest: brute force finds no missed contact, one hash for K = 0, 200, 5000",
      "0 missed in 2500 steps, 1 hash, " + std::to_string(contacts) + " wall contacts at the end");
}

TEST(Stability, S36_OneKickedGrainInAQuietBedCostsFewRebuilds) {
  const double r = 0.01;
  Scene s = open_scene({0, 0, 0}, {0.5, 0.5, 0.5}, 1e-5);
  linear_law(s, 1e4, 50);
  std::vector<Grain> grains;
  for (int k = 0; k < 1000; ++k)
    grains.push_back({{0.02 + 0.0205 * (k % 10), 0.02 + 0.0205 * (k / 10 % 10), 0.02 + 0.0205 * (k / 100)}, {}, r});
  s.list.automatic = false;  // the number of rebuilds is asserted
  grains[555].v = {0.5, 0.1, -0.2};
  add_grains(s, grains);
  Simulation sim(s, options());
  sim.run(10);
  const auto before = sim.counters().rebuilds_skin;
  sim.run(1000);
  const auto rebuilds = sim.counters().rebuilds_skin - before;
  EXPECT_LE(rebuilds, 30);
  row("bed at rest, one grain kicked: at most 3 skin rebuilds per 100 steps",
      std::to_string(rebuilds) + " in 1000 steps");
}

TEST(Stability, S37_SameBitsForThreadsChunksPoliciesAndRestart) {
  const auto run = [](int threads, int chunk, ListPolicy policy, double k, std::int64_t stop) {
    Scene s = open_scene({0, 0, 0}, {0.1, 0.1, 0.2}, 1e-5);
    s.domain.boundary[0] = s.domain.boundary[1] = {Boundary::periodic, Boundary::periodic};
    s.domain.boundary[2] = {Boundary::wall, Boundary::wall};
    linear_restitution(s, 2e4, 0.7, 5700, 0.4);
    s.gravity = {1, 0, -9.81};
    s.sort_every = 400;
    Source q;
    q.kind = Source::Kind::random;
    q.region = {{0, 0, 0}, {0.1, 0.1, 0.2}};
    q.size.kind = SizeDistribution::Kind::uniform;
    q.size.min = 0.006;
    q.size.max = 0.012;
    q.number = 900;
    q.velocity_jitter = 0.5;
    s.sources = {q};
    s.list.policy = policy;
    s.list.verlet_k = k;
    s.list.automatic = false;
    RunOptions o;
    o.threads = threads;
    o.chunk = chunk;
    Simulation sim(s, o);
    sim.run(stop);
    CheckpointWriter out;
    sim.save(out);
    const std::string path = temporary("bits.tcp", "");
    out.commit(path);
    o.threads = 2;
    o.chunk = 0;
    Simulation rest(s, o, CheckpointReader(path));
    rest.run(1000 - stop);
    return rest.state_hash();
  };
  const auto one = run(1, 0, ListPolicy::local, 200, 500);
  int same = 0;
  const auto check = [&](std::uint64_t hash) { same += hash == one ? 1 : 0; };
  for (const int threads : {1, 2, 3, 8, 28}) check(run(threads, 64, ListPolicy::paper, 50, 333));
  for (const int chunk : {16, 97, 1024}) check(run(2, chunk, ListPolicy::always, 0, 10));
  for (const double k : {0.0, 1.0, 5000.0}) check(run(2, 0, ListPolicy::local, k, 999));
  check(run(2, 128, ListPolicy::uniform, 0, 401));
  EXPECT_EQ(same, 12);
  row("threads 1 ... 28, chunks, exact list policies, K 0 ... 5000, restart at five steps: one hash",
      std::to_string(same) + " of 12 equal (tests/determinism has the pairwise cover)");
}

TEST(Stability, S39_FlushToZeroAndOtherRoundingAreRefused) {
  int refused = 0;
  const unsigned modes[] = {0x8000, 0x0040, 0x2000, 0x4000, 0x6000};  // FTZ, DAZ, round down, up, to zero
  for (const unsigned mode : modes) {
    Scene s = open_scene({0, 0, 0}, {1, 1, 1}, 1e-5);
    linear_law(s, 1e3, 0);
    add_grains(s, {{{0.5, 0.5, 0.5}, {}, 0.01}});
    Simulation sim(s, options());
    const unsigned before = _mm_getcsr();
    _mm_setcsr(before | mode);
    const std::string text = refusal([&] { sim.run(2); });
    _mm_setcsr(before);
    EXPECT_NE(text.find("rounding mode"), std::string::npos) << mode;
    refused += text.empty() ? 0 : 1;
  }
  row("FTZ, DAZ, three rounding modes: refused with a message (-ffast-math: the build test forbids it)",
      std::to_string(refused) + " of 5 refused");
}

TEST(Stability, S40_CountersAndIndicesAre64Bits) {
  // Pairs, steps, ids, offsets into lists and history: 64 bits. Rows are 32 bits on purpose, capped at 2^30.
  static_assert(std::is_same_v<decltype(Counters::pairs), std::int64_t>);
  static_assert(std::is_same_v<decltype(Counters::steps), std::int64_t>);
  static_assert(std::is_same_v<std::remove_extent_t<decltype(PairList::end)>, std::int64_t>);
  static_assert(std::is_same_v<std::remove_extent_t<decltype(PairContacts::end)>, std::int64_t>);
  static_assert(std::is_same_v<std::remove_extent_t<decltype(SearchArgs::capacity)>, std::int64_t>);
  static_assert(std::is_same_v<ParticleId, std::int64_t>);
  static_assert(std::is_same_v<decltype(Scene::steps), std::int64_t>);
  static_assert(sizeof(decltype(Column<double>().size())) == 8);
  // a clock that has run for 3e9 steps goes on as before: same motion, time to the bit, epochs and events due
  const double dt = 1e-5;
  const auto run = [&](std::int64_t start, Vec3& x) {
    Scene s = open_scene({0, 0, 0}, {1, 1, 1}, dt);
    linear_law(s, 1e3, 0);
    add_grains(s, {{{0.5, 0.5, 0.5}, {0.3, 0, 0}, 0.01}, {{0.55, 0.5, 0.5}, {}, 0.01}});
    s.integrator = Integrator::leapfrog;
    Simulation sim(s, options());
    EngineAccess::world(sim).clock.step = start;
    sim.run(5000);
    x = sim.frame().x[0];
    EXPECT_EQ(sim.step(), start + 5000);
    EXPECT_EQ(sim.time(), static_cast<double>(start + 5000) * dt);
    return sim.counters().sort_epochs;
  };
  Vec3 a, b;
  const auto epochs = run(0, a), late = run(3000000000LL, b);
  EXPECT_EQ(epochs, late);
  EXPECT_EQ(a.x, b.x);
  row("64-bit pair, step and id counters (static_assert); a run from step 3e9 equals one from step 0",
      "same bits, " + std::to_string(late) + " epochs");
}

}  // namespace
}  // namespace talus::stability
