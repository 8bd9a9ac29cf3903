// Scenarios 32 to 35 and 38: meshes, corners, columns, vibrated beds, heat.
#include <algorithm>
#include <cmath>

#include "core/meshes/mesh_file.hpp"
#include "tests/stability/stability_support.hpp"

namespace talus::stability {
namespace {

/// OBJ of n x n squares over [0, 1]^2 at z = 0, cut along alternating diagonals; needles: squares 1000 times as long.
std::string flat_mesh(int n, bool needles) {
  std::string s;
  const double x_scale = needles ? 1.0 : 1.0 / n, y_scale = needles ? 1e-3 : 1.0 / n;
  const int rows = needles ? 1000 : n, columns = needles ? 1 : n;
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x <= columns; ++x)
      s += "v " + std::to_string(x * x_scale) + " " + std::to_string(y * y_scale) + " 0\n";
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const int a = y * (columns + 1) + x + 1, b = a + 1, c = a + columns + 1, d = c + 1;
      const auto facet = [&](int p, int q, int r) {
        s += "f " + std::to_string(p) + " " + std::to_string(q) + " " + std::to_string(r) + "\n";
      };
      if ((x + y) % 2 == 0) {
        facet(a, b, d);
        facet(a, d, c);
      } else {
        facet(a, b, c);
        facet(b, d, c);
      }
    }
  return s;
}

TEST(Stability, S32_RollingOverFacetsEqualsThePlane) {
  const double r = 0.05;
  const auto roll = [&](const std::string& mesh) {
    Scene s = open_scene({-0.5, -0.5, -0.5}, {1.5, 1.5, 1.5}, 5e-5);
    linear_law(s, 1e5, 20, 3e4, 20, 0.4);
    s.gravity = {0, 0, -9.81};
    if (mesh.empty()) {
      s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
    } else {
      WallSpec w;
      w.name = "floor";
      w.shape = WallShape::mesh;
      w.file = mesh;
      s.walls = {w};
    }
    Grain g{{0.1, 0.125, r}, {1.3, 0.9, 0}, r};
    g.w = {5, 0, 3};
    add_grains(s, {g});
    return s;
  };
  Simulation exact(roll(""), options()), squares(roll(temporary("squares.obj", flat_mesh(8, false))), options()),
      needles(roll(temporary("needles.obj", flat_mesh(0, true))), options());
  const double weight = sphere_mass(2500, r) * 9.81;
  double worst = 0;
  for (int n = 0; n < 9000; ++n) {
    for (Simulation* sim : {&exact, &squares, &needles}) sim->run(1);
    const auto force = [](Simulation& sim) { return sim.frame({.wall_loads = true}).wall_loads[0].force; };
    const Vec3 f = force(exact);
    worst = std::max({worst, norm(force(squares) - f) / weight, norm(force(needles) - f) / weight});
  }
  EXPECT_LT(worst, 1e-10);
  EXPECT_GT(exact.frame().x[0].x, 0.4);  // it went over several edges and vertices
  // bad facets are dropped or counted, and reported
  const std::string bad = flat_mesh(4, false) + "f 1 2 2\nf 1 2 7\nf 7 2 1\nf 1 2 7\n";
  const Mesh mesh = read_mesh(temporary("bad.obj", bad), {}, 0);
  EXPECT_EQ(mesh.report.degenerate, 1);
  EXPECT_GE(mesh.report.duplicate, 2);
  row("force over edges, vertices and needles (1:1000) vs plane <= 1e-10 mg; bad facets reported",
      "worst " + sci(worst) + " mg in 9000 steps; " + std::to_string(mesh.report.degenerate) + " degenerate, " +
          std::to_string(mesh.report.duplicate) + " duplicate found");
}

TEST(Stability, S33_GrainInACornerOfThreeWallsRestsInBalance) {
  const double r = 0.01, kn = 1e5, g = 9.81, m = sphere_mass(2500, r);
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 2e-5);
  linear_law(s, kn, 300);
  s.gravity = {-3, -4, -std::sqrt(g * g - 25)};
  s.walls = {plane("a", {0, 0, 0}, {1, 0, 0}), plane("b", {0, 0, 0}, {0, 1, 0}), plane("c", {0, 0, 0}, {0, 0, 1})};
  add_grains(s, {{{1.001 * r, 1.002 * r, 1.003 * r}, {}, r}});
  Simulation sim(s, options());
  sim.run(60000);
  const Frame f = sim.frame({.contacts = true, .wall_loads = true});
  EXPECT_EQ(f.contacts.size(), 3U);
  Vec3 total;
  for (const WallLoad& l : f.wall_loads) total = total + l.force;
  const double residual = norm(total - m * s.gravity) / (m * g);
  EXPECT_LT(residual, 1e-9);
  for (int k = 0; k < 3; ++k)
    // each wall carries its part, whatever the step
    EXPECT_NEAR((r - f.x[0][k]) / (m * std::fabs(s.gravity[k]) / kn), 1, 1e-9) << k;
  row("three contacts kept apart; residual force < 1e-9 mg; overlaps m g_k / k_n to 1e-9",
      "residual " + sci(residual) + " mg");
}

TEST(Stability, S34_ColumnOfAThousandStiffGrainsStaysStill) {
  const int n = 1000, steps = full() ? 100000 : 10000;
  const double r = 0.005, kn = 1e6, g = 9.81, m = sphere_mass(2500, r), dt = 0.2 * std::sqrt(m / kn);
  const auto column = [&](bool settled) {
    Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 2 * r * n + 0.1}, dt);
    linear_law(s, kn, 0);
    s.gravity = {0, 0, -g};
    s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
    s.allow_initial_overlap = true;
    std::vector<Grain> grains;
    double z = r;
    for (int k = 0; k < n; ++k) {
      const double overlap = settled ? (n - k) * m * g / kn : 0;
      z += (k == 0 ? 0 : 2 * r) - overlap;
      grains.push_back({{0, 0, z}, {}, r});
    }
    add_grains(s, grains);
    return s;
  };
  Simulation still(column(true), options());
  const Frame before = still.frame();
  still.run(steps);
  const Frame after = still.frame();
  double moved = 0;
  for (int k = 0; k < n; ++k) moved = std::max(moved, std::fabs(after.x[k].z - before.x[k].z));
  const double smallest = m * g / kn;  // overlap of the topmost pair
  EXPECT_LT(moved / smallest, 1e-3);
  // from rest without overlaps: the momentum is the impulse of wall force and weight
  Simulation falling(column(false), options());
  double impulse = 0, worst = 0;
  for (int k = 0; k < 3000; ++k) {
    falling.run(1);
    const Frame f = falling.frame({.wall_loads = true});
    const double kick = k == 0 ? 0.5 * dt : dt;  // velocity Verlet begins with half a kick
    impulse += kick * (-f.wall_loads[0].force.z - n * m * g);
    double momentum = 0;
    for (const Vec3& v : f.v) momentum += m * v.z;
    worst = std::max(worst, std::fabs(momentum - impulse));
  }
  const double scale = n * m * g * 3000 * dt;
  EXPECT_LT(worst / scale, 1e-12);
  row(std::to_string(steps) + " steps from the exact static overlaps: still; from rest: momentum = impulse to 1e-12",
      "moved " + sci(moved / smallest) + " of the smallest overlap; momentum to " + sci(worst / scale));
}

/// Bed of about 300 grains of radius 1 mm on a floor that vibrates at 50 Hz.
Scene vibrated(double amplitude) {
  Scene s = open_scene({0, 0, 0}, {0.016, 0.016, 0.3}, 4e-6);
  s.domain.boundary[0] = s.domain.boundary[1] = {Boundary::periodic, Boundary::periodic};
  s.domain.boundary[2] = {Boundary::open, Boundary::open};
  linear_restitution(s, 2e4, 0.6, 5700, 0.3);
  s.gravity = {0, 0, -9.81};
  WallSpec floor = plane("floor", {0, 0, 0.2005}, {0, 0, 1});
  floor.motion.amplitude = {0, 0, amplitude};
  floor.motion.frequency = 50;
  floor.motion.start = 0.08;  // the bed settles first
  s.walls = {floor};
  s.output.energies = true;
  std::vector<Grain> grains;
  for (int k = 0; k < 300; ++k)
    grains.push_back({{0.0011 + 0.00225 * (k % 7), 0.0011 + 0.00225 * (k / 7 % 7), 0.2020 + 0.00205 * (k / 49)},
                      {0.1 * uniform(2, static_cast<std::uint64_t>(k)), 0.05, 0},
                      0.001});
  add_grains(s, grains);
  return s;
}

// A wall that appears within a resting grain is told as such; stiffer contacts would not help.
TEST(Stability, S35_AWallThatAppearsWithinGrainsIsSaidToHaveDoneSo) {
  Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 1e-5);
  linear_restitution(s, 1e4, 0.5);
  s.walls = {plane("lid", {0, 0, 0.0002}, {0, 0, -1})};
  s.walls[0].appear = 50 * s.dt;
  add_grains(s, {{{0, 0, 0}, {0, 0, 0}, 0.002}});
  const std::string text = refusal([&] {
    Simulation sim(s, options());
    sim.run(200);
  });
  EXPECT_NE(text.find("wall 'lid', which has just appeared where grains are, overlap by more than"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("stiffer contacts"), std::string::npos) << text;
}

TEST(Stability, S35_VibratedBedFluidisesAndAbsurdAmplitudesMeetTheGuard) {
  Simulation sim(vibrated(0.0002), options());
  sim.run(20000);
  const auto resting = sim.counters().contacts + sim.counters().wall_contacts;
  std::int64_t fewest = resting;
  double residual = 0, work = 0;
  for (int k = 0; k < 100; ++k) {  // four periods
    sim.run(200);
    fewest = std::min(fewest, sim.counters().contacts + sim.counters().wall_contacts);
    const Energies e = sim.energies();
    residual = std::max(residual, std::fabs(e.residual));
    work = std::max(work, std::fabs(e.wall_work) + e.dissipated_damping + e.dissipated_friction);
  }
  EXPECT_LT(fewest, resting / 2);    // 2 g: the bed leaves the floor in every period
  EXPECT_LT(residual / work, 0.05);  // wall work in = energy stored + dissipated
  EXPECT_EQ(sim.particles(), 300);
  // 200 mm at 50 Hz is 63 m/s and 2012 g: stopped with a message that names who and why
  Simulation absurd(vibrated(0.2), options());
  const std::string text = refusal([&] { absurd.run(40000); });
  EXPECT_NE(text.find("overlap by more than"), std::string::npos) << text;
  EXPECT_NE(text.find("step"), std::string::npos) << text;
  row("50 Hz, 0.2 mm: fluidises, energy input balanced; 200 mm: guard message",
      std::to_string(resting) + " -> " + std::to_string(fewest) + " contacts, residual " + sci(residual / work) +
          " of the turnover; 200 mm stopped at step " + std::to_string(absurd.step()));
}

TEST(Stability, S38_HeatBetweenTinyAndHugeGrains) {
  constexpr double k_tiny = 1e-5, k_huge = 1e-2;
  const auto scene = [&](std::int64_t every) {
    Scene s = open_scene({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}, 1e-6);
    linear_law(s, 1e2, 0);
    s.allow_unstable_step = s.allow_initial_overlap = true;
    add_grains(s, {{{0, 0, 0}, {}, k_huge, {}, 0, true}});
    add_grains(s, {{{k_huge + 0.98 * k_tiny, 0, 0}, {}, k_tiny, {}, 0, true}});
    s.heat.on = true;
    s.heat.every = every;
    s.heat.temperature = 300;
    MatterHeat m;
    m.capacity = Curve::constant(900);
    m.conductivity = Curve::constant(0.1);
    m.emissivity = 0.9;
    s.heat.matter = {m};
    s.heat.gas.on = true;
    s.heat.gas.film = 1e4;  // Bi = h R / (3 k) of the huge one: 333
    s.heat.gas.temperature = TimeTable::constant(1300);
    s.heat.sources = {{300, false}, {2300, false}};
    return s;
  };
  const std::string refused = refusal([&] { Simulation(scene(100000), options()).run(100000); });
  ASSERT_NE(refused.find("heat.every = "), std::string::npos) << refused;
  const std::int64_t most = std::stoll(refused.substr(refused.find("heat.every = ") + 13));
  Simulation sim(scene(most), options());
  double low = 1e9, high = 0;
  for (int k = 0; k < 200; ++k) {
    sim.run(most);
    for (const ExtraColumn& c : sim.frame().extra) {
      if (c.name != "temperature") continue;
      for (const double t : c.values) low = std::min(low, t), high = std::max(high, t);
    }
  }
  EXPECT_GT(low, 300) << "the huge one is warmed";
  EXPECT_LE(high, 2300);
  row("no over- or undershoot beyond the initial temperatures",
      "mass ratio 1e9, 2000 K apart: " + sci(low) + " to " + sci(high) + " K at the longest heat step that is allowed");
}

}  // namespace
}  // namespace talus::stability
