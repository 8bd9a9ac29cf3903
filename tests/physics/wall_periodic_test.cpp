// Walls on periodic axes: a scene that is moved along them, with wrap-around, moves as before; so does one that is
// repeated. What happens at a side is what happens in the middle of the box.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/rng.hpp"
#include "physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_side = 0.125, k_radius = 0.005;

Scene cube(const std::string& axes) {
  Scene s = open_scene({0, 0, 0}, {k_side, k_side, k_side}, 5e-6);
  for (int k = 0; k < 3; ++k)
    if (axes.find("xyz"[k]) != std::string::npos)
      s.domain.boundary[static_cast<std::size_t>(k)] = {Boundary::periodic, Boundary::periodic};
  return s;
}

WallSpec box(const std::string& name, Vec3 lower, Vec3 upper) {
  WallSpec w;
  w.name = name;
  w.shape = WallShape::box;
  w.lower = lower;
  w.upper = upper;
  return w;
}

WallSpec mesh(const std::string& name, const std::string& file, Vec3 shift = {}) {
  WallSpec w;
  w.name = name;
  w.shape = WallShape::mesh;
  w.file = file;
  w.shift = shift;
  return w;
}

Vec3 wrapped(const Scene& s, Vec3 x) {
  for (int k = 0; k < 3; ++k)
    if (s.domain.periodic(k)) {
      const double side = s.domain.upper[k] - s.domain.lower[k];
      x[k] -= side * std::floor((x[k] - s.domain.lower[k]) / side);
      if (!(x[k] < s.domain.upper[k])) x[k] = s.domain.lower[k];
    }
  return x;
}

Vec3 nearest(const Scene& s, Vec3 d) {
  for (int k = 0; k < 3; ++k)
    if (s.domain.periodic(k))
      d[k] -= (s.domain.upper[k] - s.domain.lower[k]) * std::round(d[k] / (s.domain.upper[k] - s.domain.lower[k]));
  return d;
}

void move_walls(Scene& s, Vec3 by) {
  for (WallSpec& w : s.walls)
    for (Vec3* at : {&w.point, &w.lower, &w.upper, &w.shift, &w.motion.rotation_origin}) *at = *at + by;
}

/// Runs both, `other` being `scene` moved by `by`, and compares motion and wall loads; `walls_by`: by which its walls
/// are moved, cut elsewhere they have no torque in common. Returns wall contacts seen.
std::int64_t expect_same(const Scene& scene, const Scene& other, Vec3 by, std::optional<Vec3> walls_by,
                         std::int64_t steps, double tolerance) {
  Simulation a(scene, options()), b(other, options());
  std::int64_t seen = 0;
  for (std::int64_t at = 0; at < steps && !testing::Test::HasFailure(); at += 10) {
    a.run(10);
    b.run(10);
    const Frame f = a.frame({.wall_loads = true}), g = b.frame({.wall_loads = true});
    EXPECT_EQ(a.counters().wall_contacts, b.counters().wall_contacts) << "step " << at;
    seen += a.counters().wall_contacts;
    for (std::size_t k = 0; k < f.x.size(); ++k) {
      EXPECT_LT(norm(nearest(other, g.x[k] - f.x[k] - by)), tolerance * k_radius) << "grain " << k << " step " << at;
      EXPECT_LT(norm(g.v[k] - f.v[k]), tolerance) << "grain " << k << " step " << at;
      if (!f.w.empty()) {
        EXPECT_LT(norm(g.w[k] - f.w[k]) * k_radius, tolerance);
      }
    }
    for (std::size_t k = 0; k < f.wall_loads.size(); ++k) {
      const WallLoad &p = f.wall_loads[k], &q = g.wall_loads[k];
      const double scale = 10 * tolerance;  // stiffness times the deviation of a position, and more
      EXPECT_LT(norm(q.force - p.force), scale + 1e3 * tolerance * norm(p.force));
      if (!walls_by) continue;
      EXPECT_LT(norm(q.torque - (p.torque + cross(*walls_by, p.force))), scale + 1e3 * tolerance * norm(p.torque));
    }
  }
  return seen;
}

/// An irregular octahedron of about 2 cm around the origin.
std::string body(std::uint64_t seed) {
  const CounterRng rng(seed, 8);
  std::vector<Vec3> points;
  for (std::uint64_t k = 0; k < 6; ++k) {
    Vec3 p{rng.uniform(4 * k, -0.003, 0.003), rng.uniform(4 * k + 1, -0.003, 0.003),
           rng.uniform(4 * k + 2, -0.003, 0.003)};
    p[static_cast<int>(k / 2)] = (k % 2 == 0 ? 1 : -1) * rng.uniform(4 * k + 3, 0.012, 0.022);
    points.push_back(p);
  }
  std::vector<std::array<int, 3>> facets;
  for (int a = 0; a < 2; ++a)
    for (int b = 2; b < 4; ++b)
      for (int c = 4; c < 6; ++c) facets.push_back({a, b, c});
  return mesh_file(points, facets);
}

/// A wall in the middle of the cube that moves somehow, and grains that fly at it from all around.
Scene bombarded(std::uint64_t seed) {
  const CounterRng rng(seed, 9);
  std::uint64_t n = 0;
  const auto u = [&](double a, double b) { return rng.uniform(n++, a, b); };
  const auto direction = [&] {
    Vec3 d;
    do d = {u(-1, 1), u(-1, 1), u(-1, 1)};
    while (norm(d) > 1 || norm(d) < 0.1);
    return (1 / norm(d)) * d;
  };
  Scene s = cube(seed % 4 == 0 ? "x" : (seed % 4 == 1 ? "yz" : "xyz"));
  linear_restitution(s, 2e4, 0.8, 5.7e3, 0.3);
  const Vec3 middle{k_side / 2, k_side / 2, k_side / 2};
  WallSpec w;
  switch (seed % 3) {
    case 0:
      w = box("wall", middle - Vec3{u(0.004, 0.015), u(0.004, 0.015), u(0.004, 0.015)},
              middle + Vec3{u(0.004, 0.015), u(0.004, 0.015), u(0.004, 0.015)});
      break;
    case 1: {
      w.name = "wall";
      w.shape = WallShape::cone;
      w.axis = direction();
      w.length = u(0.01, 0.03);
      w.point = middle - 0.5 * w.length * w.axis;
      w.radius = u(0.006, 0.014);
      w.radius_end = u(0, 1) < 0.5 ? w.radius : u(0.002, 0.01);
      break;
    }
    default:
      w = mesh("wall", body(seed), middle);
  }
  switch (seed % 5) {
    case 0:
      break;
    case 1:
      w.motion.velocity = u(0.2, 1) * direction();
      break;
    case 2:
      w.motion.rotation_axis = direction();
      w.motion.rotation_rate = 30;
      w.motion.rotation_origin = middle + 0.003 * direction();
      break;
    case 3:
      w.motion.amplitude = 0.002 * direction();
      w.motion.frequency = 50;
      break;
    default:
      w.motion.velocity = u(0.2, 1) * direction();
      w.motion.rotation_axis = direction();
      w.motion.rotation_rate = 30;
      w.motion.rotation_origin = middle;
  }
  s.walls = {w};
  std::vector<Grain> grains;
  for (int tries = 0; tries < 4000 && grains.size() < 14; ++tries) {
    const Vec3 d = direction();
    Grain g{middle + u(0.032, 0.055) * d, {}, k_radius};
    g.v = u(0.6, 1.6) * ((-1.0) * d + 0.25 * direction());
    const bool free = std::none_of(grains.begin(), grains.end(),
                                   [&](const Grain& o) { return norm(nearest(s, o.x - g.x)) < 2.1 * k_radius; });
    if (free) grains.push_back(g);
  }
  for (Grain& g : grains) g.x = wrapped(s, g.x);
  add_grains(s, grains);
  return s;
}

// 40 scenes: box, cone and mesh; at rest, translating, turning, shaking; one, two and three periodic axes.
TEST(WallPeriodicMotion, AMovedSceneMovesAsBefore) {
  std::int64_t contacts = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Scene here = bombarded(seed);
    const CounterRng rng(seed, 10);
    Vec3 by;
    for (int k = 0; k < 3; ++k)
      if (here.domain.periodic(k)) by[k] = rng.uniform(static_cast<std::uint64_t>(k), -1.5, 1.5) * k_side;
    Scene there = here;
    move_walls(there, by);
    // the file holds the grains of `here`
    Simulation start(here, options());
    const Frame f = start.frame();
    std::vector<Grain> grains;
    for (std::size_t k = 0; k < f.x.size(); ++k) grains.push_back({wrapped(there, f.x[k] + by), f.v[k], f.r[k]});
    there.sources.clear();
    add_grains(there, grains);
    SCOPED_TRACE("scene " + std::to_string(seed));
    contacts += expect_same(here, there, by, by, 5000, 1e-8);
    if (HasFailure()) return;
  }
  EXPECT_GT(contacts, 2000);
}

// A block that runs along the periodic axis, six times around, against four of them in a box four times as long.
TEST(WallPeriodicMotion, ABeltEqualsItsExplicitCopies) {
  const int copies = 4;
  const auto make = [&](int n) {
    Scene s = cube("x");
    s.domain.upper.x = n * k_side;
    s.domain.boundary[1] = s.domain.boundary[2] = {Boundary::wall, Boundary::wall};
    linear_restitution(s, 2e4, 0.7, 5.7e3, 0.4);
    std::vector<Grain> grains;
    for (int k = 0; k < n; ++k) {
      const Vec3 at{k * k_side, 0, 0};
      WallSpec w = box("block", at + Vec3{0.1, 0.03, 0.03}, at + Vec3{0.125, 0.06, 0.06});
      w.motion.velocity = {1.25, 0, 0};
      s.walls.push_back(w);
      grains.push_back({at + Vec3{0.02, 0.045, 0.063}, {0.31, 0, -0.0512}, k_radius});
      grains.push_back({at + Vec3{0.05, 0.024, 0.045}, {-0.2, 0.03, 0}, k_radius});
      grains.push_back({at + Vec3{0.0801234, 0.0501, 0.0502}, {0, 0, 0}, k_radius});
    }
    add_grains(s, grains);
    return s;
  };
  const Scene one_scene = make(1);
  Simulation one(one_scene, options()), many(make(copies), options());
  std::int64_t contacts = 0;
  for (int k = 0; k < 1200; ++k) {
    one.run(100);  // 0.6 s: six periods
    many.run(100);
    contacts += one.counters().wall_contacts;
    ASSERT_EQ(copies * one.counters().wall_contacts, many.counters().wall_contacts) << one.step();
    const Frame f = one.frame(), g = many.frame();
    for (std::size_t q = 0; q < g.x.size(); ++q) {
      ASSERT_LT(norm(nearest(one_scene, g.x[q] - f.x[q % 3])), 1e-6 * k_radius) << one.step() << " grain " << q;
      ASSERT_LT(norm(g.v[q] - f.v[q % 3]), 1e-6) << one.step() << " grain " << q;
    }
  }
  EXPECT_GT(contacts, 3);
}

/// A surface z = |...| of two slopes; `low`: the valley lies at the sides of the box, else in its middle.
std::string valley(bool at_side) {
  const double low = 0.0078125, high = low + k_side / 2, edge = at_side ? low : high, middle = at_side ? high : low;
  return mesh_file({{0, 0, edge},
                    {0, k_side, edge},
                    {k_side / 2, 0, middle},
                    {k_side / 2, k_side, middle},
                    {k_side, 0, edge},
                    {k_side, k_side, edge}},
                   {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {3, 5, 4}});
}

TEST(WallPeriodicMotion, AValleyAndARidgeAtTheSideAreThoseInTheMiddle) {
  const Vec3 by{k_side / 2, 0, 0};
  for (const bool ridge : {false, true}) {
    Scene side = cube("x"), middle = cube("x");
    for (Scene* s : {&side, &middle}) {
      s->gravity = {0, 0, -9.81};
      linear_restitution(*s, 2e4, 0.5, 5.7e3, 0.3);
    }
    side.walls = {mesh("floor", valley(!ridge))};
    middle.walls = {mesh("floor", valley(ridge))};
    const Vec3 x{0.0009765625, 0.0625, ridge ? 0.09 : 0.03};
    add_grains(side, {{x, {}, k_radius}, {x + Vec3{-0.00390625 + k_side, 0.03, 0.01}, {}, k_radius}});
    add_grains(middle, {{x + by, {}, k_radius}, {x + by + Vec3{-0.00390625, 0.03, 0.01}, {}, k_radius}});
    EXPECT_GT(expect_same(side, middle, by, std::nullopt, 40000, 1e-7), 100);
  }
}

// Rolling, a grain carries the spring of its contact through the side: a lost one would show as a jump of its spin.
TEST(WallPeriodicMotion, RollingThroughSidesIsRollingOnAPlane) {
  const double height = 0.03125;
  Scene on_mesh = cube("xy"), on_plane = cube("xy");
  for (Scene* s : {&on_mesh, &on_plane}) {
    s->gravity = {1, 0.3, -9.81};
    linear_restitution(*s, 2e4, 0.3, 5.7e3, 0.5);
    add_grains(*s, {{{0.05, 0.1, height + k_radius - 1e-6}, {0.8, 0.5, 0}, k_radius, {-100, 160, 0}},
                    {{0.02, 0.06, height + k_radius - 1e-6}, {-1, 0.2, 0}, k_radius}});
  }
  on_mesh.walls = {mesh("floor", flat_mesh(0, k_side, 0, k_side, 1, 2), {0.046875, 0, height})};
  on_plane.walls = {plane("floor", {0, 0, height}, {0, 0, 1})};
  Simulation a(on_mesh, options()), b(on_plane, options());
  int crossings = 0;
  Vec3 last = a.frame().x[0];
  for (int k = 0; k < 6000; ++k) {
    a.run(20);
    b.run(20);
    const Frame f = a.frame(), g = b.frame();
    ASSERT_EQ(a.counters().wall_contacts, b.counters().wall_contacts);
    for (std::size_t q = 0; q < 2; ++q) {
      ASSERT_LT(norm(nearest(on_mesh, f.x[q] - g.x[q])), 1e-9 * k_radius) << a.step();
      ASSERT_LT(norm(f.v[q] - g.v[q]), 1e-9);
      ASSERT_LT(norm(f.w[q] - g.w[q]) * k_radius, 1e-9);
    }
    crossings += norm(f.x[0] - last) > 0.5 * k_side ? 1 : 0;
    last = f.x[0];
  }
  EXPECT_GE(crossings, 5);
}

// A grain that flies at a block through the side: it bounces off the face as in the middle (e = 1).
TEST(WallPeriodicMotion, ABlockAtTheSideThrowsBackWhatComesThroughIt) {
  for (const double end : {k_side, k_side - 0.002, k_side + 0.01}) {
    Scene s = cube("x");
    linear_restitution(s, 2e4, 1);
    s.walls = {box("block", {end - 0.02, 0.02, 0.02}, {end, 0.1, 0.1})};
    add_grains(s, {{{0.03125, 0.05, 0.05}, {-0.5, 0, 0}, k_radius}});
    Simulation sim(s, options());
    sim.run(20000);
    const Frame f = sim.frame();
    EXPECT_NEAR(f.v[0].x, 0.5, 5e-5) << end;
    EXPECT_EQ(f.v[0].y, 0);
    // there and back at 0.5 m/s, less the time of the contact: pi sqrt(m/k) beyond that of a rigid impact
    const double path = 0.03125 - (end - k_side) - k_radius;
    const double contact = k_pi * std::sqrt(sphere_mass(2500, k_radius) / 2e4);
    const double back = 0.5 * (0.1 - path / 0.5 - contact);
    EXPECT_NEAR(f.x[0].x, wrapped(s, {end + k_radius + back, 0, 0}).x, 2e-6) << end;
  }
}

}  // namespace
}  // namespace talus::physics
