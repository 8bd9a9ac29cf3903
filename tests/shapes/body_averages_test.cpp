// Averages over bodies that are no spheres: their volume in regions and cells beside closed forms and other ways of
// integration; sums over a bed.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "core/frame/averages.hpp"
#include "core/frame/body_shares.hpp"
#include "core/gas/overlap.hpp"
#include "core/grains/body_shape.hpp"
#include "core/grains/region.hpp"
#include "core/scene/scene_file.hpp"
#include "tests/shapes/body_support.hpp"

namespace talus {
namespace {

constexpr double k_pi = std::numbers::pi;
// N = 8192 rays of a body err by some N^(-3/4) where a side passes their centre, elsewhere by less.
const double k_rays = std::pow(8192, -0.75);

Scene scene_of(const std::string& shape, const std::string& boundary = "\"open\"", const std::string& rest = {}) {
  return parse_scene("gravity = [0, 0, 0]\n[domain]\nlower = [-5, -5, -5]\nupper = [5, 5, 5]\nboundary = " + boundary +
                         "\n[time]\nstep = 1e-6\nduration = 1\n[[material]]\nname = \"m\"\ndensity = 1\n[contact]\n"
                         "normal_stiffness = 1\nrestitution = 1\nfriction = 0\n[[shape]]\nname = \"s\"\n" +
                         shape + "\n" +
                         (rest.empty() ? source("q", 1, "[-4, -4, -4]", "[4, 4, 4]", "shape = \"s\"") : rest),
                     "test", "", {});
}
std::string quadric(const std::string& axes, const std::string& exponents = "[2, 2]") {
  return "kind = \"superquadric\"\nsemi_axes = " + axes + "\nexponents = " + exponents;
}

BodyRecord body_at(Vec3 x, shapes::Quaternion q = {}, double scale = 1) {
  BodyRecord b;
  b.x = x;
  b.scale = scale;
  q = normalised(q);
  b.orientation = {q.w, q.x, q.y, q.z};
  return b;
}
const shapes::Quaternion k_turns[] = {{1, 0, 0, 0}, {0.8, 0.3, -0.5, 0.1}, {0.2, -0.7, 0.4, 0.6}};

/// Of a ball below a plane at t radii above its centre.
double below(double t) { return t <= -1 ? 0 : t >= 1 ? 1 : 0.25 * (2 + 3 * t - t * t * t); }

double integral(double from, double to, const std::function<double(double)>& f) {
  constexpr int n = 20000;
  double sum = 0;
  for (int k = 0; k < n; ++k) sum += f(from + (k + 0.5) * (to - from) / n);
  return sum * (to - from) / n;
}

TEST(BodyShares, APlaneCutsAnEllipsoidAsItCutsABall) {
  const Scene s = scene_of(quadric("[1, 0.5, 0.3]"));
  const BodyShares shares(s);
  for (const shapes::Quaternion& q : k_turns)
    for (const double scale : {1.0, 0.7})
      for (const double height : {-0.6, -0.2, -0.05, 0.0, 0.13, 0.4}) {
        const BodyRecord b = body_at({0.3, -0.2, 0.1}, q, scale);
        const Vec3 z = shapes::rotation(normalised(q)).row[2];
        const double h = scale * std::sqrt(z.x * z.x + 0.25 * z.y * z.y + 0.09 * z.z * z.z);
        const double share = shares.inside(s.domain, {{-5, -5, -5}, {5, 5, 0.1 + height * h}, 0}, b);
        EXPECT_NEAR(share, below(height), height == 0 ? 1e-12 : k_rays) << height << scale;
      }
}

TEST(BodyShares, ABoxCutsAnEllipsoidAlongItAsItsImageCutsABall) {
  const Scene s = scene_of(quadric("[1, 0.5, 0.3]"));
  const BodyShares shares(s);
  const Vec3 corners[] = {{0.1, 0.1, 0.05}, {-0.4, 0.2, -0.1}, {0.6, -0.3, -0.2}};
  for (const Vec3& c : corners) {
    const double share = shares.inside(s.domain, {c, c + Vec3{0.7, 0.6, 0.5}, 0}, body_at({}));
    const Vec3 low{c.x / 1, c.y / 0.5, c.z / 0.3}, high{(c.x + 0.7) / 1, (c.y + 0.6) / 0.5, (c.z + 0.5) / 0.3};
    EXPECT_NEAR(share, gas::ball_in_box({}, 1, low, high) / (4 * k_pi / 3), k_rays);
  }
}

TEST(BodyShares, RoundRegionsHoldWhatTheirClosedFormsSay) {
  const Scene s = scene_of(quadric("[1, 1, 0.4]"));
  const BodyShares shares(s);
  const double R = 0.7, a = 1, c = 0.4, volume = 4 * k_pi / 3 * a * a * c;
  const double bored = 1 - std::pow(1 - R * R, 1.5);  // of a ball by a cylinder through its centre
  Region upright{{-R, -R, -2}, {R, R, 2}, R};
  EXPECT_NEAR(shares.inside(s.domain, upright, body_at({})), bored, k_rays);
  Region tube;
  tube.shape = Region::Shape::cylinder;
  tube.axis = shapes::to_space(shapes::rotation(normalised(k_turns[1])), {0, 0, 1});
  tube.point = Vec3{0.1, 0.2, 0.3} - 2 * tube.axis;
  tube.length = 4;
  tube.radius = R;
  set_bounds(tube);
  EXPECT_NEAR(shares.inside(s.domain, tube, body_at({0.1, 0.2, 0.3}, k_turns[1])), bored, k_rays);
  Region ball;
  ball.shape = Region::Shape::sphere;
  ball.radius = R;
  set_bounds(ball);
  const double z = std::sqrt((a * a - R * R) / (a * a / (c * c) - 1));  // where both surfaces meet
  const double in =
      2 * k_pi * ((R * R * z - z * z * z / 3) + a * a * ((c - z) - (c * c * c - z * z * z) / (3 * c * c)));
  EXPECT_NEAR(shares.inside(s.domain, ball, body_at({}, k_turns[2])), in / volume, k_rays);
}

/// An upright box, nearly: |x|^20 + |y|^20 + |z|^20 = 1 by lines along x.
TEST(BodyShares, AnEdgedBodyHasTheVolumeOfItsSections) {
  const Scene s = scene_of(quadric("[1, 1, 1]", "[20, 20]"));
  const BodyShares shares(s);
  // the area of |x|^20 + |y|^20 = w is that of w = 1 times w^(1/10)
  const auto area = [](double z) { return std::pow(1 - std::pow(std::fabs(z), 20), 0.1); };
  const double all = integral(-1, 1, area);
  for (const double height : {-0.95, -0.5, 0.2, 0.8, 0.97})
    EXPECT_NEAR(shares.inside(s.domain, {{-5, -5, -5}, {5, 5, height}, 0}, body_at({})),
                integral(-1, height, area) / all, k_rays)
        << height;
}

TEST(BodyShares, WhatSpheresOfAClumpShareCountsOnce) {
  // spheres of radii 1 and 0.7 whose centres are 1.1 apart: a body of revolution
  const Scene s = scene_of("spheres = [0, 0, 0, 1, 0, 0, 1.1, 0.7]");
  const BodyShares shares(s);
  const auto radius2 = [](double z) { return std::fmax(0, std::fmax(1 - z * z, 0.49 - (z - 1.1) * (z - 1.1))); };
  const double volume = k_pi * integral(-1, 1.8, radius2);
  EXPECT_NEAR(shares.volume(body_at({})) / volume, 1, 1e-6);
  const BodyShape& shape = *s.shapes[0].body;
  // the first sphere of the scene lies at the origin
  const Vec3 first = shapes::to_space(shapes::rotation(shape.turn), shape.spheres[0].x);
  const BodyRecord b = body_at(-first);
  for (const double height : {-0.7, 0.0, 0.6, 0.8, 1.0, 1.5})
    EXPECT_NEAR(shares.inside(s.domain, {{-5, -5, -5}, {5, 5, height}, 0}, b),
                k_pi * integral(-1, height, radius2) / volume, k_rays)
        << height;
  for (const double side : {-0.8, -0.3, 0.0, 0.4, 0.9}) {
    const auto segment = [&](double z) {  // of a disc, below x = side
      const double r = std::sqrt(radius2(z)), t = r > 0 ? std::fmax(-1, std::fmin(1, side / r)) : 0;
      return r * r * (k_pi - std::acos(t) + t * std::sqrt(1 - t * t));
    };
    EXPECT_NEAR(shares.inside(s.domain, {{-5, -5, -5}, {side, 5, 5}, 0}, b), integral(-1, 1.8, segment) / volume,
                k_rays)
        << side;
  }
}

TEST(BodyShares, SpheresThatNoOtherOverlapsCountAsSpheres) {
  const Scene s = scene_of("spheres = [0, 0, -0.5, 0.5, 0, 0, 0.5, 0.5]");
  const BodyShares shares(s);
  const BodyRecord b = body_at({0.1, 0.2, 0.3}, k_turns[1]);
  const Vec3 way = shapes::to_space(shapes::rotation(normalised(k_turns[1])), {0, 0, 0.5});
  const Region g{{0, 0, 0}, {0.9, 0.6, 0.8}, 0};
  const double wanted = 0.5 * (share_inside(s.domain, g, b.x + way, 0.5) + share_inside(s.domain, g, b.x - way, 0.5));
  EXPECT_NEAR(shares.inside(s.domain, g, b), wanted, 1e-12);
}

TEST(BodyShares, CellsHoldABodyOnceAndWhatRegionsSay) {
  for (const std::string& shape :
       {quadric("[1, 0.5, 0.3]"), quadric("[0.8, 0.6, 0.7]", "[8, 4]"),
        std::string("spheres = [0, 0, 0, 0.6, 0.5, 0, 0, 0.5, 0, 0.4, 0.1, 0.5, 0, 0, -0.9, 0.3]")}) {
    const Scene s = scene_of(shape);
    const BodyShares shares(s);
    const ShareGrid grid{{-5, -5, -5}, {0.5, 0.4, 10}, {-1, -1, -1}, {20, 25, 1}};
    for (const shapes::Quaternion& q : k_turns) {
      const BodyRecord b = body_at({0.11, -0.23, 0.37}, q);
      std::vector<CellShare> cells;
      shares.cells(grid, b, cells);
      ASSERT_GT(cells.size(), 4U);
      double all = 0, one = 0;
      for (const CellShare& c : cells) {
        all += c.share;
        if (c.at == std::array<int, 3>{10, 12, 0}) one += c.share;
      }
      EXPECT_NEAR(all, 1, 1e-12) << shape;
      const double region = shares.inside(s.domain, {{0, -0.2, -5}, {0.5, 0.2, 5}, 0}, b);
      EXPECT_NEAR(one, region, 1e-9) << shape << ": the same rays";
      EXPECT_EQ(shares.inside(s.domain, {{-2, -2, -2}, {2, 2, 2}, 0}, b), [&] {
        double whole = 0;  // pieces in their order
        shares.cells({{-5, -5, -5}, {10, 10, 10}, {-1, -1, -1}, {1, 1, 1}}, b, cells);
        for (const CellShare& c : cells) whole += c.share;
        return whole;
      }());
    }
  }
}

TEST(BodyShares, ABodyAcrossAPeriodicSideIsWholeAndWrapped) {
  const Scene s = scene_of(quadric("[1, 0.5, 0.3]"), "\"periodic\"");
  const BodyShares shares(s);
  const BodyRecord edge = body_at({4.9, -4.8, 5.0}, k_turns[1]), middle = body_at({0, 0, 0}, k_turns[1]);
  EXPECT_NEAR(shares.inside(s.domain, {{-5, -5, -5}, {5, 5, 5}, 0}, edge), 1, 1e-12);
  // the corner region at its centre, beside that of the body in the middle
  const double here = shares.inside(s.domain, {{-5.0, -5, -5}, {-4.5, -4.5, -4.5}, 0}, edge);
  const double there = shares.inside(s.domain, {{0.1, -0.2, 0}, {0.6, 0.3, 0.5}, 0}, middle);
  EXPECT_GT(there, 0.01);
  EXPECT_NEAR(here, there, 1e-9);
}

TEST(BodyShares, AMeshCountsPoints) {
  const Scene s = scene_of(quadric("[1, 0.5, 0.3]"));
  const BodyShares shares(s);
  const auto path = std::filesystem::temp_directory_path() / fmt::format("talus_shares_{}.obj", getpid());
  std::ofstream(path) << "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 2 2\nv 0 2 2\n"
                         "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\n"
                         "f 4 1 5\nf 4 5 8\n";
  Region mesh;
  mesh.shape = Region::Shape::mesh;
  mesh.file = path.string();
  load_region(mesh, "", "test");
  std::filesystem::remove(path);
  for (const Vec3& x : {Vec3{0.1, 0.1, 0.1}, Vec3{0.5, -0.1, 0.3}, Vec3{1, 1, 1.9}}) {
    const BodyRecord b = body_at(x, k_turns[1]);
    EXPECT_NEAR(shares.inside(s.domain, mesh, b), shares.inside(s.domain, {{0, 0, 0}, {2, 2, 2}, 0}, b), 0.01);
  }
  EXPECT_EQ(shares.inside(s.domain, mesh, body_at({1, 1, 1}, k_turns[1], 0.5)), 1);
  EXPECT_EQ(shares.inside(s.domain, mesh, body_at({-2, 1, 1}, k_turns[1], 0.5)), 0);
}

/// Lentils, clumps and spheres together: one grain each, with its true mass and volume.
TEST(BodyAverages, OfTheWholeDomainAreTheSumsOverAllGrains) {
  const std::string rest = "[[shape]]\nname = \"rod\"\nspheres = [0, 0, -0.2, 0.3, 0, 0, 0.2, 0.3]\n" +
                           source("a", 12, "[-5, -5, -5]", "[5, 5, 5]", "shape = \"s\"\nvelocity_jitter = 0.5") +
                           source("b", 9, "[-5, -5, -5]", "[5, 5, 5]", "shape = \"rod\"\nvelocity = [1, 2, 3]") +
                           source("c", 7, "[-5, -5, -5]", "[5, 5, 5]", "velocity_jitter = 0.5", "0.4");
  Scene s = scene_of(quadric("[0.6, 0.6, 0.3]"), "\"periodic\"", rest);
  Simulation sim(s, {});
  const Frame f = sim.frame();
  ASSERT_EQ(f.bodies.size(), 21U);
  double mass = 0, volume = 0, spread = 0;
  Vec3 momentum;
  const auto each = [&](const std::function<void(double, double, Vec3)>& fn) {
    for (const BodyRecord& b : f.bodies) fn(b.mass, b.mass, b.v);  // of density 1
    for (std::size_t i = 0; i < f.x.size(); ++i)
      if (f.r[i] == 0.2) fn(4 * k_pi / 3 * 0.008, 4 * k_pi / 3 * 0.008, f.v[i]);
  };
  each([&](double m, double v, Vec3 u) { mass += m, volume += v, momentum = momentum + m * u; });
  const Vec3 mean = (1 / mass) * momentum;
  each([&](double m, double, Vec3 u) { spread += m * norm2(u - mean); });
  const RegionAverage a = average_region(f, s, {{-5, -5, -5}, {5, 5, 5}, 0});
  EXPECT_NEAR(a.particles, 28, 1e-11);
  EXPECT_NEAR(a.solid_fraction * 1000 / volume, 1, 1e-12);
  EXPECT_LT(norm(a.velocity - mean), 1e-12 * norm(mean));
  EXPECT_NEAR(a.temperature / (spread / (3 * mass)), 1, 1e-12);
  const GridData one = average_grid(f, s, {1, 1, 1}), many = average_grid(f, s, {4, 5, 6});
  EXPECT_NEAR(std::get<0>(one.cell_data[0].values)[0], a.solid_fraction, 1e-14);
  double total = 0;
  for (const double x : std::get<0>(many.cell_data[0].values)) total += x / 120;
  EXPECT_NEAR(total / a.solid_fraction, 1, 1e-12);
}

}  // namespace
}  // namespace talus
