// Scenarios 1 to 7: time step, stiffness, mass and size ratios.
#include <cmath>

#include "core/rules/timestep.hpp"
#include "tests/stability/stability_support.hpp"

namespace talus::stability {
namespace {

/// One grain held between two planes that it always touches: a linear oscillator with omega^2 = 2 k / m.
Scene oscillator(double kn, double rate, double squeeze, double dt) {
  const double r = 0.01;
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, dt);
  linear_law(s, kn, rate);
  s.walls = {plane("floor", {0, 0, squeeze - r}, {0, 0, 1}), plane("lid", {0, 0, r - squeeze}, {0, 0, -1})};
  s.allow_initial_overlap = s.allow_unstable_step = true;
  return s;
}

TEST(Stability, S01_StepSweepStableBelowTheLimitRefusedAbove) {
  const double r = 0.01, kn = 1e5, m = sphere_mass(2500, r), critical = 2 / std::sqrt(2 * kn / m);
  double worst = 0;
  for (const double f : {0.02, 0.1, 0.2, 0.4, 0.7, 0.9, 0.99}) {
    const double dt = f * critical;
    Scene s = oscillator(kn, 0, 0.3 * r, dt);
    add_grains(s, {{{0, 0, 0.001 * r}, {}, r}});
    Simulation sim(s, options());
    // Leapfrog keeps v(n-1/2) v(n+1/2) + omega^2 x(n)^2 exactly for a linear oscillator; the frame holds v(n-1/2).
    const auto invariant = [&] {
      const Frame q = sim.frame();
      const double x = q.x[0].z, v = q.v[0].z, w2 = 2 * kn / m;
      return v * (v - w2 * x * dt) + w2 * x * x;
    };
    sim.run(1);
    const double start = invariant();
    const int steps = 4000;
    sim.run(steps);
    worst = std::max(worst, std::fabs(invariant() / start - 1) / steps);
  }
  EXPECT_LT(worst, 1e-10);
  for (const double f : {1.01, 1.2}) {
    Scene s = oscillator(kn, 0, 0.3 * r, f * critical);
    add_grains(s, {{{0, 0, 0.001 * r}, {}, r}});
    // ... allowed, it blows up and is stopped ...
    EXPECT_NE(refusal([&] { Simulation(s, options()).run(20000); }).find("particle 0"), std::string::npos) << f;
    // ... and without permission it is refused with the largest stable step.
    s.allow_unstable_step = false;
    const std::string text = refusal([&] { Simulation(s, options()); });
    EXPECT_NE(text.find("at most"), std::string::npos) << text;
  }
  Scene s = oscillator(kn, 0, 0, 0.3 * k_pi / std::sqrt(kn / m));
  EXPECT_NE(time_step_limits(s, r, r).warning.find("time.step"), std::string::npos);  // warns above 0.2 of t_c
  row("energy growth < 1e-10 per step up to 0.99 of 2/omega; refused with the largest stable step above",
      sci(worst) + " per step");
}

/// Height at a fixed time after an impact on the floor.
double height_after(bool hertz, double e, double dt, int phase) {
  const double r = 0.01;
  Scene s = open_scene({-1, -1, -0.1}, {1, 1, 1}, dt);
  s.materials[0].young = 1e7;
  s.materials[0].poisson = 0.3;
  if (hertz)
    hertz_law(s, e, 0);
  else
    linear_restitution(s, 1e4, e);
  s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
  s.allow_unstable_step = true;
  add_grains(s, {{{0, 0, 1.1 * r + 1.7e-5 * phase}, {0, 0, -1}, r}});
  Simulation sim(s, options());
  sim.run(std::llround(0.012 / dt));
  return sim.frame().x[0].z;
}

TEST(Stability, S02_ErrorFallsWithTheSquareOfTheStep) {
  // rms over eight phases of the impact against the step, reference 16 times finer than the finest
  const auto order = [](bool hertz, double e) {
    const std::vector<double> steps = {6.4e-5, 3.2e-5, 1.6e-5, 8e-6};
    std::vector<double> error(steps.size());
    for (int phase = 0; phase < 8; ++phase) {
      const double reference = height_after(hertz, e, 5e-7, phase);
      for (std::size_t k = 0; k < steps.size(); ++k)
        error[k] += std::pow(height_after(hertz, e, steps[k], phase) - reference, 2) / 8;
    }
    return 0.5 * log_slope(steps, error);
  };
  const double elastic_hertz = order(true, 1), elastic = order(false, 1), damped_hertz = order(true, 0.5),
               damped = order(false, 0.5);
  EXPECT_GE(elastic_hertz, 1.9);
  EXPECT_GE(elastic, 1.5);
  EXPECT_GE(damped, 1.2);  // the onset correction keeps the dashpot's force jump from lowering it to 1
  row("order >= 1.9 for elastic Hertz, others reported", "Hertz " + sci(elastic_hertz) +
                                                             ", e 0.5: " + sci(damped_hertz) + "; linear " +
                                                             sci(elastic) + ", e 0.5: " + sci(damped));
}

TEST(Stability, S03_ResonanceIsBoundedByTheDashpotAndGrowsLinearlyWithoutIt) {
  const double r = 0.01, kn = 1e5, m = sphere_mass(2500, r), omega = std::sqrt(2 * kn / m), dt = 0.01 / omega;
  const double drive = 1e-4 * r;
  const auto amplitude = [&](double rate, int periods) {
    Scene s = oscillator(kn, rate, 0.3 * r, dt);
    for (WallSpec& w : s.walls) {
      w.motion.amplitude = {0, 0, drive};
      w.motion.frequency = omega / (2 * k_pi);
    }
    add_grains(s, {{{0, 0, 0}, {}, r}});
    Simulation sim(s, options());
    const auto period = std::llround(2 * k_pi / (omega * dt));
    sim.run((periods - 1) * period);
    double top = 0;
    for (std::int64_t k = 0; k < period; ++k) {
      sim.run(1);
      top = std::max(top, std::fabs(sim.frame().x[0].z - drive * std::sin(omega * sim.time())));
    }
    return top;
  };
  // Relative to the walls: m y'' + 2 (rate m) y' + 2 k y = m drive omega^2 sin(omega t), so y = F0 / (c omega).
  const double zeta = 0.02, rate = zeta * omega;
  const double bounded = amplitude(rate, 60) / (drive * omega / (2 * rate));
  EXPECT_NEAR(bounded, 1, 0.02);
  const double ten = amplitude(0, 10), twenty = amplitude(0, 20);
  EXPECT_NEAR(ten / (0.5 * drive * omega * 10 * 2 * k_pi / omega), 1, 0.05);
  EXPECT_NEAR((twenty - ten) / ten, 1, 0.05);
  Scene near = oscillator(kn, 0, 0, 1.9 / omega);
  near.allow_unstable_step = false;
  EXPECT_FALSE(refusal([&] { time_step_limits(near, r, r); }).empty());
  row("amplitude F0/(c omega) within 2 %; linear growth without dashpot; dt omega near 2 refused",
      "ratio " + fmt_ratio(bounded) + ", undamped growth " + fmt_ratio((twenty - ten) / ten));
}

TEST(Stability, S04_StiffestPairThatCanMeetSetsTheStep) {
  const double r = 0.005, speed = 1;
  const auto scene = [&](bool hard_grains) {
    Scene s = open_scene({-1, -1, -1}, {1, 1, 1}, 1e-9);
    s.materials = {{"soft", 2500, 5e4, 0.3}, {"hard", 2500, 5e10, 0.3}};
    hertz_law(s, 0.8, 0.3);
    for (int k = 0; k < (hard_grains ? 2 : 1); ++k) {
      Source q;
      q.kind = Source::Kind::random;
      q.region = {{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}};
      q.size.diameter = 2 * r;
      q.number = 1;
      q.material = k;
      s.sources.push_back(q);
    }
    s.walls = {plane("floor", {0, 0, -1}, {0, 0, 1}, 1)};
    return s;
  };
  const auto closed = [&](double e1, double e2, double m, double radius) {
    const double estar = 1 / ((1 - 0.09) / e1 + (1 - 0.09) / e2);
    const double delta = std::pow(15 * m * speed * speed / (16 * estar * std::sqrt(radius)), 0.4);
    return 2 / std::sqrt(2 * estar * std::sqrt(radius * delta) / m);
  };
  const double m = sphere_mass(2500, r);
  const double hard_pair = closed(5e10, 5e10, m / 2, r / 2), soft_pair = closed(5e4, 5e4, m / 2, r / 2),
               soft_wall = closed(5e4, 5e10, m, r);
  const TimeStepReport both = time_step_limits(scene(true), r, r, speed),
                       soft = time_step_limits(scene(false), r, r, speed);
  EXPECT_NEAR(both.isolated_pair.seconds / hard_pair, 1, 1e-6);
  EXPECT_NE(both.isolated_pair.pair.find("hard (r = 0.005) - hard"), std::string::npos) << both.isolated_pair.pair;
  // hard walls alone do not bring in the hard pair
  EXPECT_NEAR(soft.isolated_pair.seconds / std::min(soft_pair, soft_wall), 1, 1e-6);
  // a run at the limit: hard grain through a soft one's neighbourhood and onto the hard floor
  Scene s = scene(true);
  s.sources.clear();
  s.dt = 0.99 * both.packing.seconds;
  s.max_overlap = 1;
  Grain hard{{0, 0, -1 + 1.001 * r}, {0, 0, -speed}, r};
  hard.material = 1;
  add_grains(s, {hard, {{0.02, 0, -0.98}, {0, 0, -0.05}, r}});
  Simulation sim(s, options());
  sim.run(20000);
  const double e = sim.frame().v[0].z / speed;
  EXPECT_NEAR(e, 0.8, 0.02);
  row("the limit is that of the stiffest pair that can meet, walls included; a run at it keeps its restitution",
      "hard/soft limit ratio " + sci(hard_pair / soft_pair) + ", e " + fmt_ratio(e) + " for 0.8");
}

TEST(Stability, S05_LightGrainUnderAHeavyOneIsStableAtTheAdvisedStep) {
  const double heavy = 0.1, light = 0.001, k = 1e8, g = 9.81;
  Scene s = open_scene({-1, -1, -0.1}, {1, 1, 1}, 1e-9);
  linear_restitution(s, k, 0.9);
  s.gravity = {0, 0, -g};
  s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
  const double limit = time_step_limits(s, light, heavy).packing.seconds, m = sphere_mass(2500, light);
  EXPECT_LT(limit, 2 * std::sqrt(m / (2 * k)));  // the light grain's two springs act together
  s.dt = 0.99 * limit;
  s.output.energies = true;
  add_grains(s, {{{0, 0, light}, {}, light}, {{0, 0, 2 * light + heavy}, {}, heavy}});
  Simulation sim(s, options());
  double deepest = 0, residual = 0;
  for (int n = 0; n < 400; ++n) {
    sim.run(100);
    for (const ContactRecord& c : sim.frame({.contacts = true}).contacts) deepest = std::max(deepest, c.overlap);
    sim.run(1);
    residual = std::max(residual, std::fabs(sim.energies().residual));
  }
  const double weight = sphere_mass(2500, heavy) * g;
  const double scale = weight * (2 * weight / k);  // work of the weight over both static overlaps
  EXPECT_LT(deepest / light, 0.01);
  EXPECT_LT(residual / scale, 0.05);
  row("dt guard covers parallel springs: dt < 2 sqrt(m/(k1+k2)); overlap < 1 % of the light radius",
      "dt limit / that " + fmt_ratio(limit / (2 * std::sqrt(m / (2 * k)))) + ", overlap " + sci(deepest / light));
}

TEST(Stability, S06_SmallGrainSlidesOutFromBetweenTwoBigOnes) {
  double worst = 0;
  for (const double ratio : {3.0, 10.0, 30.0, 100.0}) {
    const double big = 0.005, r = big / ratio, height = std::sqrt(2 * big * r + r * r), tilt = 0.0174;
    const auto scene = [&](double dt) {
      Scene s = open_scene({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}, dt);
      const double k = 1e4 * std::pow(r / 0.00025, 3);  // the same contact time at every ratio
      linear_restitution(s, k, 0.5, 0.8 * k, 0.5);
      s.gravity = {0, 0, -9.81};
      s.allow_initial_overlap = true;
      s.allow_unstable_step = true;  // above the limit of packings; the grain has two contacts
      std::vector<Grain> g = {{{2 * big, 0, 0}, {}, big},
                              {{0, 0, 0}, {}, big},
                              {{big, height * std::sin(tilt), height * std::cos(tilt)}, {}, r}};
      g[0].fixed = g[1].fixed = true;
      add_grains(s, g);
      return s;
    };
    const double dt = 1e-6;
    Simulation coarse(scene(dt), options()), fine(scene(dt / 4), options());
    while (coarse.frame().x[2].z > 0.7 * height && coarse.step() < 400000) coarse.run(500);
    fine.run(4 * coarse.step());
    const double path = norm(coarse.frame().x[2] - fine.frame().x[2]) / r;
    worst = std::max(worst, path);
    EXPECT_LT(path, ratio > 50 ? 1e-2 : 1e-3) << ratio;
    coarse.run(80000);
    const Frame f = coarse.frame({.contacts = true});
    EXPECT_LT(f.x[2].z, -height) << ratio;
    for (const ContactRecord& c : f.contacts) EXPECT_FALSE(c.a == 2 || c.b == 2) << ratio;
  }
  row("size ratios 3, 10, 30, 100: no sticking; rolling path agrees with dt/4 to 1e-3 R (1e-2 R at 100)",
      "worst path difference " + sci(worst) + " R");
}

TEST(Stability, S07_RadiusRatio100ListComplete) {
  const int per_axis = full() ? 47 : 18;
  const double r = 1e-3, pitch = 2.4 * r;
  const auto scene = [&](bool coarse) {
    // fines on a shaken lattice; the coarse grain in the middle of it pushes the lattice outwards by its own size
    const double gap = coarse ? 200 * r : 0, side = per_axis * pitch + gap;
    Scene s = open_scene({0, 0, 0}, {side, side, side}, 1e-6);
    linear_law(s, 1e3, 10);
    std::vector<Grain> grains;
    if (coarse) grains.push_back({{0.5 * side, 0.5 * side, 0.5 * side}, {}, 100 * r});
    for (int k = 0; k < per_axis * per_axis * per_axis; ++k) {
      const auto q = [k](int c) { return uniform(41, static_cast<std::uint64_t>(8 * k + c)) - 0.5; };
      const int at[3] = {k % per_axis, k / per_axis % per_axis, k / per_axis / per_axis};
      Vec3 x;
      for (int c = 0; c < 3; ++c)
        x[c] = pitch * (at[c] + 0.5) + 0.39 * r * q(c) + (c == 2 && 2 * at[c] >= per_axis ? gap : 0);
      grains.push_back({x, {5 * q(3), 5 * q(4), 5 * q(5)}, r});
    }
    add_grains(s, grains);
    return s;
  };
  Simulation mono(scene(false), options()), mixed(scene(true), options());
  mono.run(5);
  mixed.run(5);
  const auto candidates = [](const Simulation& sim) {
    return static_cast<double>(sim.counters().pairs) / static_cast<double>(sim.particles());
  };
  const int audit_steps = full() ? 1 : 3;  // brute force over all pairs
  EXPECT_EQ(audited(scene(true), audit_steps), 0);
  EXPECT_LE(candidates(mixed), 3 * candidates(mono));
  const auto rebuild_time = [](const Simulation& sim) {
    for (const NodeTime& t : sim.profile().nodes)
      if (t.node == "rebuild") return t.seconds / static_cast<double>(t.calls);
    return 0.0;
  };
  const double slower = rebuild_time(mixed) / rebuild_time(mono);
  row("1 coarse grain of 100 R among fines: pair set = brute force in every step; candidates <= 3 x monodisperse",
      "0 missed, candidates per particle " + fmt_ratio(candidates(mixed) / candidates(mono)) +
          " x monodisperse, rebuild " + sci(slower) + " x as long");
  if (slower > 5) shortfall("one uniform grid of the coarse grain's size: the search, not the list, is slow");
}

}  // namespace
}  // namespace talus::stability
