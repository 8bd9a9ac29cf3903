// Stress of bodies that are no spheres: closed forms of bodies between plates, and the virial theorem, in which
// stresses, walls and what is not at rest sum to nothing.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "core/base/error.hpp"
#include "core/frame/averages.hpp"
#include "core/frame/quantities.hpp"
#include "core/scene/scene_file.hpp"
#include "tests/shapes/body_support.hpp"

namespace talus {
namespace {

constexpr const char* k_kinds = R"(
[[shape]]
name = "egg"
kind = "superquadric"
semi_axes = [0.03, 0.02, 0.015]
exponents = [3, 2.5]
[[shape]]
name = "lens"
kind = "superquadric"
semi_axes = [0.03, 0.02, 0.01]
[[shape]]
name = "rod"
spheres = [0, 0, -0.015, 0.02, 0, 0, 0.015, 0.02]
[[shape]]
name = "chain"
spheres = [0, 0, -0.02, 0.02, 0, 0, 0.02, 0.02]
)";

Scene scene_of(const std::string& gravity, const std::string& upper, const std::string& rest,
               const std::string& boundary = "\"wall\"", double friction = 0.5) {
  return parse_scene(
      fmt::format("gravity = {}\nseed = 5\n[domain]\nlower = [0, 0, 0]\nupper = {}\nboundary = {}\n"
                  "[time]\nstep = 2e-5\nduration = 1\n[checks]\nmax_overlap = 0.5\n[[material]]\nname = \"m\"\n"
                  "density = 2500\n[contact]\nnormal_stiffness = 1e4\ntangential_stiffness = 2.8e3\n"
                  "restitution = 0.2\nfriction = {}\n",
                  gravity, upper, boundary, friction) +
          k_kinds + rest,
      "test", "", {});
}

using Tensor = std::array<double, 6>;
void add(Tensor& t, Vec3 l, Vec3 f) {
  const double all[] = {l.x * f.x,
                        l.y * f.y,
                        l.z * f.z,
                        0.5 * (l.x * f.y + l.y * f.x),
                        0.5 * (l.x * f.z + l.z * f.x),
                        0.5 * (l.y * f.z + l.z * f.y)};
  for (std::size_t k = 0; k < 6; ++k) t[k] += all[k];
}

/// Grains of a frame by the id that their spheres show: where, and how large.
struct Grain {
  Vec3 x, force, turn;  ///< turn: of the contact forces about the centre
  double volume = 0, mass = 0;
  Tensor stress{};
};
std::map<ParticleId, Grain> grains_of(const Frame& f, const Scene& s) {
  std::map<ParticleId, Grain> grains;
  for (std::size_t i = 0; i < f.id.size(); ++i)
    if (static_cast<ParticleId>(f.extra[0].values[i]) == f.id[i]) {
      const double v = 4 * std::numbers::pi / 3 * f.r[i] * f.r[i] * f.r[i];
      grains[f.id[i]] = {f.x[i], {}, {}, v, s.materials[0].density * v, f.stress[i]};
    }
  for (const BodyRecord& b : f.bodies) {
    Grain& g = grains[b.id];
    g.x = b.x;
    g.mass = b.mass;
    g.volume = b.mass / s.materials[0].density;
  }
  return grains;
}

struct Virial {
  Tensor stresses{}, walls{}, motion{};  ///< sum of V sigma; of x f over wall contacts; of x F over grains
  double turn = 0, arm_force = 0;        ///< largest torque of contacts on a grain, largest lever times force
};
Virial virial_of(const Frame& f, const Scene& s) {
  auto grains = grains_of(f, s);
  std::map<ParticleId, ParticleId> owner;
  for (std::size_t i = 0; i < f.id.size(); ++i) owner[f.id[i]] = static_cast<ParticleId>(f.extra[0].values[i]);
  Virial v;
  for (const ContactRecord& c : f.contacts) {
    const Vec3 force = c.normal_force + c.tangential_force;
    const auto put = [&](ParticleId id, Vec3 on) {
      Grain& g = grains.at(owner.at(id));
      g.force = g.force + on;
      g.turn = g.turn + cross(c.point - g.x, on);
      v.arm_force = std::fmax(v.arm_force, norm(c.point - g.x) * norm(on));
    };
    put(c.a, force);
    if (c.b >= 0)
      put(c.b, -force);
    else
      add(v.walls, c.point, force);
  }
  for (const auto& [id, g] : grains) {
    for (std::size_t k = 0; k < 6; ++k) v.stresses[k] += g.volume * g.stress[k];
    add(v.motion, g.x, g.force);
    v.turn = std::fmax(v.turn, norm(g.turn));
  }
  return v;
}

constexpr FrameRequest k_request{.contacts = true, .stress = true, .walls = true};

/// A body of height 2c squeezed between two plates that are 2 (c - d) apart: each presses with k d.
TEST(BodyStress, OfABodyBetweenTwoPlatesIsForceTimesHeightOverVolume) {
  struct Case {
    const char *shape, *turn;
    double half;
  };
  for (const Case& c : {Case{"egg", "1,0,0,0", 0.015},
                        {"lens", "1,0,0,0", 0.01},
                        {"lens", "0.70710678118654757,0.70710678118654757,0,0", 0.02},
                        {"rod", "1,0,0,0", 0.035},
                        {"chain", "1,0,0,0", 0.04}}) {
    const double d = 1e-4, height = 2 * (c.half - d);
    const Table table(
        fmt::format("x,y,z,shape,scale,qw,qx,qy,qz\n0.05,0.05,{:.17g},{},1,{}\n", height / 2, c.shape, c.turn));
    const Scene s = scene_of("[0, 0, 0]", fmt::format("[0.1, 0.1, {:.17g}]", height), table.source());
    Simulation sim(s, {});
    const Frame f = sim.frame(k_request);
    ASSERT_EQ(f.contacts.size(), 2U) << c.shape;
    const double force = 1e4 * d, volume = f.bodies[0].mass / 2500;
    for (std::size_t i = 0; i < f.id.size(); ++i) {
      EXPECT_NEAR(f.stress[i][2] / (-force * height / volume), 1, 1e-9) << c.shape << i;
      for (const std::size_t k : {0U, 1U, 3U, 4U, 5U})
        EXPECT_NEAR(f.stress[i][k] * volume / (force * height), 0, 1e-6) << c.shape << k;
    }
    const RegionAverage a = average_region(f, s, {{0, 0, 0}, {0.1, 0.1, height}, 0});
    EXPECT_NEAR(a.stress[2] / (-force / 0.01 * a.particles), 1, 1e-9) << "the pressure on the plates";
    EXPECT_NEAR(a.particles, 1, 1e-3) << "but for what overlaps with them";
    const PolyData p = body_poly(f);
    ASSERT_EQ(p.point_data.back().name, "stress");
    EXPECT_EQ(std::get<0>(p.point_data.back().values)[2], f.stress[0][2]);
  }
}

/// A rod that lies has a contact of each of its spheres with each plate: the lever arms along it balance.
TEST(BodyStress, OfALyingClumpCountsAllOfItsSpheres) {
  const double d = 1e-4, height = 2 * (0.02 - d);
  const Table table(fmt::format(
      "x,y,z,shape,scale,qw,qx,qy,qz\n0.05,0.05,{:.17g},chain,1,0.70710678118654757,0,0.70710678118654757,0\n",
      height / 2));
  const Scene s = scene_of("[0, 0, 0]", fmt::format("[0.1, 0.1, {:.17g}]", height), table.source());
  Simulation sim(s, {});
  const Frame f = sim.frame(k_request);
  ASSERT_EQ(f.contacts.size(), 4U);
  const double volume = f.bodies[0].mass / 2500, wanted = -2 * 1e4 * d * height / volume;
  for (const Tensor& t : f.stress) {
    EXPECT_NEAR(t[2] / wanted, 1, 1e-9);
    for (const std::size_t k : {0U, 1U, 3U, 4U, 5U}) EXPECT_NEAR(t[k] / wanted, 0, 1e-9) << k;
  }
}

/// Pressed from all sides with the same force over the same area: hydrostatic.
TEST(BodyStress, OfACubeOfSpheresPressedFromAllSidesIsHydrostatic) {
  std::string spheres;
  for (int k = 0; k < 8; ++k)
    spheres += fmt::format("{}{}, {}, {}, 0.02", k == 0 ? "" : ", ", k % 2 == 0 ? -0.018 : 0.018,
                           k / 2 % 2 == 0 ? -0.018 : 0.018, k / 4 == 0 ? -0.018 : 0.018);
  const double d = 1e-4, side = 2 * (0.038 - d);
  const Table table(fmt::format("x,y,z,shape,scale\n{0:.17g},{0:.17g},{0:.17g},cube,1\n", side / 2));
  const Scene s = scene_of("[0, 0, 0]", fmt::format("[{0:.17g}, {0:.17g}, {0:.17g}]", side),
                           "[[shape]]\nname = \"cube\"\nspheres = [" + spheres + "]\n" + table.source());
  Simulation sim(s, {});
  const Frame f = sim.frame(k_request);
  ASSERT_EQ(f.contacts.size(), 24U);
  const double pressure = 4 * 1e4 * d / (side * side);
  const RegionAverage a = average_region(f, s, {{0, 0, 0}, {side, side, side}, 0});
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(a.stress[k] / pressure, k < 3 ? -a.particles : 0, 1e-9) << k;
}

/// Whatever moves: sum of V sigma = sum of x f over walls less sum of x F over grains. No body's place in it is free.
TEST(BodyStress, SumsToTheForcesOfWallsAndTheMotionAtAnyMoment) {
  const std::string region_low = "[0.001, 0.001, 0.001]", region_high = "[0.299, 0.299, 0.499]";
  Scene s = scene_of("[1, 0.5, -9.81]", "[0.3, 0.3, 0.5]",
                     source("a", 60, region_low, region_high, "shape = \"egg\"\nvelocity = [0, 0, -2]") +
                         source("b", 40, region_low, region_high, "shape = \"rod\"\nvelocity = [0, 0, -2]") +
                         source("c", 40, region_low, region_high, "velocity = [0, 0, -2]", "0.03"));
  Simulation sim(s, {});
  int met = 0;
  for (int k = 0; k < 3; ++k) {
    sim.run(1500);
    const Frame f = sim.frame(k_request);
    for (const ContactRecord& c : f.contacts) met += c.b >= 0 ? 1 : 0;
    const Virial v = virial_of(f, s);
    for (std::size_t m = 0; m < 6; ++m)
      EXPECT_NEAR(v.stresses[m], v.walls[m] - v.motion[m], 1e-11 * std::fabs(v.walls[2])) << k << m;
  }
  EXPECT_GT(met, 100);
}

/// At rest contacts carry the weight, and no torque is left that would make a stress unsymmetric.
TEST(BodyStress, AtRestIsSymmetricAndSumsToWallsAndWeight) {
  Scene s = scene_of("[0, 0, -9.81]", "[0.1, 0.1, 0.8]",
                     source("a", 5, "[0.001, 0.001, 0.001]", "[0.099, 0.099, 0.799]", "shape = \"lens\"") +
                         source("b", 4, "[0.001, 0.001, 0.001]", "[0.099, 0.099, 0.799]", "shape = \"rod\""));
  s.viscous_damping = 20;
  Simulation sim(s, {});
  sim.run(100000);
  const Frame f = sim.frame(k_request);
  const Virial v = virial_of(f, s);
  Tensor weight{};
  double all = 0;
  for (const BodyRecord& b : f.bodies) {
    add(weight, b.x, {0, 0, -9.81 * b.mass});
    all += 9.81 * b.mass;
    ASSERT_LT(norm(b.v), 1e-3) << "at rest";
  }
  EXPECT_LT(v.turn, 1e-2 * v.arm_force);
  for (std::size_t m = 0; m < 6; ++m) EXPECT_NEAR(v.stresses[m], v.walls[m] + weight[m], 1e-2 * all * 0.05) << m;
  EXPECT_LT(v.stresses[2], 0) << "compression";
}

TEST(BodyStress, OutputChangesNoStateAndThreadsNoBit) {
  const Scene s = scene_of("[0, 0, -9.81]", "[0.2, 0.2, 0.6]",
                           source("a", 30, "[0.001, 0.001, 0.001]", "[0.199, 0.199, 0.599]", "shape = \"egg\"") +
                               source("b", 30, "[0.001, 0.001, 0.001]", "[0.199, 0.199, 0.599]", "shape = \"rod\""),
                           "[\"periodic\", \"wall\", \"wall\"]");
  RunOptions other;
  other.threads = 2;
  other.chunk = 64;
  Simulation one(s, {}), two(s, other);
  const Region g{{0, 0, 0}, {0.1, 0.13, 0.05}, 0};
  for (int k = 0; k < 3; ++k) {
    one.run(1500);
    two.run(1500);
    const Frame a = one.frame(k_request), b = two.frame(k_request);
    const RegionAverage p = average_region(a, s, g), q = average_region(b, s, g);
    EXPECT_EQ(a.stress, b.stress);
    EXPECT_EQ(p.stress, q.stress);
    EXPECT_EQ(p.solid_fraction, q.solid_fraction);
    EXPECT_EQ(norm(p.velocity - q.velocity), 0);
    EXPECT_EQ(one.state_hash(), two.state_hash());
  }
  Simulation quiet(s, {});
  quiet.run(4500);
  EXPECT_EQ(quiet.state_hash(), one.state_hash());
}

}  // namespace
}  // namespace talus
