// Scenarios 8 to 17: overlapping and coincident starts, fast grains, restitution and friction at their ends.
#include <fmt/format.h>

#include <cmath>

#include "core/rules/adhesion.hpp"
#include "core/rules/restitution.hpp"
#include "core/scene/scene_file.hpp"
#include "tests/physics/kernel_contact.hpp"
#include "tests/stability/stability_support.hpp"

namespace talus::stability {
namespace {

constexpr double k_r = 0.01;

/// Two grains of radius k_r whose surfaces overlap by `share` of the radius.
Scene pair_scene(double share, double dt = 1e-5) {
  Scene s = open_scene({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, dt);
  linear_law(s, 1e4, 0);
  add_grains(s, {{{0, 0, 0}, {}, k_r}, {{(2 - share) * k_r, 0, 0}, {}, k_r}});
  return s;
}

/// Dense random points: `n` grains with overlaps of up to a radius and more, in a box of walls.
Scene crowd(int n, std::int64_t relax, double share = 0.02) {
  const double side = 2 * k_r * std::cbrt(n * 0.5236 / 0.45);
  Scene s = open_scene({0, 0, 0}, {side, side, side}, 1e-5);
  for (auto& axis : s.domain.boundary) axis = {Boundary::wall, Boundary::wall};
  linear_law(s, 1e4, 100, 3e3, 50, 0.4);
  s.relax = {relax, share};
  std::vector<Grain> grains;
  for (int k = 0; k < n; ++k) {
    const auto q = [&](int c) { return k_r + (side - 2 * k_r) * uniform(3, static_cast<std::uint64_t>(4 * k + c)); };
    grains.push_back({{q(0), q(1), q(2)}, {}, k_r * (0.8 + 0.4 * uniform(5, static_cast<std::uint64_t>(k)))});
  }
  add_grains(s, grains);
  return s;
}

double deepest(Simulation& sim) {
  double top = 0;
  for (const ContactRecord& c : sim.frame({.contacts = true}).contacts) top = std::max(top, c.overlap);
  return top;
}

double fastest(const Frame& f) {
  double top = 0;
  for (const Vec3& v : f.v) top = std::max(top, norm(v));
  return top;
}

TEST(Stability, S08_HalfOverlapIsRefusedBoundedOrRelaxed) {
  // 1. default: an error that lists the pair and the cures
  const std::string text = refusal([] { Simulation(pair_scene(0.5), options()); });
  EXPECT_NE(text.find("initial overlap"), std::string::npos) << text;
  EXPECT_NE(text.find("relax.steps"), std::string::npos) << text;
  // 2. allowed: no more speed than the springs held
  Scene s = pair_scene(0.5);
  s.allow_initial_overlap = true;
  s.max_overlap = 0.6;
  Simulation blast(s, options());
  blast.run(2000);
  const double m = sphere_mass(2500, k_r), energy = 0.5 * 1e4 * std::pow(0.5 * k_r, 2);
  const double v_max = fastest(blast.frame()), bound = std::sqrt(2 * energy / m);
  EXPECT_LE(v_max, bound * (1 + 1e-6));
  EXPECT_GT(v_max, 0.5 * bound);  // the control: without a cure it is a blast
  // 3. relaxed: no speed at all
  Scene cured = pair_scene(0.5);
  cured.relax = {400, 0.02};
  Simulation calm(cured, options());
  calm.run(2000);
  EXPECT_LT(fastest(calm.frame()), 1e-3 * bound);
  EXPECT_LT(deepest(calm), 1e-3 * k_r);
  // 4. a crowd of 500 grains with overlaps beyond a radius becomes a bed that runs on
  Simulation packed(crowd(500, 3000), options());
  packed.run(1);
  const double before = deepest(packed) / k_r;
  packed.run(2999);
  const double after = deepest(packed) / k_r;
  packed.run(2000);
  EXPECT_GT(before, 1.0);
  EXPECT_LT(after, 0.1);
  const double v_left = fastest(packed.frame());
  EXPECT_LT(v_left, 0.05 * bound);
  row("default: error that lists the pairs; allowed: v <= sqrt(2 E/m); [relax]: no blast",
      "v/bound " + fmt_ratio(v_max / bound) + " allowed, " + sci(fastest(calm.frame()) / bound) +
          " relaxed; crowd: overlap " + sci(before) + " R -> " + sci(after) + " R");
}

TEST(Stability, S08_RelaxationIsTheSameForEveryThreadChunkPolicyAndResume) {
  const auto hash = [](int threads, int chunk, ListPolicy policy, bool resume) {
    Scene s = crowd(400, 300);
    s.list.policy = policy;
    RunOptions o;
    o.threads = threads;
    o.chunk = chunk;
    Simulation sim(s, o);
    if (!resume) {
      sim.run(600);
      return sim.state_hash();
    }
    sim.run(123);
    CheckpointWriter out;
    sim.save(out);
    const std::string path = temporary("relax.tcp", "");
    out.commit(path);
    const CheckpointReader in(path);
    Simulation rest(s, o, in);
    rest.run(600 - 123);
    return rest.state_hash();
  };
  const auto one = hash(1, 0, ListPolicy::local, false);
  EXPECT_EQ(one, hash(3, 64, ListPolicy::local, false));
  EXPECT_EQ(one, hash(2, 97, ListPolicy::always, false));
  EXPECT_EQ(one, hash(1, 64, ListPolicy::paper, true));
  row("relaxing 400 overlapping grains: same bits for threads, chunks, policies and resume", "1 hash");
}

TEST(Stability, S09_CoincidentCentresAreRefusedNearlyCoincidentOnesPart) {
  for (const double other : {k_r, 0.4 * k_r})
    for (const std::int64_t relax : {0, 100}) {
      Scene s = open_scene({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 1e-5);
      linear_law(s, 1e4, 0);
      s.allow_initial_overlap = true;
      s.max_overlap = 1;
      s.relax.steps = relax;
      add_grains(s, {{{0, 0, 0}, {}, k_r}, {{0, 0, 0}, {}, other}});
      const std::string text = refusal([&] { Simulation(s, options()); });
      EXPECT_NE(text.find(relax > 0 ? "coincident" : "overlap"), std::string::npos) << text;
    }
  // next to each other by one part in 1e9: finite, momentum kept, the same on every number of threads
  const auto run = [](int threads) {
    Scene s = open_scene({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 1e-5);
    linear_law(s, 1e4, 0);
    s.relax = {500, 0.02};
    add_grains(s, {{{0, 0, 0}, {}, k_r},
                   {{1e-9 * k_r, 0, 0}, {}, k_r},
                   {{0.2, 0, 0}, {}, k_r},
                   {{0.2, 0, 1e-11}, {}, 0.5 * k_r}});
    RunOptions o;
    o.threads = threads;
    o.chunk = 2;
    auto sim = std::make_unique<Simulation>(s, o);
    sim->run(800);
    return sim;
  };
  const auto one = run(1), four = run(4);
  EXPECT_EQ(one->state_hash(), four->state_hash());
  const Frame f = one->frame();
  double gap = norm(f.x[0] - f.x[1]) / (2 * k_r);
  EXPECT_GT(gap, 0.999);
  EXPECT_LT(gap, 1.05);
  EXPECT_GT(norm(f.x[2] - f.x[3]), 1.499 * k_r);
  const Vec3 p = f.v[0] + f.v[1];
  EXPECT_LT(norm(p), 1e-12);
  row("coincident: refused by name, also with [relax]; 1e-9 R apart: part, momentum kept, same bits on 1 and 4 threads",
      "gap after " + fmt_ratio(gap) + " d, |p|/m " + sci(norm(p)));
}

TEST(Stability, S10_HypervelocityIsStoppedBeforeItCanPassAPlane) {
  const double dt = 1e-5;
  const auto shot = [&](double travel, int phase, double max_travel) {
    Scene s = open_scene({-1, -1, -0.5}, {1, 1, 0.5}, dt);
    linear_law(s, 5e7, 0);         // omega dt = 0.7
    s.allow_unstable_step = true;  // above the limit of packings; here is one contact
    s.monitor.max_travel = max_travel;
    s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
    add_grains(s, {{{0, 0, k_r * (3 + 0.05 * phase)}, {0, 0, -travel * k_r / dt}, k_r}});
    return s;
  };
  const std::string text = refusal([&] { Simulation(shot(2.5, 0, 1), options()).run(10); });
  EXPECT_NE(text.find("particle 0 moves 2.5 of its radius"), std::string::npos) << text;
  EXPECT_NE(text.find("time.step of at most"), std::string::npos) << text;
  // Up to one radius per step the floor is seen in time: the grain rebounds or the run stops, whatever the phase.
  int bounced = 0, stopped = 0, through = 0, through_unguarded = 0;
  for (const double travel : {0.05, 0.2, 0.3, 0.5, 0.9, 0.99})
    for (int phase = 0; phase < 40; ++phase) {
      Simulation sim(shot(travel, phase, 1), options());
      const bool refused = !refusal([&] { sim.run(static_cast<std::int64_t>(12 / travel)); }).empty();
      stopped += refused ? 1 : 0;
      if (!refused) ++(sim.frame().x[0].z > 0 ? bounced : through);
    }
  for (int phase = 0; phase < 40; ++phase) {  // the control: faster and unguarded, some pass unseen
    Simulation sim(shot(2.5, phase, 1e9), options());
    if (refusal([&] { sim.run(6); }).empty() && sim.frame().x[0].z < 0) ++through_unguarded;
  }
  EXPECT_EQ(through, 0);
  EXPECT_GT(bounced, 40);
  EXPECT_GT(through_unguarded, 0);
  row("v dt > R refused at the first step by name; at <= 0.99 R every crossing is seen",
      std::to_string(bounced) + " bounced, " + std::to_string(stopped) + " stopped, " + std::to_string(through) +
          " through; unguarded at 2.5 R: " + std::to_string(through_unguarded) + " of 40 through");
}

TEST(Monitor, TheGrainWhoseContactsAreTooStiffForTheStepIsNamed) {
  for (const double level : {1e-6, 1.0}) {
    Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, 1e-5);
    linear_law(s, 1e3, 0);
    const double d = 1.999 * k_r;
    add_grains(s, {{{-d, 0, 0}, {}, k_r}, {{0, 0, 0}, {}, k_r}, {{d, 0, 0}, {}, k_r}});
    s.monitor.warn_stiffness = level;
    Simulation sim(s, options());
    sim.run(3);
    const double mass = 4.0 / 3 * 3.14159265358979 * k_r * k_r * k_r * s.materials[0].density;
    const std::string said = "the contacts of particle 1 together are so stiff that step^2 k/m = " +
                             fmt::format("{:.3g}", 2 * 1e3 / mass * 1e-10);
    int warned = 0;
    for (const Warning& w : sim.warnings()) {
      if (w.kind != "stiffness") continue;
      ++warned;
      EXPECT_NE(w.text.find(said), std::string::npos) << w.text;
    }
    EXPECT_EQ(warned, level < 1e-3 ? 1 : 0);
  }
}

TEST(Stability, S11_FastPairsAreFlaggedAndNotMissedAtATenthOfTheStep) {
  const auto shot = [](double travel, int phase, std::int64_t& flagged) {
    const double dt = 1e-5 * travel / 0.9, v = travel * k_r / dt, b = 1.9 * k_r;
    Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
    linear_law(s, 1e3, 0);
    const double x = (6 + 0.045 * phase) * k_r;
    add_grains(s, {{{-x, 0, 0}, {v, 0, 0}, k_r}, {{x, b, 0}, {-v, 0, 0}, k_r}});
    Simulation sim(s, options());
    sim.run(std::llround(15 / travel));
    for (const Warning& w : sim.warnings())
      if (w.kind == "travel") flagged += w.count;
    return sim.frame().v[0].y != 0;  // something was felt
  };
  std::int64_t flagged = 0, quiet = 0;
  int seen = 0, seen_fine = 0;
  for (int phase = 0; phase < 40; ++phase) {
    seen += shot(0.9, phase, flagged) ? 1 : 0;
    seen_fine += shot(0.09, phase, quiet) ? 1 : 0;
  }
  EXPECT_GT(flagged, 0);
  EXPECT_LT(seen, 40);  // the control: this is what the flag is for
  EXPECT_EQ(seen_fine, 40);
  EXPECT_EQ(quiet, 0);
  row("relative travel 1.8 R per step is counted as warning; no grazing contact is missed at dt/10",
      "flagged " + std::to_string(flagged) + ", missed " + std::to_string(40 - seen) + " of 40 at dt, " +
          std::to_string(40 - seen_fine) + " at dt/10");
}

constexpr double k_head_on = 1e4;  // stiffness [N/m] of the linear law in head_on()

/// Two equal grains, about to meet at `v` [m/s] each; Young's modulus `young` [Pa] for Hertz.
Scene head_on(bool hertz, double e, double v, double dt, double young) {
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  s.materials[0].young = young;
  s.materials[0].poisson = 0.3;
  if (hertz)
    hertz_law(s, e, 0);
  else
    linear_restitution(s, k_head_on, e);
  add_grains(s, {{{-1.0001 * k_r, 0, 0}, {v, 0, 0}, k_r}, {{1.0001 * k_r, 0, 0}, {-v, 0, 0}, k_r}});
  return s;
}

TEST(Stability, S12_RestitutionFromOneHundredthToOne) {
  const auto measured = [](bool hertz, double e) {
    const double v = 0.5, contact = k_pi * std::sqrt(sphere_mass(2500, k_r) / (2 * k_head_on));
    const Scene s = head_on(hertz, e, v, (hertz ? 0.4 : 1.0) * contact / 2000, 1e8);
    Simulation sim(s, options());
    sim.run(40000);
    const Frame f = sim.frame();
    return (f.v[1].x - f.v[0].x) / (2 * v);
  };
  double worst = 0;
  std::string worst_at;
  for (const bool hertz : {false, true})
    for (const double e : {0.01, 0.1, 0.5, 0.9, 1.0}) {
      const double error = std::fabs(measured(hertz, e) - e);
      EXPECT_LT(error, 1e-3) << (hertz ? "hertz " : "linear ") << e;
      if (error > worst) {
        worst = error;
        worst_at = std::string(hertz ? "Hertz" : "linear") + " e " + fmt_ratio(e);
      }
    }
  // e = 1: collisions between two walls. Leapfrog alone would change the speed in each by up to (omega dt)^2/8 = 5e-6,
  // either way. With the first and last step counted from touch to parting the speed stays, over hundreds of
  // collisions.
  const double k = 1e4, dt = k_pi * std::sqrt(sphere_mass(2500, k_r) / k) / 500.3;
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
  linear_restitution(s, k, 1);
  s.walls = {plane("floor", {0, 0, -0.02}, {0, 0, 1}), plane("lid", {0, 0, 0.02}, {0, 0, -1})};
  add_grains(s, {{{0, 0, 0}, {0, 0, 1}, k_r}});
  Simulation sim(s, options());
  double departure[2] = {}, sign = 1;  // from the speed, behind the first 20 of 400 collisions and behind all
  for (int seen = 0; seen < 400;) {
    sim.run(20);
    const double v = sim.frame().v[0].z;
    if (v * sign >= 0 || sim.counters().wall_contacts > 0) continue;
    sign = v;
    ++seen;
    departure[1] = std::max(departure[1], std::fabs(std::fabs(v) - 1));
    if (seen <= 20) departure[0] = departure[1];
  }
  EXPECT_LT(departure[0], 1e-9);
  EXPECT_LT(departure[1], 2e-8);
  // e = 0 has no finite damping: the scene is refused
  const std::string zero = refusal([] {
    parse_scene(
        "[domain]\nlower=[0,0,0]\nupper=[1,1,1]\n[time]\nstep=1e-5\nsteps=1\n[[material]]\nname=\"a\"\n"
        "density=1\n[contact]\nnormal_stiffness=1e3\nrestitution=0\n",
        "t.toml", ".", {});
  });
  EXPECT_NE(zero.find("restitution"), std::string::npos) << zero;
  row("measured e within 1e-3 for 0.01 ... 1, LSD and Hertz; e = 0 refused; e = 1: departure of the speed over 400 "
      "collisions at 500 steps each",
      "worst " + sci(worst) + " (" + worst_at + "), " + sci(departure[0]) + " after 20, " + sci(departure[1]) +
          " after 400");
}

TEST(Stability, S13_TensileTailOfTheDashpotCanBeClipped) {
  // The force is that which changes the velocity: a clipped impact never slows the parting grains down.
  struct Impact {
    double restitution = 0, pull = 0, residual = 0;  // largest loss of speed in one step / v; energy / initial energy
  };
  const auto impact = [](bool hertz, double e, bool clip) {
    const double v = hertz ? 0.1 : 1, contact = k_pi * std::sqrt(sphere_mass(2500, k_r) / (2 * k_head_on));
    Scene s = head_on(hertz, e, v, hertz ? 2e-6 : contact / 400.37, 1e7);
    s.contact.clip_tension = clip;
    s.output.energies = true;
    Simulation sim(s, options());
    sim.run(1);
    const double start = total_energy(sim.energies());
    Impact r;
    double before = v;
    bool touched = false;
    for (int step = 0; step < 40000; ++step) {
      sim.run(1);
      const Frame f = sim.frame();
      const double speed = f.v[0].x;
      r.pull = std::max(r.pull, (speed - before) / v);
      before = speed;
      touched = touched || sim.counters().contacts > 0;
      if (touched && sim.counters().contacts == 0) break;
    }
    const Frame f = sim.frame();
    r.restitution = (f.v[1].x - f.v[0].x) / (2 * v);
    r.residual = std::fabs(sim.energies().residual) / start;
    return r;
  };
  double worst = 0, pull = 0, residual = 0, usual = 1;
  for (const bool hertz : {false, true})
    for (const double e : {0.1, 0.3, 0.5, 0.7, 0.9, 0.99}) {
      const Impact clipped = impact(hertz, e, true), plain = impact(hertz, e, false);
      EXPECT_LT(std::fabs(clipped.restitution - e), 1e-3) << (hertz ? "hertz " : "linear ") << e;
      EXPECT_LT(clipped.residual, 2e-3) << (hertz ? "hertz " : "linear ") << e;
      worst = std::max(worst, std::fabs(clipped.restitution - e));
      pull = std::max(pull, clipped.pull);
      residual = std::max(residual, clipped.residual);
      usual = std::min(usual, plain.pull);
    }
  EXPECT_LE(pull, 0);
  EXPECT_GT(usual, 1e-6) << "the plain dashpot must pull, or there is nothing to clip";
  // closed form of Schwager & Poeschel (2007): e = exp(-2 z acos(z) / sqrt(1 - z^2)) with z = c / 2
  for (const double z : {0.05, 0.3, 0.6, 0.9})
    EXPECT_NEAR(clipped_restitution(2 * z, DampedSpring::linear),
                std::exp(-2 * z * std::acos(z) / std::sqrt(1 - z * z)), 1e-6);
  for (const DampedSpring spring : {DampedSpring::linear, DampedSpring::hertz})
    for (const double e : {1e-9, 1e-6, 1e-3, 0.05, 0.6, 0.999, 1.0})
      EXPECT_NEAR(clipped_restitution(damping_coefficient(e, spring, true), spring), e, 2e-6) << e;
  const std::string refused = refusal([] {
    parse_scene(
        "[domain]\nlower=[0,0,0]\nupper=[1,1,1]\n[time]\nstep=1e-5\nsteps=1\n[[material]]\nname=\"a\"\n"
        "density=1\n[contact]\nnormal_stiffness=1e3\nrestitution=0.5\nclip_tension=true\ncohesion=\"sjkr\"\n"
        "cohesion_energy=1e3\n",
        "t.toml", ".", {});
  });
  EXPECT_NE(refused.find("clip_tension"), std::string::npos) << refused;
  row("F_n >= 0 with clip_tension, restitution 0.1 ... 0.99 met, LSD and Hertz; refused beside cohesion",
      "largest pull " + sci(pull) + ", error of e " + sci(worst) + ", energy within " + sci(residual));
}

TEST(Stability, S14_FrictionZeroKeepsSpinAndFrictionTenCreatesNoEnergy) {
  const auto impact = [](bool hertz, double mu, double angle, double& before, Frame& out) {
    const double v = 1, dt = 1e-6;
    Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, dt);
    s.materials[0].young = 1e7;
    s.materials[0].poisson = 0.3;
    if (hertz)
      hertz_law(s, 0.9, mu);
    else
      linear_restitution(s, 1e4, 0.9, mu > 0 ? 2857 : 0, mu);
    s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
    Grain g{{-0.5, 0, 1.001 * k_r}, {v * std::sin(angle), 0, -v * std::cos(angle)}, k_r};
    g.w = {0, 3, 5};
    add_grains(s, {g});
    Simulation sim(s, options());
    const auto energy = [](const Frame& f) {
      return 0.5 * norm2(f.v[0]) + (f.w.empty() ? 0 : 0.2 * k_r * k_r * norm2(f.w[0]));
    };
    before = energy(sim.frame());
    sim.run(static_cast<std::int64_t>(0.006 / dt / std::max(0.05, std::cos(angle))));
    out = sim.frame();
    return energy(out);
  };
  double gain = -1, before = 0;
  Frame f;
  for (const bool hertz : {false, true})
    for (const double degrees : {1.0, 30.0, 60.0, 80.0, 88.0, 89.5}) {
      const double after = impact(hertz, 10, degrees * k_pi / 180, before, f);
      gain = std::max(gain, after / before - 1);
    }
  EXPECT_LE(gain, 1e-12);
  // without friction rotation is not even integrated; with mu tiny in one pair it is, and the spin must not change
  impact(false, 0, 0.5, before, f);
  EXPECT_TRUE(f.w.empty());
  Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, 1e-5);
  s.materials = {{"a", 2500, 0, 0}, {"b", 2500, 0, 0}};
  s.pairs.assign(4, {});
  linear_restitution(s, 1e4, 0.9, 2857, 0);
  s.pairs[3].friction = 1;
  s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
  Grain g{{0, 0, 1.001 * k_r}, {1, 0, -1}, k_r};
  g.w = {1, 2, 3};
  add_grains(s, {g});
  Simulation sim(s, options());
  sim.run(3000);
  const Vec3 w = sim.frame().w[0];
  EXPECT_GT(sim.frame().v[0].z, 0.8);
  EXPECT_LT(norm(w - Vec3{1, 2, 3}), 1e-14);
  row("mu = 0: spin unchanged; mu = 10, 1 to 89.5 degrees, LSD and Hertz: energy never grows (<= 1e-12 E)",
      "largest change " + sci(gain) + " E, spin " + sci(norm(w - Vec3{1, 2, 3})));
}

TEST(Stability, S15_ClosedLoopsOfUnloadingAndReloadingNeverYieldWork) {
  double lowest = 0;
  for (const bool hertz : {false, true})
    for (const double mu : {0.2, 100.0})
      for (const bool mirrored : {false, true}) {
        Scene s = open_scene({0, 0, 0}, {1, 1, 1}, 1e-6);
        s.materials[0].young = 1e8;
        s.materials[0].poisson = 0.3;
        if (hertz)
          hertz_law(s, 1, mu);
        else
          linear_law(s, 1e5, 0, 3e4, 0, mu);
        KernelContact contact(s, k_r, k_r, 2 / sphere_mass(2500, k_r));
        const double high = 2e-3 * k_r, low = 0.5e-3 * k_r, shear = 0.5e-3 * k_r;
        const double path[][2] = {{mirrored ? low : high, 0},
                                  {mirrored ? low : high, shear},
                                  {mirrored ? high : low, shear},
                                  {mirrored ? high : low, 0},
                                  {mirrored ? low : high, 0}};
        double depth = 0, slide = 0, work = 0, stored = 0;
        Vec3 force{}, x{2 * k_r, 0, 0};
        const auto go = [&](double to_depth, double to_slide) {
          const int steps = 2000;
          const double d0 = depth, s0 = slide;
          for (int k = 1; k <= steps; ++k) {
            depth = d0 + (to_depth - d0) * k / steps;
            slide = s0 + (to_slide - s0) * k / steps;
            // keeps the distance exact while the contact point slides
            const double d = 2 * k_r - depth;
            const Vec3 now{std::sqrt(d * d - slide * slide), slide, 0};
            const auto r = contact.step(now, (1 / s.dt) * (now - x), {0, 0, 0});
            work -= dot(0.5 * (force + r.force), now - x);
            force = r.force;
            x = now;
            stored = std::max(stored, r.elastic);
          }
        };
        go(path[0][0], path[0][1]);
        for (int loop = 0; loop < 3; ++loop) {
          const double start = work;
          for (const auto& corner : path) go(corner[0], corner[1]);
          lowest = std::min(lowest, (work - start) / stored);
        }
      }
  EXPECT_GT(lowest, -1e-6);  // trapezoidal work at 2000 steps per side
  row("work done on the contact around closed loops >= 0 (Hertz-Mindlin and linear, both directions)",
      "least " + sci(lowest) + " of the stored energy");
}

/// A grain on a floor whose slope is in the gravity vector, pressed by 2e-5 of its radius.
Scene slope(Rolling kind) {
  const double m = sphere_mass(2500, k_r), g = 9.81, angle = 0.08, load = m * g * std::cos(angle);
  Scene s = open_scene({0, 0, 0}, {1, 0.1, 0.1}, 5e-6);
  s.domain.boundary[2] = {Boundary::wall, Boundary::open};
  s.gravity = {g * std::sin(angle), 0, -g * std::cos(angle)};
  linear_law(s, load / (2e-5 * k_r), 800, 2.0 / 7.0 * load / (2e-5 * k_r), 400, 0.8);
  s.contact.rolling = kind;
  s.pairs[0].rolling_friction = 0.1;  // tan(0.08) < 0.1: it has to stay
  s.pairs[0].rolling_damping = kind == Rolling::epsd ? 0.3 : 0;
  add_grains(s, {{{0.5, 0.05, k_r * (1 - 2e-5)}, {}, k_r}});
  return s;
}

TEST(Stability, S16_RollingResistanceAtRestOnAnIncline) {
  const int steps = full() ? 1000000 : 200000;
  Simulation spring(slope(Rolling::epsd), options());
  spring.run(40000);  // the spring winds up, its oscillation dies out
  const Vec3 from = spring.frame().x[0];
  spring.run(steps);
  const double moved = norm(spring.frame().x[0] - from) / k_r;
  EXPECT_LT(moved, 1e-6);
  EXPECT_LT(std::fabs(from.x - 0.5), 2e-3 * k_r);  // wound up, not rolled away
  Simulation constant(slope(Rolling::cdt), options());
  constant.run(40000);
  const double bound = 0.1 * 9.81 * 5e-6 / (0.4 * k_r);  // spin that the torque gives a free grain in one step
  const Vec3 before = constant.frame().x[0];
  double spin = 0;
  for (int k = 0; k < 5000; ++k) {
    constant.run(1);
    spin = std::max(spin, norm(constant.frame().w[0]));
  }
  EXPECT_LT(spin, 3 * bound);
  row("EPSD: displacement < 1e-6 R in " + std::to_string(steps) + " steps; CDT: spin jitters below 3 mu_r F_n R dt/I",
      "EPSD moved " + sci(moved) + " R; CDT spin " + fmt_ratio(spin / bound) + " of mu_r F_n R dt/I, moved " +
          sci(norm(constant.frame().x[0] - before) / k_r) + " R in 5000 steps");
}

TEST(Stability, S17_CohesionStrongerThanWeight) {
  // Fines all around a fixed coarse grain of 100 times their radius: pull-off force 100 times the weight and more.
  // Rolling resistance keeps those at the sides from rolling down.
  const double work = 2e-3, fine = 2e-5, coarse = 2e-3;
  Scene s = open_scene({0, 0, 0}, {0.1, 0.1, 0.1}, 1e-7);
  s.materials[0].young = 1e7;
  s.materials[0].poisson = 0.25;
  hertz_law(s, 0.3, 0.5);
  s.contact.model = ContactModel::jkr;
  s.pairs[0].work_of_adhesion = work;
  s.contact.rolling = Rolling::epsd;
  s.pairs[0].rolling_friction = 0.1;
  s.pairs[0].rolling_damping = 0.3;
  s.gravity = {0, 0, -9.81};
  s.viscous_damping = 8000;
  s.allow_initial_overlap = true;
  const Vec3 centre{0.05, 0.05, 0.05};
  std::vector<Grain> grains = {{centre, {}, coarse, {}, 0, true}};
  for (int k = 0; k < 60; ++k) {
    const double t = 2 * k_pi * k / 60;
    grains.push_back({centre + (coarse + fine * (1 - 1e-3)) * Vec3{std::cos(t), 0, std::sin(t)}, {}, fine});
  }
  add_grains(s, grains);
  RunOptions o = options();
  o.audit = true;
  Simulation sim(s, o);
  sim.run(20000);
  const double reff = fine * coarse / (fine + coarse), e_star = 0.5e7 / (1 - 0.0625), p = 3 * k_pi * work * reff;
  const double weight = 9.81 * sphere_mass(2500, fine);
  const Frame f = sim.frame();
  double worst = 0, deepest = 0;
  for (std::size_t k = 1; k < f.id.size(); ++k) {
    const Vec3 d = f.x[k] - f.x[0];
    const double load = weight * d.z / norm(d);  // the part of the weight that presses; friction carries the rest
    const double a = std::cbrt(0.75 * reff / e_star * (load + p + std::sqrt(2 * p * load + p * p)));
    const double delta = a * a / reff - std::sqrt(2 * k_pi * work * a / e_star);
    worst = std::max(worst, std::fabs((coarse + fine - norm(d)) / delta - 1));
    deepest = std::max(deepest, (coarse + fine - norm(d)) / fine);
  }
  EXPECT_GT(0.5 * p / weight, 100);
  EXPECT_LT(worst, 1e-3);
  EXPECT_EQ(sim.counters().missed_contacts, 0);
  // lists reach as far as necks hold: the contact breaks at -delta = 3 (pi w/(8 E*))^(2/3) R*^(1/3), not before
  const double rupture = 3 * std::cbrt(std::pow(k_pi * work / (8 * e_star), 2) * reff);
  EXPECT_GE(adhesion_reach(s) * (std::cbrt(fine) + std::cbrt(coarse)), rupture);
  // attraction that no contact could balance is refused by name
  s.pairs[0].work_of_adhesion = 50;
  const std::string text = refusal([&] { Simulation(s, options()); });
  EXPECT_NE(text.find("work_of_adhesion"), std::string::npos) << text;
  row("JKR, pull-off > 100 weights, sizes 1:100: overlap at rest = root of the force balance to 1e-3; reach >= rupture "
      "distance; excess refused",
      "pull-off " + fmt_ratio(0.5 * p / weight) + " weights, overlap " + sci(deepest) + " R, worst error " +
          sci(worst) + ", 0 contacts missed");
}

}  // namespace
}  // namespace talus::stability
