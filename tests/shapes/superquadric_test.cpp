// Volume, inertia, bounding radius, curvature and inside-outside of superquadrics.
#include "core/shapes/superquadric.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "tests/shapes/shape_support.hpp"

namespace talus::shapes {
namespace {
using testing::Draw;
using testing::gauge;

TEST(Superquadric, MassPropertiesMatchTheTable) {
  EXPECT_NEAR(volume({{1, 1, 1}, 2, 2}), 4 * M_PI / 3, 1e-13);
  EXPECT_NEAR(inertia({{1, 1, 1}, 2, 2}).x, 8 * M_PI / 15, 1e-13);
  const Vec3 e = inertia({{2, 1, 1}, 2, 2});
  EXPECT_NEAR(e.x, 16 * M_PI / 15, 1e-12);
  EXPECT_NEAR(e.y, 8 * M_PI / 3, 1e-12);
  EXPECT_NEAR(e.z, 8 * M_PI / 3, 1e-12);
  const Superquadric cube{{1, 1, 1}, 4, 4}, bar{{1.5, 1, 1}, 4, 4};
  EXPECT_NEAR(volume(cube), 6.481987, 1e-6);
  EXPECT_NEAR(inertia(cube).x / volume(cube), 0.548336, 1e-6);
  EXPECT_NEAR(volume(bar), 9.722981, 1e-6);
  EXPECT_NEAR(inertia(bar).x / volume(bar), 0.548336, 1e-6);
  EXPECT_NEAR(inertia(bar).y / volume(bar), 0.891046, 1e-6);
  EXPECT_NEAR(inertia(bar).z / volume(bar), 0.891046, 1e-6);
}

TEST(Superquadric, MassPropertiesAgreeWithAQuadratureForUnequalExponents) {
  const Superquadric s{{1.3, 0.7, 0.4}, 3, 7};
  // Volume element of a star-shaped body: r^3 / 3 d(solid angle), r = 1 / gauge.
  double v = 0, ix = 0, iz = 0;
  const int n = 600;
  for (int i = 0; i < n; ++i) {
    const double z = -1 + (2 * i + 1.0) / n;
    for (int k = 0; k < n; ++k) {
      const double phi = 2 * M_PI * (k + 0.5) / n, rho = std::sqrt(1 - z * z);
      const Vec3 u{rho * std::cos(phi), rho * std::sin(phi), z};
      const double r = 1 / gauge(s, u), r3 = r * r * r;
      v += r3 / 3;
      ix += r3 * r * r / 5 * (u.y * u.y + u.z * u.z);
      iz += r3 * r * r / 5 * (u.x * u.x + u.y * u.y);
    }
  }
  const double cell = 4 * M_PI / n / n;
  EXPECT_NEAR(volume(s), v * cell, 1e-4 * volume(s));
  EXPECT_NEAR(inertia(s).x, ix * cell, 1e-4 * inertia(s).x);
  EXPECT_NEAR(inertia(s).z, iz * cell, 1e-4 * inertia(s).z);
}

TEST(Superquadric, BoundingRadiusIsTheFarthestPoint) {
  EXPECT_NEAR(bounding_radius({{1, 1, 1}, 2, 4}), std::pow(2.0, 0.25), 1e-14);
  EXPECT_NEAR(bounding_radius({{1, 1, 1}, 4, 4}), std::pow(3.0, 0.25), 1e-14);
  EXPECT_NEAR(bounding_radius({{3, 2, 1}, 4, 4}), std::pow(98.0, 0.25), 1e-13);
  Draw draw(3);
  for (int k = 0; k < 40; ++k) {
    const Superquadric s = draw.shape(2, 20, 10);
    const double r = bounding_radius(s);
    double far = 0;  // the support function's maximum is the bounding radius
    for (int t = 0; t < 8000; ++t) far = std::max(far, support_point(s, draw.direction()).h);
    EXPECT_LE(far, r * (1 + 2e-9));
    EXPECT_GE(far, r * (1 - 5e-2));
  }
}

TEST(Superquadric, SupportPointsLieOnTheSurfaceAndAreTheFarthestAlongTheirNormal) {
  Draw draw(4);
  for (int k = 0; k < 3000; ++k) {
    const Superquadric s = draw.shape(2, 20, 10);
    const Vec3 m = k % 2 == 0 ? draw.direction() : testing::normal_of_random_point(s, draw);
    const SupportPoint p = support_point(s, m);
    EXPECT_NEAR(gauge(s, p.point), 1, 1e-8);
    EXPECT_NEAR(dot(p.point, m), p.h, 1e-14);
    EXPECT_NEAR(inside_outside(s, p.point), std::pow(gauge(s, p.point), s.n1) - 1, 1e-12);
    const Vec3 u = draw.direction();
    EXPECT_LE(dot((1 / gauge(s, u)) * u, m), p.h + 1e-14);
  }
}

TEST(Superquadric, RadiiOfCurvatureAreTheDerivativeOfTheSupportPoint) {
  const Radii pole = radii_of_curvature({{2, 3, 0.5}, 2, 2}, {0, 0, 1});
  EXPECT_NEAR(pole.small, 8, 1e-12);
  EXPECT_NEAR(pole.large, 18, 1e-12);
  Draw draw(5);
  for (int k = 0; k < 60; ++k) {
    const Superquadric s = draw.shape(2, 8, 3);
    const Vec3 m = draw.direction();
    if (std::min({std::fabs(m.x), std::fabs(m.y), std::fabs(m.z)}) < 0.1) continue;  // differences need room
    const Tangents<Plain> t = tangents<Plain>({m.x, m.y, m.z});
    const double h = 1e-5;
    double j[2][2];
    const Vec3 axis[2] = {{t.u.x, t.u.y, t.u.z}, {t.v.x, t.v.y, t.v.z}};
    for (int a = 0; a < 2; ++a) {
      const Vec3 up = m + h * axis[a], down = m - h * axis[a];
      const Vec3 d =
          (0.5 / h) * (support_point(s, (1 / norm(up)) * up).point - support_point(s, (1 / norm(down)) * down).point);
      for (int b = 0; b < 2; ++b) j[a][b] = dot(d, axis[b]);
    }
    const Radii r = radii_of_curvature(s, m);
    EXPECT_NEAR(j[0][0] + j[1][1], r.small + r.large, 1e-6 * r.large);
    EXPECT_NEAR(j[0][0] * j[1][1] - j[0][1] * j[1][0], r.small * r.large, 1e-6 * r.large * r.large);
    EXPECT_GE(r.small, smallest_radius(s));
  }
}

TEST(Superquadric, RadiusForHertzIsTheSpheresAndFiniteOnAFace) {
  EXPECT_NEAR(hertz_radius(radii_of_curvature({{3, 3, 3}, 2, 2}, {0.6, 0, 0.8}), 6), 3, 1e-12);
  const Superquadric cube{{1, 1, 1}, 20, 20};
  EXPECT_GT(radii_of_curvature(cube, {0, 0, 1}).small, 1e5);
  EXPECT_LT(hertz_radius(radii_of_curvature(cube, {0, 0, 1}), 2), 10);
  const double flat = 2;
  for (const double e : {1e-3, 1e-5, 1e-7}) {  // value and slope have no step at the limit
    const double below = hertz_radius({flat - e, flat - e}, flat), above = hertz_radius({flat + e, flat + e}, flat);
    EXPECT_NEAR(above - below, 2 * e, e * e);
  }
}

TEST(Superquadric, BadShapesAreRefused) {
  const auto refused = [](const Superquadric& s) {
    try {
      check(s, "shape 'x'");
    } catch (const Error& e) {
      return e.code() == ErrorCode::scene && std::string(e.what()).find("shape 'x'") != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refused({{1, 1, 0}, 2, 2}));
  EXPECT_TRUE(refused({{1, -1, 1}, 2, 2}));
  EXPECT_TRUE(refused({{1, NAN, 1}, 2, 2}));
  EXPECT_TRUE(refused({{1, 1, 1}, 1.9, 2}));
  EXPECT_TRUE(refused({{1, 1, 1}, 2, 21}));
  EXPECT_TRUE(refused({{1, 1, 1}, 2, NAN}));
  EXPECT_TRUE(refused({{1000, 1, 1}, 2, 2}));
  EXPECT_FALSE(refused({{10, 1, 1}, 20, 2}));
}

TEST(Powers, AgreeWithTheCLibraryToAFewUnitsInTheLastPlace) {
  Draw draw(6);
  for (int k = 0; k < 20000; ++k) {
    const double x = std::exp(draw.uniform(-80, 20)), y = draw.uniform(0.4, 2.5);
    const double want = std::pow(x, y);
    EXPECT_NEAR(power<Plain>(x, y), want, want * 2.5e-16 * (2 + std::fabs(y * std::log(x))));
  }
  EXPECT_EQ(power<Plain>(0.3, 1), 0.3);
  EXPECT_EQ(power<Plain>(0.3, 0.5), std::sqrt(0.3));
}

}  // namespace
}  // namespace talus::shapes
