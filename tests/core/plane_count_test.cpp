// Flux planes: sides, periodic axes and totals against geometry worked out apart from them.
#include "core/frame/plane_count.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/base/rng.hpp"
#include "core/scene/scene_file.hpp"

namespace talus {
namespace {

/// A box of 1 x 0.5 x 2 m at a corner that is not the origin; periodic on the axes named.
Domain box(const std::string& periodic = "") {
  Domain d;
  d.lower = {-0.25, 3, 0.125};
  d.upper = d.lower + Vec3{1, 0.5, 2};
  for (int k = 0; k < 3; ++k) {
    const bool p = periodic.find("xyz"[k]) != std::string::npos;
    d.boundary[static_cast<std::size_t>(k)] = {p ? Boundary::periodic : Boundary::open,
                                               p ? Boundary::periodic : Boundary::open};
  }
  return d;
}

/// `at` relative to the lower corner.
CountedPlane plane(const Domain& d, Vec3 at, Vec3 normal) { return {d, {"p", d.lower + at, normal}}; }

int step(const CountedPlane& p, Vec3 from, Vec3 to) {
  const double a[4] = {from.x, from.y, from.z, 0.1}, b[4] = {to.x, to.y, to.z, 0.1};
  return p.passages(a, b);
}

TEST(PlaneCount, CountsAlongTheNormalAndAgainstIt) {
  const Domain d = box();
  const CountedPlane up = plane(d, {0, 0, 0.5}, {0, 0, 1}), down = plane(d, {0, 0, 0.5}, {0, 0, -1});
  EXPECT_EQ(step(up, {0.5, 0.2, 0.4}, {0.5, 0.2, 0.6}), 1);
  EXPECT_EQ(step(down, {0.5, 0.2, 0.4}, {0.5, 0.2, 0.6}), -1);
  EXPECT_EQ(step(up, {0.5, 0.2, 0.6}, {0.1, 0.4, 0.4}), -1);
  EXPECT_EQ(step(up, {0.5, 0.2, 0.1}, {0.5, 0.2, 0.4}), 0);
}

TEST(PlaneCount, AGrainThatStopsOnThePlaneIsCountedOnceForBothNormals) {
  const Domain d = box();
  for (const double sign : {1.0, -1.0})
    for (const Vec3 n : {Vec3{0, 0, 1}, Vec3{0, 0.6, 0.8}}) {
      const CountedPlane p = plane(d, {0.5, 0.25, 0.5}, sign * n);
      const Vec3 on{0.5, 0.25, 0.5}, below{0.5, 0.25, 0.25}, above{0.5, 0.25, 0.75};
      EXPECT_EQ(step(p, below, on), static_cast<int>(sign)) << "reaching it from below is passing";
      EXPECT_EQ(step(p, on, above), 0);
      EXPECT_EQ(step(p, above, on), 0) << "from above it is not";
      EXPECT_EQ(step(p, on, below), -static_cast<int>(sign));
      EXPECT_EQ(step(p, on, on), 0);
    }
}

TEST(PlaneCount, APlaneInAnOpenSideCountsWhatLeavesThere) {
  const Domain d = box();
  // the domain is [0, size): at size a grain has left, at 0 it has not
  EXPECT_EQ(step(plane(d, {0, 0, 2}, {0, 0, 1}), {0, 0, 1.9}, {0, 0, 2}), 1);
  EXPECT_EQ(step(plane(d, {0, 0, 2}, {0, 0, -1}), {0, 0, 1.9}, {0, 0, 2}), -1);
  EXPECT_EQ(step(plane(d, {}, {0, 0, -1}), {0, 0, 0.1}, {0, 0, -1e-9}), 1);
  EXPECT_EQ(step(plane(d, {}, {0, 0, -1}), {0, 0, 0.1}, {0, 0, 0}), 0);
}

TEST(PlaneCount, AcrossAPeriodicAxisAPlaneCountsOncePerRoundWhereverItIs) {
  const Domain d = box("x");
  for (const double at : {0.0, 1e-12, 0.02, 0.3, 0.5, 0.97, 1 - 1e-12, 1.0})
    for (const double way : {0.3, -0.3, 0.0625, -0.0625, 0.499}) {
      const CountedPlane p = plane(d, {at, 0, 0}, {1, 0, 0}), back = plane(d, {at, 0, 0}, {-1, 0, 0});
      double x = 0.25, unwrapped = 0.25;
      std::int64_t net = 0, against = 0;
      for (int k = 0; k < 1000; ++k) {
        double to = x + way;
        if (to < 0) to = to + 1;
        if (!(to < 1)) to = to - 1;
        net += step(p, {x, 0.2, 1}, {to, 0.2, 1});
        against += step(back, {x, 0.2, 1}, {to, 0.2, 1});
        x = to;
        unwrapped += way;
      }
      // planes at `at` + whole periods between start and end; where both are within rounding of one, either is right
      const double rounds = std::floor(unwrapped - at) - std::floor(0.25 - at);
      const double rest = std::abs(unwrapped - at - std::round(unwrapped - at));
      EXPECT_NEAR(static_cast<double>(net), rounds, rest < 1e-9 ? 1 : 0) << at << ", " << way;
      EXPECT_EQ(net, -against);
    }
}

TEST(PlaneCount, AWrapBesideAPlaneAlongTheAxisIsNoPassage) {
  const CountedPlane p = plane(box("xy"), {0, 0, 0.5}, {0, 0, 1});
  EXPECT_EQ(step(p, {0.95, 0.45, 0.4}, {0.05, 0.05, 0.45}), 0);
  EXPECT_EQ(step(p, {0.95, 0.45, 0.4}, {0.05, 0.05, 0.55}), 1);
}

/// Where the unwrapped way from `a` by `way` meets the images of the plane, each within its own image of the box.
int met(const Domain& d, Vec3 point, Vec3 normal, Vec3 a, Vec3 way) {
  const Vec3 size = d.upper - d.lower;
  int net = 0;
  int from[3], to[3];
  for (int k = 0; k < 3; ++k) {
    from[k] = d.periodic(k) ? -1 : 0;
    to[k] = d.periodic(k) ? 1 : 0;
  }
  for (int i = from[0]; i <= to[0]; ++i)
    for (int j = from[1]; j <= to[1]; ++j)
      for (int k = from[2]; k <= to[2]; ++k) {
        const Vec3 corner{i * size.x, j * size.y, k * size.z};
        const double speed = dot(normal, way), t = dot(normal, point + corner - a) / speed;
        if (!(t >= 0 && t < 1)) continue;
        bool inside = true;
        for (int q = 0; q < 3; ++q) {
          const double x = a[q] + t * way[q] - corner[q];
          inside = inside && (!d.periodic(q) || (x >= 0 && x < size[q]));
        }
        if (inside) net += speed > 0 ? 1 : -1;
      }
  return net;
}

TEST(PlaneCount, AnObliquePlaneCountsWhatMeetsItsPartInTheBoxAlsoInStepsThroughSidesAndCorners) {
  int passed = 0, wrapped_and_passed = 0;
  const CounterRng rng(11, 0);
  const auto uniform = [&rng](int k, int c) { return rng.uniform(static_cast<std::uint64_t>(16 * k + c)); };
  for (const char* axes : {"x", "xy", "xyz", "z"}) {
    const Domain d = box(axes);
    const Vec3 size = d.upper - d.lower;
    for (int k = 0; k < 20000; ++k) {
      Vec3 a, way, b, point, normal;
      bool wrapped = false;
      for (int q = 0; q < 3; ++q) {
        a[q] = size[q] * uniform(k, q);
        point[q] = size[q] * uniform(k, q + 3);
        normal[q] = uniform(k, q + 6) - 0.5;
        way[q] = 0.9 * size[q] * (uniform(k, q + 9) - 0.5);
        b[q] = a[q] + way[q];
        if (!d.periodic(q)) continue;
        wrapped = wrapped || b[q] < 0 || b[q] >= size[q];
        if (b[q] < 0) b[q] += size[q];
        if (b[q] >= size[q]) b[q] -= size[q];
      }
      normal = (1 / norm(normal)) * normal;
      const int expected = met(d, point, normal, a, way);
      ASSERT_EQ(step(plane(d, point, normal), a, b), expected) << axes << " " << k;
      passed += expected != 0 ? 1 : 0;
      wrapped_and_passed += expected != 0 && wrapped ? 1 : 0;
    }
  }
  EXPECT_GT(passed, 10000);
  EXPECT_GT(wrapped_and_passed, 3000);
}

Scene with_planes(std::vector<OutputSettings::Plane> planes) {
  Scene s;
  s.domain = box();
  s.output.flux_planes = std::move(planes);
  return s;
}

TEST(PlaneCount, TotalsAreSignedSurviveACheckpointAndCanBeTakenBack) {
  PlaneCounts counts(with_planes({{"a", {0, 3, 1}, {0, 0, 1}}, {"b", {0, 3, 1.5}, {0, 0, 1}}}));
  counts.begin_step();
  counts.add(0, 1, 2.0);
  counts.add(0, -1, 0.5);
  counts.add(1, 1, 4.0);
  EXPECT_EQ(counts.totals()[0].particles(), 0);
  EXPECT_EQ(counts.totals()[0].forward, 1);
  EXPECT_EQ(counts.totals()[0].backward, 1);
  EXPECT_EQ(counts.totals()[0].mass, 1.5);
  const std::uint64_t hash = counts.hash();
  // the planes of the next scene: one as before, one new, one left out
  PlaneCounts next(with_planes({{"new", {0, 3, 0.5}, {0, 0, 1}}, {"a", {0, 3, 1}, {0, 0, 1}}}));
  next.load(counts.save(), "file");
  EXPECT_EQ(next.totals()[0].forward, 0);
  EXPECT_EQ(next.totals()[1].mass, 1.5);
  PlaneCounts same(with_planes({{"a", {0, 3, 1}, {0, 0, 1}}, {"b", {0, 3, 1.5}, {0, 0, 1}}}));
  EXPECT_NE(same.hash(), hash);
  same.load(counts.save(), "file");
  EXPECT_EQ(same.hash(), hash);
  same.begin_step();
  same.add(1, 1, 1);
  EXPECT_NE(same.hash(), hash);
  same.take_back();
  EXPECT_EQ(same.hash(), hash);
}

TEST(PlaneCount, RefusesADamagedSectionAndAPlaneThatHasMoved) {
  PlaneCounts counts(with_planes({{"a", {0, 3, 1}, {0, 0, 1}}}));
  const std::vector<std::uint8_t> bytes = counts.save();
  for (std::size_t n = 1; n < bytes.size(); ++n)
    EXPECT_THROW(counts.load(std::span(bytes).first(n), "file"), Error) << n << " bytes";
  for (const OutputSettings::Plane& other :
       {OutputSettings::Plane{"a", {0, 3, 1.25}, {0, 0, 1}}, OutputSettings::Plane{"a", {0, 3, 1}, {0, 0, -1}}}) {
    PlaneCounts moved(with_planes({other}));
    try {
      moved.load(bytes, "run/checkpoint-5.tcp");
      FAIL() << "a plane at another place went on counting";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("'a'"), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("checkpoint-5.tcp"), std::string::npos) << e.what();
    }
  }
}

TEST(PlaneCount, ASceneWhosePlaneMissesTheDomainIsRefused) {
  const auto scene = [](const std::string& point, const std::string& normal) {
    return parse_scene(
        "[domain]\nlower = [0, 0, 0]\nupper = [1, 1, 1]\n[time]\nstep = 1e-5\nsteps = 1\n[[material]]\n"
        "name = \"a\"\ndensity = 1000\n[contact]\nnormal_stiffness = 1000\nrestitution = 0.5\n"
        "[[output.plane]]\nname = \"p\"\npoint = " +
            point + "\nnormal = " + normal + "\n",
        "scene.toml", ".");
  };
  for (const char* good : {"[0, 0, 0]", "[5, -5, 1]", "[0.5, 0.5, 0.5]"}) EXPECT_NO_THROW(scene(good, "[0, 0, 1]"));
  EXPECT_NO_THROW(scene("[1, 1, 1]", "[1, 1, 1]"));
  for (const auto& [point, normal] : {std::pair{"[0, 0, -1e-3]", "[0, 0, 1]"},
                                      {"[0.5, 0.5, 1.001]", "[0, 0, -1]"},
                                      {"[1, 1, 1.001]", "[1, 1, 1]"},
                                      {"[0, -0.1, 0]", "[1, 1, 0]"}}) {
    try {
      scene(point, normal);
      FAIL() << point;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::scene);
      EXPECT_NE(std::string(e.what()).find("outside of the domain"), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("scene.toml:1"), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace talus
