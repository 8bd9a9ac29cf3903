// The energy ledger: of one bouncing grain against closed forms, and its bits over threads, chunks, instruction sets.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <string>

#include "kernels/kernel_table.hpp"
#include "physics_support.hpp"

namespace talus::physics {
namespace {

std::array<double, 9> all(const Energies& e) {
  return {e.kinetic_translation + e.kinetic_rotation,
          e.potential,
          e.elastic,
          e.dissipated_damping,
          e.dissipated_friction,
          e.dissipated_background,
          e.wall_work,
          e.inserted,
          e.residual};
}

struct Ledger {
  double residual = 0;  ///< largest, over the energy at the start
  double first = 0;     ///< lost in the first bounce, over the kinetic energy of the impact
};

/// A grain falls by ten radii and bounces until 1.2 s, seven or eight times.
Ledger bounces(double e, double dt) {
  const double r = 0.005, g = 9.81, height = 10 * r;
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.2}, dt);
  linear_restitution(s, 1e5, e);
  s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
  s.gravity = {0, 0, -g};
  s.output.energies = true;
  add_grains(s, {{{0, 0, r + height}, {}, r}});
  Simulation sim(s, options());
  const double start = sphere_mass(s.materials[0].density, r) * g * height;
  Ledger l;
  for (double t = 0.01; t < 1.2; t += 0.01) {
    sim.run(std::llround(t / dt) - sim.step());
    const Energies q = sim.energies();
    l.residual = std::max(l.residual, std::fabs(q.residual) / start);
    if (l.first == 0 && q.dissipated_damping > 0 && q.elastic == 0) l.first = q.dissipated_damping / start;
  }
  return l;
}

TEST(PhysicsLedger, OfABouncingGrainClosesAndHoldsTheLossOfTheClosedForm) {
  for (const double e : {0.95, 0.8, 0.5}) {
    const Ledger coarse = bounces(e, 4e-6), fine = bounces(e, 2e-6);
    figure("bouncing grain, e " + std::to_string(e) + ", dt 4e-6: largest residual / start energy", coarse.residual);
    figure("bouncing grain, e " + std::to_string(e) + ", dt 2e-6: largest residual / start energy", fine.residual);
    figure("bouncing grain, e " + std::to_string(e) + ": loss of the first bounce / (1 - e^2) of the energy, less 1",
           fine.first / (1 - e * e) - 1);
    // midpoint rule over 25 and 50 steps per contact; the grain also gains m g delta on its way, 1e-3 of the energy
    EXPECT_LT(coarse.residual, 1e-3) << e;
    // what is left at 1e-5 depends on the phases of seven bounces
    EXPECT_LT(fine.residual, std::max(0.35 * coarse.residual, 1e-5)) << e;
    EXPECT_NEAR(fine.first, 1 - e * e, 5e-3) << e;
  }
}

TEST(PhysicsLedger, HasTheSameBitsForEveryNumberOfThreadsChunkAndInstructionSet) {
  Scene s = open_scene({0, 0, 0}, {0.06, 0.06, 0.2}, 1e-5);
  s.domain.boundary[2] = {Boundary::wall, Boundary::wall};
  linear_law(s, 2e3, 300, 1000, 150, 0.4);
  s.gravity = {0, 0, -9.81};
  s.local_damping = 0.05;
  s.output.energies = true;
  std::vector<Grain> grains;
  for (int k = 0; k < 1500; ++k) {
    const auto q = [k](int c) { return uniform(5, static_cast<std::uint64_t>(8 * k + c)) - 0.5; };
    grains.push_back({{0.004 + 0.0055 * (k % 10), 0.004 + 0.0055 * (k / 10 % 10), 0.004 + 0.006 * (k / 100)},
                      {q(0), q(1), q(2)},
                      0.0025 + 0.0004 * q(3)});
  }
  add_grains(s, grains);
  const auto ledger = [&](int threads, int chunk, Isa isa) {
    RunOptions o;
    o.threads = threads;
    o.chunk = chunk;
    o.isa = isa;
    Simulation sim(s, o);
    sim.run(3000);
    return all(sim.energies());
  };
  const auto reference = ledger(1, 4096, Isa::scalar);
  EXPECT_GT(reference[3], 0);  // the bed has lost energy to dashpots, friction and local damping
  EXPECT_GT(reference[4], 0);
  EXPECT_GT(reference[5], 0);
  for (const Isa isa : available_isas())
    for (const auto& [threads, chunk] : {std::pair{1, 64}, {2, 256}, {3, 1000}}) {
      const auto other = ledger(threads, chunk, isa);
      for (std::size_t k = 0; k < other.size(); ++k)
        EXPECT_EQ(std::bit_cast<std::uint64_t>(other[k]), std::bit_cast<std::uint64_t>(reference[k]))
            << isa_name(isa) << ", " << threads << " threads, chunk " << chunk << ", entry " << k << ": " << other[k]
            << " and " << reference[k];
    }
}

const FrameRequest k_all{.contacts = true, .coordination = true, .stress = true, .walls = true, .wall_loads = true};

TEST(PhysicsLedger, OfAGrainBetweenTwoPlatesIsTheirTwoSpringsHoweverOftenOneLooks) {
  // Each plate is pressed in by d: 2 * 1/2 k d^2 = 1e5 * (1.95e-4)^2 J.
  constexpr double r = 0.005, k = 1e5, d = 1.95e-4, elastic = 0.0038025;
  for (const bool look : {false, true}) {
    Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 4e-6);
    linear_restitution(s, k, 0.8);
    s.walls = {plane("floor", {0, 0, d - r}, {0, 0, 1}), plane("lid", {0, 0, r - d}, {0, 0, -1})};
    s.output.energies = true;
    s.allow_initial_overlap = true;
    add_grains(s, {{{}, {}, r}});
    Simulation sim(s, options());
    for (int n = 0; n < 60; ++n) {
      sim.run(1);
      if (look) {
        const Frame f = sim.frame(k_all);
        ASSERT_EQ(f.contacts.size(), 2U);
        EXPECT_NEAR(norm(f.contacts[0].normal_force), k * d, 1e-9 * k * d);
      }
      const Energies e = sim.energies();
      EXPECT_NEAR(e.elastic, elastic, 1e-12 * elastic) << n;
      EXPECT_NEAR(e.residual, 0, 1e-12 * elastic) << n;
    }
  }
}

/// A grain is pressed by d into the floor and into a second one that a lid holds; all are at rest but for what ends.
struct Pressed {
  static constexpr double r = 0.005, k = 1e5, d = 1.95e-4, spring = 0.5 * k * d * d;
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 1e-6);
  Pressed() {
    linear_restitution(s, k, 1);
    s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1}), plane("lid", {0, 0, 4 * r - 3 * d}, {0, 0, -1})};
    s.output.energies = true;
    s.allow_initial_overlap = true;
    add_grains(s, {{{0, 0, r - d}, {}, r}, {{0, 0, 3 * r - 2 * d}, {}, r}});
    s.groups.resize(1);
    s.groups[0].name = "both";
  }
  void event(Event::Action action, double time, std::array<std::int64_t, 2> ids = {0, 1}) {
    s.groups[0].ids = {ids[0], ids[1]};
    Event e;
    e.action = action;
    e.time = time;
    e.group = 0;
    s.events.push_back(e);
  }
  /// Energy brought in, and the largest residual until step 200, both over that of a spring.
  std::array<double, 2> run() {
    Simulation sim(s, options());
    double residual = 0;
    for (int n = 0; n < 200; ++n) {
      sim.run(1);
      residual = std::max(residual, std::fabs(sim.energies().residual) / spring);
    }
    return {sim.energies().inserted / spring, residual};
  }
};

// The springs of contacts that an event or a wall ends are taken out of the balance, those that it begins are put in.
TEST(PhysicsLedger, CountsTheSpringsOfContactsThatEventsAndWallsEndAndBegin) {
  constexpr double exact = 1e-9, moving = 1e-3;  // of a spring; of what moves (w dt)^2 = 3 k/m dt^2 = 2e-4
  {
    Pressed p;  // their contact is in no list while both are held, their walls go on
    p.event(Event::Action::freeze, 5e-5);
    const auto [in, residual] = p.run();
    EXPECT_NEAR(in, -3, exact) << "a held grain has no contact with a wall either";
    EXPECT_LT(residual, exact);
  }
  {
    Pressed p;
    p.event(Event::Action::freeze, 5e-5);
    p.event(Event::Action::release, 1e-4);
    const auto [in, residual] = p.run();
    EXPECT_NEAR(in, 0, exact);
    EXPECT_LT(residual, exact);
  }
  {
    Pressed p;
    p.event(Event::Action::remove, 5e-5);
    const auto [in, residual] = p.run();
    EXPECT_NEAR(in, -3, exact);
    EXPECT_LT(residual, exact);
  }
  {
    Pressed p;
    p.event(Event::Action::remove, 5e-5, {1, 1});
    const auto [in, residual] = p.run();
    EXPECT_NEAR(in, -2, exact);
    EXPECT_LT(residual, moving);
  }
  for (const bool appears : {false, true}) {
    Pressed p;
    (appears ? p.s.walls[1].appear : p.s.walls[1].vanish) = 5e-5;
    if (appears) p.s.walls[0].appear = 5e-5;
    const auto [in, residual] = p.run();
    if (!appears) {
      EXPECT_NEAR(in, -1, exact);
    }
    // a force that is there at once, of d k, at a speed of up to d w: half a step of it counts on one side
    const double w = std::sqrt(2 * Pressed::k / sphere_mass(2500, Pressed::r));
    EXPECT_LT(residual, appears ? w * p.s.dt : moving);
  }
}

// Grains that leave through an open side while they touch take along the springs of what they touch: of walls (floor
// and lid), of a grain that stays behind, and once only that of two grains which leave together.
TEST(PhysicsLedger, GrainsThatLeaveWhileTheyTouchTakeTheirSpringsAlong) {
  constexpr double exact = 1e-9, moving = 1e-3;
  const auto leave = [](Vec3 lower, Vec3 upper) {  // velocities [m/s]; the side is 1e-5 m away
    Pressed p;
    p.s.groups.clear();
    p.s.sources.clear();
    const double x = 0.1 - 1e-5, z = Pressed::r - Pressed::d;
    add_grains(p.s, {{{x, 0, z}, lower, Pressed::r}, {{x, 0, 3 * Pressed::r - 2 * Pressed::d}, upper, Pressed::r}});
    Simulation sim(p.s, options());
    double residual = 0;
    for (int n = 0; n < 60; ++n) {
      sim.run(1);
      residual = std::max(residual, std::fabs(sim.energies().residual) / Pressed::spring);
    }
    return std::pair{sim.particles(), residual};
  };
  const auto [none, together] = leave({0.5, 0, 0}, {0.5, 0, 0});
  EXPECT_EQ(none, 0);
  EXPECT_LT(together, exact);
  for (const bool first : {false, true}) {
    const auto [one, residual] = first ? leave({0.5, 0, 0}, {}) : leave({}, {0.5, 0, 0});
    EXPECT_EQ(one, 1);
    EXPECT_LT(residual, moving);
  }
}

TEST(PhysicsLedger, OfAnOedometerClosesHoweverOftenOneLooks) {
  // 4^3 grains in a box of their own width, pressed together by 3 % from above.
  constexpr double r = 0.005, side = 8 * r;
  std::array<std::array<double, 9>, 2> ledgers{};
  for (const bool look : {false, true}) {
    Scene s = open_scene({0, 0, 0}, {side, side, 1.2 * side}, 4e-6);
    for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
    linear_law(s, 1e5, 300, 3e4, 150, 0.4);
    WallSpec lid = plane("lid", {0, 0, side}, {0, 0, -1});
    lid.motion.velocity = {0, 0, -0.06};
    s.walls = {lid};
    s.output.energies = true;
    std::vector<Grain> grains;
    for (int k = 0; k < 64; ++k)
      grains.push_back(
          {{r * (1 + 2 * (k % 4)), r * (1 + 2 * (k / 4 % 4)), r * (1 + 2 * (k / 16))}, {}, r * (1 - 1e-4)});
    add_grains(s, grains);
    Simulation sim(s, options());
    for (int n = 0; n < 5000; n += 25) {
      sim.run(25);
      if (look) sim.frame(k_all);
    }
    const Energies e = sim.energies();
    EXPECT_GT(e.elastic, 0.1 * e.wall_work);
    EXPECT_LT(std::fabs(e.residual), 1e-3 * e.wall_work);
    figure(std::string("oedometer, ") + (look ? "with" : "without") + " frames: residual / work of the lid",
           e.residual / e.wall_work);
    ledgers[look ? 1 : 0] = all(e);
  }
  for (std::size_t k = 0; k < ledgers[0].size(); ++k)
    EXPECT_EQ(std::bit_cast<std::uint64_t>(ledgers[1][k]), std::bit_cast<std::uint64_t>(ledgers[0][k])) << k;
}

/// Two grains that overlap, one of them the floor too, with velocities and spins; k_t > 0.
Scene pressed(double dt) {
  const double r = 0.005;
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.2}, dt);
  linear_law(s, 1e5, 0, 3e4, 0, 0.5);
  s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
  s.gravity = {0, 0, -9.81};
  s.output.energies = s.allow_initial_overlap = true;
  add_grains(s, {{{0, 0, 0.98 * r}, {0.1, 0, 0.3}, r, {0, 50, 0}}, {{0, 0, 2.95 * r}, {0, 0.2, -0.2}, r}});
  return s;
}

TEST(PhysicsLedger, RowZeroHoldsTheEnergiesOfTheGivenState) {
  const double r = 0.005, m = sphere_mass(2500, r);
  Simulation sim(pressed(1e-6), options());
  const Energies e = sim.energies();
  EXPECT_NEAR(e.kinetic_translation / (0.5 * m * (0.1 * 0.1 + 0.3 * 0.3 + 2 * 0.2 * 0.2)), 1, 1e-12);
  EXPECT_NEAR(e.kinetic_rotation / (0.2 * m * r * r * 50 * 50), 1, 1e-12);
  EXPECT_NEAR(e.potential / (m * 9.81 * (0.98 + 2.95) * r), 1, 1e-12);
  EXPECT_NEAR(e.elastic / (0.5 * 1e5 * r * r * (0.02 * 0.02 + 0.03 * 0.03)), 1, 1e-3);  // and a step's tangential way
  EXPECT_EQ(e.dissipated_damping + e.dissipated_friction + e.dissipated_background + e.wall_work + e.inserted, 0);
  EXPECT_EQ(e.residual, 0);
  const std::uint64_t hash = sim.state_hash();
  sim.run(1);                                             // its row holds the state of step 0 as well
  const auto first = all(sim.energies()), zero = all(e);  // in another order of the rows
  for (std::size_t k = 0; k < zero.size(); ++k)
    EXPECT_NEAR(first[k], zero[k], 1e-15 * std::fabs(zero[0] + zero[2])) << k;
  Simulation unasked(pressed(1e-6), options());
  EXPECT_EQ(unasked.state_hash(), hash);
  unasked.run(50);
  sim.run(49);
  EXPECT_EQ(unasked.state_hash(), sim.state_hash());
}

TEST(PhysicsLedger, AResumedRunHoldsTheRowsOfTheUninterruptedOne) {
  const std::string path = testing::TempDir() + "ledger-" + std::to_string(getpid()) + ".checkpoint";
  for (const std::int64_t stop : {0, 1, 37}) {
    Simulation whole(pressed(1e-6), options());
    if (stop > 0) whole.run(stop);
    CheckpointWriter out;
    whole.save(out);
    out.commit(path);
    Simulation resumed(pressed(1e-6), options(), CheckpointReader(path));
    for (int n = 0; n < 3; ++n) {
      const auto a = all(whole.energies()), b = all(resumed.energies());
      for (std::size_t k = 0; k < a.size(); ++k)
        EXPECT_EQ(std::bit_cast<std::uint64_t>(a[k]), std::bit_cast<std::uint64_t>(b[k]))
            << stop << " " << n << " " << k;
      whole.run(1);
      resumed.run(1);
    }
  }
  std::remove(path.c_str());
}

TEST(PhysicsLedger, ResidualOfAStackStartsFromItsTrueEnergy) {
  // 20 steps per contact; without dashpots the balance must close but for the leapfrog's (omega dt)^2/8 and friction
  const double contact = k_pi * std::sqrt(0.5 * sphere_mass(2500, 0.005) / 1e5);
  const auto largest = [&](int per_contact) {
    Scene s = pressed(contact / per_contact);
    s.contact.friction = false;
    Simulation sim(s, options());
    const double start = sim.energies().kinetic_translation + sim.energies().elastic;
    double residual = 0;
    for (int n = 0; n < 40 * per_contact; ++n) {
      sim.run(1);
      residual = std::max(residual, std::fabs(sim.energies().residual) / start);
    }
    return residual;
  };
  const double coarse = largest(20), fine = largest(40);
  figure("stack, 20 steps per contact: largest residual / start energy", coarse);
  figure("stack, 40 steps per contact: largest residual / start energy", fine);
  EXPECT_LT(coarse, 0.02);
  EXPECT_LT(fine, 0.3 * coarse);  // second order: no offset is left
}

TEST(PhysicsLedger, ClosesOverEventsInsertionAndRemovalInFreeFlight) {
  const double dt = 1e-4;
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  linear_law(s, 1e3, 0);
  s.gravity = {0.3, 0, -9.81};
  s.output.energies = true;
  s.groups.resize(1);
  s.groups[0].name = "one";
  s.groups[0].ids = {{0, 0}};
  add_grains(s, {{{0, 0, 0}, {0.2, 0, 1}, 0.005}, {{0.3, 0, -0.8}, {0, 0, -2}, 0.005}});
  const auto event = [&](Event::Action action, double time, Vec3 vector) {
    Event e;
    e.action = action;
    e.time = time;
    e.group = action == Event::Action::gravity ? -1 : 0;
    e.vector = vector;
    s.events.push_back(e);
  };
  event(Event::Action::set_velocity, 0, {0, 0.5, 2});
  event(Event::Action::set_velocity, 0.05, {1, 1, 3});
  event(Event::Action::gravity, 0.08, {0, 2, -5});
  event(Event::Action::freeze, 0.12, {});
  event(Event::Action::release, 0.15, {});
  Source q;
  q.kind = Source::Kind::random;
  q.name = "late";
  q.number = 5;
  q.start = 0.06;
  q.region = {{-0.5, -0.5, 0.5}, {0.5, 0.5, 0.9}};
  q.size.diameter = 0.01;
  q.velocity = {0, 0, -1};
  s.sources.push_back(q);
  Simulation sim(s, options());
  const double scale = 7 * sphere_mass(2500, 0.005) * 10;
  double residual = 0;
  std::int64_t least = 7;
  for (int n = 0; n < 3000; ++n) {
    sim.run(1);
    residual = std::max(residual, std::fabs(sim.energies().residual) / scale);
    if (n > 700) least = std::min(least, sim.particles());
  }
  EXPECT_LT(least, 7);  // some have left through the open floor
  EXPECT_LT(residual, 1e-12);
}

}  // namespace
}  // namespace talus::physics
