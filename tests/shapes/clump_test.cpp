// Mass properties of unions of spheres, and clumps of meshes.
#include "core/shapes/clump.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "core/shapes/clump_mesh.hpp"
#include "paths.hpp"
#include "tests/shapes/shape_support.hpp"

namespace talus::shapes {
namespace {
using testing::Draw;
using testing::full_requested;

TEST(Clump, ASphereAndTwoSpheresApartAreSums) {
  const MassProperties one = union_properties(std::vector<SubSphere>{{{1, 2, 3}, 0.5}}, "x");
  const double v = 4 * M_PI / 3 * 0.125;
  EXPECT_NEAR(one.volume, v, 1e-15);
  EXPECT_LT(norm(one.centre - Vec3{1, 2, 3}), 1e-15);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(one.inertia[k], 0.4 * v * 0.25, 1e-15);
  const std::vector<SubSphere> three{{{0, 0, 0}, 0.5}, {{2, 0, 0}, 0.5}, {{0, 2, 0}, 0.5}};
  const MassProperties p = union_properties(three, "x");
  EXPECT_EQ(p.volume_error, 0);
  EXPECT_NEAR(p.volume, 3 * v, 1e-14);
  EXPECT_LT(norm(p.centre - Vec3{2.0 / 3, 2.0 / 3, 0}), 1e-14);
  EXPECT_NEAR(p.inertia[3], v * 3 * (2.0 / 3) * (2.0 / 3), 1e-14);  // - sum m x y about the centre
}

TEST(Clump, TwoOverlappingSpheresAreExact) {
  // Two spheres of radius 1, centres 1 apart: twice a sphere less a lens of two caps of height 1/2.
  const Vec3 e = (1 / std::sqrt(14.0)) * Vec3{1, 2, 3};
  const MassProperties p = union_properties(std::vector<SubSphere>{{{}, 1}, {e, 1}}, "x");
  const double cap = M_PI * 0.25 * (3 - 0.5) / 3;
  EXPECT_EQ(p.volume_error, 0);
  EXPECT_NEAR(p.volume, 8 * M_PI / 3 - 2 * cap, 1e-13);
  EXPECT_LT(norm(p.centre - 0.5 * e), 1e-14);
  // Half the body about its symmetry plane: integral of pi rho^2 z^2 and pi rho^4 / 4 from the plane at 1/2 - ...
  const auto rho2 = [](double z) { return 1 - (z - 0.5) * (z - 0.5); };  // the upper sphere, z from the middle plane
  double along = 0, across = 0;
  const int n = 200000;
  for (int k = 0; k < n; ++k) {
    const double z = 1.5 * (k + 0.5) / n, r2 = rho2(z);
    along += 2 * M_PI * r2 * z * z * 1.5 / n;
    across += 2 * M_PI * r2 * r2 / 4 * 1.5 / n;
  }
  const PrincipalAxes a = principal_axes(p.inertia);
  EXPECT_NEAR(a.moments.x, 2 * across, 1e-8);
  EXPECT_NEAR(a.moments.y, along + across, 1e-8);
  EXPECT_NEAR(a.moments.z, along + across, 1e-8);
  EXPECT_NEAR(std::fabs(dot(to_space(rotation(a.turn), {1, 0, 0}), e)), 1, 1e-12);
}

/// Volume and inertia about `centre` from random points of a box, and their standard errors.
struct Counted {
  double value[7] = {}, sigma[7] = {};
};
Counted counted(const std::vector<SubSphere>& s, Vec3 centre, std::int64_t points, std::uint64_t seed) {
  Draw draw(seed);
  double m[7] = {}, q[7] = {};
  for (std::int64_t k = 0; k < points; ++k) {
    const Vec3 x{draw.uniform(-1.5, 1.5), draw.uniform(-1.5, 1.5), draw.uniform(-1.5, 1.5)};
    bool in = false;
    for (const SubSphere& one : s) in = in || norm2(x - one.x) < one.r * one.r;
    if (!in) continue;
    const Vec3 d = x - centre;
    const double term[7] = {
        1, d.y * d.y + d.z * d.z, d.x * d.x + d.z * d.z, d.x * d.x + d.y * d.y, -d.x * d.y, -d.x * d.z, -d.y * d.z};
    for (int e = 0; e < 7; ++e) m[e] += term[e], q[e] += term[e] * term[e];
  }
  const double n = static_cast<double>(points), box = 27;
  Counted c;
  for (int e = 0; e < 7; ++e) {
    c.value[e] = box * m[e] / n;
    c.sigma[e] = box * std::sqrt((q[e] - m[e] * m[e] / n) / n / n);
  }
  return c;
}

// TALUS_FULL=1: 1e8 points each.
TEST(Clump, TenRandomClumpsAgreeWithMonteCarloWithinItsError) {
  const std::int64_t points = full_requested() ? 100'000'000 : 400'000;
  Draw draw(41);
  double worst = 0, widest = 0;
  for (std::uint64_t c = 0; c < 10; ++c) {
    std::vector<SubSphere> s;
    for (std::uint64_t k = 0; k < 3 + c; ++k)
      s.push_back({0.7 * draw.uniform() * draw.direction(), draw.uniform(0.3, 0.8)});
    const MassProperties p = union_properties(s, "x");
    EXPECT_LT(p.volume_error, 1e-4);
    EXPECT_LT(p.inertia_error, 1e-4);
    const Counted m = counted(s, p.centre, points, 100 + c);
    const double most = std::max({p.inertia[0], p.inertia[1], p.inertia[2]});
    for (int e = 0; e < 7; ++e) {
      const double found = e == 0 ? p.volume : p.inertia[static_cast<std::size_t>(e - 1)];
      const double stated = e == 0 ? p.volume_error * p.volume : p.inertia_error * most;
      EXPECT_NEAR(found, m.value[e], 4 * m.sigma[e] + stated) << c << " " << e;
      worst = std::max(worst, std::fabs(found - m.value[e]) / m.sigma[e]);
      widest = std::max(widest, m.sigma[e] / (e == 0 ? p.volume : most));
    }
  }
  std::printf("%lld points: largest difference %.2f standard errors, these at most %.2g of the value\n",
              static_cast<long long>(points), worst, widest);
}

TEST(Clump, QuadratureAgreesWithTheClosedFormWithinItsStatedError) {
  // A rod is exact; with a tiny sphere beside its line, hidden inside, it goes through the quadrature.
  const std::vector<SubSphere> rod{{{0, 0, 0}, 0.5}, {{0.4, 0, 0}, 0.6}, {{0.9, 0, 0}, 0.3}};
  std::vector<SubSphere> bent = rod;
  bent.push_back({{0.3, 0.1, 0.05}, 0.1});
  const MassProperties exact = union_properties(rod, "x"), sum = union_properties(bent, "x");
  ASSERT_EQ(exact.volume_error, 0);
  ASSERT_GT(sum.volume_error, 0);
  EXPECT_NEAR(sum.volume, exact.volume, 2 * (sum.volume_error + 1e-6) * exact.volume);
  EXPECT_LT(norm(sum.centre - exact.centre), 1e-5);
  for (int e = 0; e < 6; ++e) EXPECT_NEAR(sum.inertia[e], exact.inertia[e], 1e-5 * exact.inertia[1]);
}

TEST(Clump, PrincipalAxesDiagonaliseTheTensor) {
  Draw draw(42);
  for (int k = 0; k < 200; ++k) {
    const Vec3 m{draw.uniform(1, 2), draw.uniform(2, 3), draw.uniform(3, 3.9)};
    const Rotation r = rotation(draw.turn());
    double t[3][3];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        t[a][b] = r.row[a].x * m.x * r.row[b].x + r.row[a].y * m.y * r.row[b].y + r.row[a].z * m.z * r.row[b].z;
    const PrincipalAxes p = principal_axes({t[0][0], t[1][1], t[2][2], t[0][1], t[0][2], t[1][2]});
    EXPECT_LT(norm(p.moments - m), 1e-13);
    const Rotation found = rotation(p.turn);
    for (int a = 0; a < 3; ++a)
      EXPECT_NEAR(
          std::fabs(found.row[0][a] * r.row[0][a] + found.row[1][a] * r.row[1][a] + found.row[2][a] * r.row[2][a]), 1,
          1e-12);
  }
}

TEST(Clump, BadSpheresAreRefused) {
  EXPECT_THROW(union_properties(std::vector<SubSphere>{}, "x"), Error);
  EXPECT_THROW(union_properties(std::vector<SubSphere>{{{0, 0, 0}, 0}}, "x"), Error);
  EXPECT_THROW(union_properties(std::vector<SubSphere>{{{NAN, 0, 0}, 1}}, "x"), Error);
}

TEST(Clump, TheLibraryOfShapesIsReadAndItsMassPropertiesAreKnown) {
  const std::pair<const char*, std::size_t> files[] = {{"rod", 9},     {"tetrahedron", 11}, {"cube", 57},
                                                       {"gravel", 10}, {"wheat", 18},       {"pellet", 9}};
  for (const auto& [name, spheres] : files) {
    const std::string path = std::string(TALUS_SOURCE_DIR) + "/cases/shapes/" + name + ".csv";
    const std::vector<SubSphere> s = read_clump(path);
    EXPECT_EQ(s.size(), spheres) << name;
    const MassProperties p = union_properties(s, path);
    EXPECT_LT(p.volume_error, 1e-4) << name;
    const Vec3 m = principal_axes(p.inertia).moments;
    EXPECT_GE(m.x + m.y, m.z) << name;
    EXPECT_GT(m.x, 0) << name;
    EXPECT_LE(p.volume, 4 * M_PI / 3 * std::pow(clump_radius(s, p.centre), 3)) << name;
  }
  const double pellet = M_PI * 9e-6 * 12e-3 + 4 * M_PI / 3 * 27e-9;  // of the cylinder with round ends around it
  const double volume =
      union_properties(read_clump(std::string(TALUS_SOURCE_DIR) + "/cases/shapes/pellet.csv"), "x").volume;
  EXPECT_LT(volume, pellet);
  EXPECT_GT(volume, 0.95 * pellet);
}

/// A box of 2 x 1 x 1 m as an OBJ; `turned`: one facet the other way round.
std::string box_obj(bool turned) {
  std::string s;
  for (int k = 0; k < 8; ++k)
    s += "v " + std::to_string(2 * (k & 1)) + " " + std::to_string((k >> 1) & 1) + " " + std::to_string(k >> 2) + "\n";
  s += turned ? "f 1 4 2\n" : "f 1 2 4\n";  // the lower side, from above
  s += "f 1 4 3\nf 5 8 6\nf 5 7 8\nf 1 6 2\nf 1 5 6\nf 3 4 8\nf 3 8 7\nf 1 3 7\nf 1 7 5\nf 2 8 4\nf 2 6 8\n";
  return s;
}
Mesh box(bool turned = false) { return parse_mesh(box_obj(turned), "box.obj", {}, 0); }

TEST(ClumpOfMesh, PropertiesOfABoxAreExact) {
  const MassProperties p = mesh_properties(box());
  EXPECT_NEAR(p.volume, 2, 1e-14);
  EXPECT_LT(norm(p.centre - Vec3{1, 0.5, 0.5}), 1e-14);
  EXPECT_NEAR(p.inertia[0], 2 * (1 + 1) / 12.0, 1e-14);
  EXPECT_NEAR(p.inertia[1], 2 * (4 + 1) / 12.0, 1e-14);
  EXPECT_NEAR(p.inertia[3], 0, 1e-14);
}

TEST(ClumpOfMesh, SpheresLieInsideAndMoreOfThemFillBetter) {
  const Mesh mesh = box();
  double last = -1;
  for (const int n : {2, 20, 80}) {
    const MeshClump c = clump_of_mesh(mesh, {n, 30, false});
    EXPECT_EQ(c.spheres.size(), static_cast<std::size_t>(n));
    for (const SubSphere& s : c.spheres)
      for (int k = 0; k < 3; ++k) {
        EXPECT_GE(s.x[k] - s.r, -1e-12);
        EXPECT_LE(s.x[k] + s.r, (k == 0 ? 2 : 1) + 1e-12);
      }
    EXPECT_GT(c.volume_error, last);
    EXPECT_LT(c.volume_error, 0);
    last = c.volume_error;
  }
  EXPECT_GT(last, -0.15);
}

TEST(ClumpOfMesh, GrownSpheresHaveTheVolumeOfTheMesh) {
  const MeshClump c = clump_of_mesh(box(), {20, 24, true});
  EXPECT_GT(c.growth, 0);
  EXPECT_NEAR(c.volume_error, 0, 1e-4);
  EXPECT_LT(c.inertia_error, 0.05);
}

TEST(ClumpOfMesh, AMeshBelowTheSizeOfAtomsIsRefusedBeforeAnyWork) {
  MeshFrame small;
  small.scale = 1e-11;
  try {
    clump_of_mesh(parse_mesh(box_obj(false), "box.obj", small, 0), {10, 400, true});
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::scene);
    EXPECT_NE(std::string(e.what()).find("less than an atom"), std::string::npos) << e.what();
  }
}

TEST(ClumpOfMesh, OpenAndTwistedMeshesAreRefusedByName) {
  std::string open = box_obj(false);
  open.resize(open.rfind("f "));
  for (const auto& [text, word] : {std::pair{open, "watertight"}, std::pair{box_obj(true), "wound"}}) {
    try {
      clump_of_mesh(parse_mesh(text, "box.obj", {}, 0), {5, 20, false});
      FAIL() << word;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(word), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find("box.obj"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace talus::shapes
