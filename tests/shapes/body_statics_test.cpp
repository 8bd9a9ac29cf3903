// Bodies that lie, roll and slide as mechanics says: loads of supports, a disc on its edge, a box on a slope.
#include <gtest/gtest.h>

#include <cmath>

#include "core/scene/scene_file.hpp"
#include "tests/shapes/body_support.hpp"

namespace talus {
namespace {

Scene scene_of(const std::string& rest, double tilt = 0, double friction = 0.5) {
  return parse_scene(
      fmt::format("gravity = [{}, 0, {}]\n[domain]\nlower = [-0.5, -0.5, -0.5]\nupper = [0.5, 0.5, 0.5]\n"
                  "[time]\nstep = 5e-5\nduration = 1\n[[material]]\nname = \"m\"\ndensity = 2500\n[contact]\n"
                  "normal_stiffness = 1e5\ntangential_stiffness = 2.8e4\nrestitution = 0.2\nfriction = {}\n",
                  9.81 * std::sin(tilt), -9.81 * std::cos(tilt), friction) +
          rest,
      "test", "", {});
}

/// What a wall takes: the weight on it [N], and its moment about the y axis of the domain [N m].
struct Load {
  double weight = 0, moment = 0;
};
Load load(Simulation& sim, const std::string& wall) {
  FrameRequest q;
  q.walls = q.wall_loads = true;
  const Frame f = sim.frame(q);
  Load sum;
  for (std::size_t k = 0; k < f.walls.size(); ++k) {
    if (f.walls[k].name != wall) continue;
    sum.weight -= f.wall_loads[k].force.z;
    sum.moment += f.wall_loads[k].torque.y;
  }
  return sum;
}

constexpr const char* k_rods = R"(
[[shape]]
name = "bar"
kind = "superquadric"
semi_axes = [0.02, 0.02, 0.2]
exponents = [8, 2]
[[shape]]
name = "beam"
kind = "superquadric"
semi_axes = [0.02, 0.03, 0.2]
exponents = [20, 20]
[[shape]]
name = "chain"
spheres = [0, 0, -0.18, 0.02, 0, 0, -0.14, 0.02, 0, 0, -0.1, 0.02, 0, 0, -0.06, 0.02, 0, 0, -0.02, 0.02, 0, 0, 0.02, 0.02, 0, 0, 0.06, 0.02, 0, 0, 0.1, 0.02, 0, 0, 0.14, 0.02, 0, 0, 0.18, 0.02]
)";

/// Two boxes, one of them lower by `drop`.
std::string boxes(double drop) {
  return fmt::format(
      "[[wall]]\nname = \"a\"\nshape = \"box\"\nlower = [-0.15, -0.1, -0.1]\nupper = [-0.12, 0.1, {}]\n"
      "[[wall]]\nname = \"b\"\nshape = \"box\"\nlower = [0.05, -0.1, -0.1]\nupper = [0.09, 0.1, 0]\n",
      -drop);
}

/// What rests on two supports loads them by the law of the lever, whichever is pressed deeper.
TEST(BodyStatics, ALongBodyLoadsBothOfItsSupports) {
  for (const char* shape : {"bar", "beam", "chain"})
    for (const double drop : {0.0, 2e-5}) {
      // its z axis along x
      const Table table(
          fmt::format("x,y,z,shape,scale,qw,qx,qy,qz\n0,0,0.01999,{},1,0.70710678118654757,0,"
                      "0.70710678118654757,0\n",
                      shape));
      Simulation sim(scene_of(k_rods + boxes(drop) + table.source()), {});
      sim.run(6000);
      const BodyRecord body = sim.frame().bodies[0];
      const double weight = 9.81 * body.mass;
      const Load a = load(sim, "a"), b = load(sim, "b");
      EXPECT_NEAR((a.weight + b.weight) / weight, 1, 2e-3) << shape << drop;
      EXPECT_NEAR((a.moment + b.moment) / weight, body.x.x, 1e-3) << shape << drop << ": about the middle";
      // somewhere within each support: between 0.05 / 0.2 and 0.09 / 0.21
      EXPECT_GT(a.weight / weight, 0.25 - 2e-3) << shape << drop;
      EXPECT_LT(a.weight / weight, 0.43 + 2e-3) << shape << drop;
      EXPECT_LT(norm(body.w), 2e-3) << shape << drop;
    }
}

TEST(BodyStatics, APlateLiesOnAllRollersThatItSpans) {
  std::string rollers;
  for (int k = -1; k <= 1; ++k)
    rollers += fmt::format(
        "[[wall]]\nname = \"r{}\"\nshape = \"cylinder\"\npoint = [{}, -0.5, -0.02]\naxis = [0, 1, 0]\n"
        "length = 1\nradius = 0.02\n",
        k + 1, 0.1 * k);
  const Table table("x,y,z,shape,scale\n0.02,0,0.00999,plate,1\n");
  Simulation sim(scene_of("[[shape]]\nname = \"plate\"\nkind = \"superquadric\"\nsemi_axes = [0.25, 0.1, 0.01]\n"
                          "exponents = [20, 20]\n" +
                          rollers + table.source()),
                 {});
  sim.run(5000);
  const double weight = 9.81 * bodies_of(sim).mass(0),
               r[] = {load(sim, "r0").weight, load(sim, "r1").weight, load(sim, "r2").weight};
  EXPECT_NEAR((r[0] + r[1] + r[2]) / weight, 1, 1e-3);
  EXPECT_NEAR((r[2] - r[0]) * 0.1 / weight, 0.02, 1e-3) << "moments about the middle";
  for (const double each : r) EXPECT_GT(each, 0.05 * weight);
}

/// Facets of one flat surface are no supports of their own.
TEST(BodyStatics, SeamsOfAFlatFloorHoldABodyOnce) {
  std::string tiles;
  for (int i = -2; i < 2; ++i)
    tiles += fmt::format("[[wall]]\nname = \"t{}\"\nshape = \"box\"\nlower = [{}, -0.3, -0.1]\nupper = [{}, 0.3, 0]\n",
                         i + 2, 0.07 * i, 0.07 * (i + 1));
  const Table table(
      "x,y,z,shape,scale,qw,qx,qy,qz\n0.01,0,0.01999,bar,1,0.70710678118654757,0,0.70710678118654757,0\n");
  Simulation sim(scene_of(k_rods + tiles + table.source()), {});
  for (int k = 0; k < 50; ++k) {
    sim.run(100);
    ASSERT_LE(sim.counters().wall_contacts, 1) << k;
  }
}

TEST(BodyStatics, ADiscRollsOnItsEdgeAtConstantSpeed) {
  // its axis along y; v = omega R at the height of its centre
  const double sink = 2e-6, radius = 0.05;
  const Table table(
      fmt::format("x,y,z,shape,scale,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz\n-0.3,0,{},disc,1,0.70710678118654757,"
                  "0.70710678118654757,0,0,1,0,0,0,{},0\n",
                  radius - sink, 1 / (radius - sink)));
  Simulation sim(scene_of("[[shape]]\nname = \"disc\"\nkind = \"superquadric\"\nsemi_axes = [0.05, 0.05, 0.01]\n"
                          "exponents = [20, 2]\n[[wall]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0]\n"
                          "normal = [0, 0, 1]\n[output]\nenergies = true\n" +
                          table.source()),
                 {});
  sim.run(10000);
  const BodyRecord b = sim.frame().bodies[0];
  EXPECT_NEAR(b.x.x, -0.3 + 0.5, 5e-4);
  EXPECT_NEAR(b.v.x, 1, 2e-4);
  EXPECT_NEAR(b.w.y * b.x.z, b.v.x, 2e-4);
  EXPECT_LT(std::fabs(b.x.y), 1e-6);
  EXPECT_LT(std::fabs(sim.energies().residual), 1e-6 * sim.energies().kinetic_translation);
}

/// Slope 0.3: friction 0.5 holds the box, 0.2 lets it slide with g (sin - mu cos).
TEST(BodyStatics, ABoxOnASlopeHoldsOrSlides) {
  const double tilt = std::atan(0.3);
  for (const double mu : {0.5, 0.2}) {
    const Table table("x,y,z,shape,scale\n0,0,0.01999,box,1\n");
    Simulation sim(scene_of("[[shape]]\nname = \"box\"\nkind = \"superquadric\"\nsemi_axes = [0.02, 0.02, 0.02]\n"
                            "exponents = [20, 20]\n[[wall]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0]\n"
                            "normal = [0, 0, 1]\n" +
                                table.source(),
                            tilt, mu),
                   {});
    sim.run(2000);  // until its spring is stretched
    const BodyRecord before = sim.frame().bodies[0];
    sim.run(4000);
    const BodyRecord after = sim.frame().bodies[0];
    const double wanted = 9.81 * (std::sin(tilt) - mu * std::cos(tilt)) * 0.2;
    if (mu > 0.3)
      EXPECT_NEAR(after.x.x, before.x.x, 5e-5);
    else
      EXPECT_NEAR(after.v.x - before.v.x, wanted, 0.01 * wanted);
  }
}

}  // namespace
}  // namespace talus
