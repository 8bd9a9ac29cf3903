// Meshes that fold inwards: grains without dissipation keep their energy in them, however fine the mesh, and a round
// mesh acts as the round wall that it stands for.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/scene/scene_file.hpp"
#include "scheduler/simulation.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_length = 0.06, k_middle = 0.03;

/// Half of a pipe of this radius along z, of `facets` strips of two triangles per full turn.
std::string trough(int facets, double radius) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i <= facets / 2; ++i) {
    const double a = k_pi * (2.0 * i / facets - 0.5);
    const double x = k_middle + radius * std::sin(a), y = k_middle - radius * std::cos(a);
    points.push_back({x, y, 0});
    points.push_back({x, y, k_length});
    const int p = 2 * i;
    if (i < facets / 2) triangles.insert(triangles.end(), {{p, p + 3, p + 2}, {p, p + 1, p + 3}});
  }
  return mesh_file(points, triangles);
}

/// y = height(i, j) over a square grid of cells.
std::string ground(int cells, const std::function<double(double, double, std::uint64_t)>& height) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j <= cells; ++j) {
      const double x = k_length * i / cells, z = k_length * j / cells;
      const int p = static_cast<int>(points.size()), q = p + cells + 1;
      points.push_back({x, height(x, z, static_cast<std::uint64_t>(p)), z});
      if (i == cells || j == cells) continue;
      if ((i + j) % 2 == 0)
        triangles.insert(triangles.end(), {{p, p + 1, q}, {q, p + 1, q + 1}});
      else
        triangles.insert(triangles.end(), {{p, p + 1, q + 1}, {p, q + 1, q}});
    }
  return mesh_file(points, triangles);
}

std::string mesh_wall(const std::string& file) { return "shape = \"mesh\"\nfile = \"" + file + "\"\n"; }
const std::string k_pipe =
    "shape = \"cylinder\"\npoint = [0.03, 0.03, -0.01]\naxis = [0, 0, 1]\nlength = 0.08\nradius = 0.02\n";

/// One grain of 3 mm that falls at `x` with `velocity`; overlaps of one to some percent.
std::string scene_of(const std::string& wall, Vec3 x, Vec3 velocity, const std::string& shape, const std::string& law) {
  const double room = shape.empty() ? 0.00301 : 0.00401;  // half the width of its place
  return fmt::format(
      "gravity = [0, -10, 0]\n[domain]\nlower = [0, 0, 0]\nupper = [0.06, 0.06, 0.06]\n"
      "boundary = [[\"wall\", \"wall\"], [\"open\", \"open\"], [\"wall\", \"wall\"]]\n[time]\nstep = 1e-5\nsteps = "
      "100000\n"
      "[[material]]\nname = \"glass\"\ndensity = 2500\n[contact]\nnormal_stiffness = 500\nrestitution = 1\n{}\n"
      "[[source]]\nkind = \"random\"\nnumber = 1\nvelocity = [{}, {}, {}]\nsize = {{ diameter = 0.006 }}\n"
      "region = {{ lower = [{}, {}, {}], upper = [{}, {}, {}] }}\n{}"
      "[checks]\nallow_initial_overlap = true\nwarn_overlap = 0.4\n[output]\nenergies = true\n"
      "[[wall]]\nname = \"ground\"\n{}",
      law, velocity.x, velocity.y, velocity.z, x.x - room, x.y - room, x.z - room, x.x + room, x.y + room, x.z + room,
      shape, wall);
}

const std::string k_smooth = "friction = \"none\"", k_rough = "friction = 0.5\ntangential_stiffness = 150";
const Vec3 k_side{k_middle + 0.0165 * std::sin(1.05), k_middle - 0.0165 * std::cos(1.05), k_middle};

struct Swing {
  double residual = 0;  ///< largest, of the largest kinetic energy
  Vec3 x;
};

Swing swing(const std::string& wall, Vec3 x, Vec3 v, const std::string& shape, const std::string& law, int steps) {
  Simulation sim(parse_scene(scene_of(wall, x, v, shape, law), "fold.toml", "."), options());
  Swing s;
  double largest = 0, residual = 0;
  for (int n = 0; n < steps; n += 50) {
    sim.run(50);
    const Energies e = sim.energies();
    largest = std::max(largest, e.kinetic_translation + e.kinetic_rotation);
    residual = std::max(residual, std::fabs(e.residual));
  }
  s.residual = residual / largest;
  s.x = sim.frame().x[0];
  return s;
}

// Before touches shared their overlaps the residuals of these scenes were 0.01 to 0.7. What is left is that of a force
// whose direction turns within one step: of the order of one step's share of the swing, 1e-4. On rough ground a corner
// may be reached late, between two that are farther apart than 32 degrees, and joins their springs: half of what they
// hold at most, which is a few per mille of the swing here.
constexpr double k_most = 4e-4, k_most_rough = 1e-3, k_most_late = 5e-3;

TEST(Folds, TroughsKeepTheEnergyOfSpheresAtEveryFineness) {
  for (const int facets : {12, 24, 48, 100, 400, 1600})
    for (const std::string& law : {k_smooth, k_rough}) {
      const Swing s = swing(mesh_wall(trough(facets, 0.02)), k_side, {}, "", law, 60000);
      EXPECT_LT(s.residual, law == k_smooth ? k_most : k_most_rough) << facets << " facets, " << law;
    }
}

TEST(Folds, WavesBowlsAndRoughGroundKeepTheEnergyOfSpheres) {
  const auto wave = [](double x, double z, std::uint64_t) {
    return 0.02 + 0.002 * std::sin(2 * k_pi * x / 0.02) * std::sin(2 * k_pi * z / 0.03);
  };
  const auto bowl = [](double x, double z, std::uint64_t) {
    return 0.02 + ((x - k_middle) * (x - k_middle) + (z - k_middle) * (z - k_middle)) / 0.04;
  };
  const auto rough = [](double x, double z, std::uint64_t k) {
    return 0.02 + 0.001 * uniform(5, k) + ((x - k_middle) * (x - k_middle) + (z - k_middle) * (z - k_middle)) / 0.1;
  };
  for (const int cells : {12, 30, 60}) {
    const Vec3 above{k_middle, 0.027, k_middle}, v{0.2, 0, 0.1};
    EXPECT_LT(swing(mesh_wall(ground(cells, wave)), above, v, "", k_smooth, 60000).residual, k_most) << cells;
    EXPECT_LT(swing(mesh_wall(ground(cells, bowl)), above, v, "", k_smooth, 60000).residual, k_most) << cells;
    EXPECT_LT(swing(mesh_wall(ground(cells, rough)), above, v, "", k_smooth, 60000).residual, k_most_late) << cells;
  }
}

TEST(Folds, TroughsKeepTheEnergyOfBodies) {
  const std::string shapes[] = {
      "shape = \"body\"\n[[shape]]\nname = \"body\"\nkind = \"superquadric\"\nsemi_axes = [1, 0.7, 0.6]\n",
      "shape = \"body\"\n[[shape]]\nname = \"body\"\nkind = \"clump\"\nspheres = [0, 0, 0, 1, 1, 0, 0, 0.8]\n"};
  for (const std::string& shape : shapes)
    for (const int facets : {24, 100})
      EXPECT_LT(swing(mesh_wall(trough(facets, 0.02)), k_side, {}, shape, k_smooth, 40000).residual, k_most)
          << facets << " facets, " << shape;
}

TEST(Folds, FineMeshedPipeActsAsThePipe) {
  // Half a swing, where friction makes the ball roll. The tangential spring goes along from facet to facet: with a new
  // one at each, the ball would slip at each.
  for (const std::string& law : {k_smooth, k_rough}) {
    const Swing pipe = swing(k_pipe, k_side, {}, "", law, 15000);
    for (const int facets : {48, 96, 192, 384}) {
      const double off = norm(swing(mesh_wall(trough(facets, 0.02)), k_side, {}, "", law, 15000).x - pipe.x);
      fmt::print("{} facets, {}: {:.2e} m beside the pipe\n", facets, law.substr(0, 15), off);
      EXPECT_LT(off, k_pi * 0.02 / facets) << "half a facet, " << facets << " facets, " << law;
    }
  }
}

TEST(Folds, FoldOfTwoPlanesOrOfMeshAndPlaneIsThatOfOneMesh) {
  // the floor and a ramp of 12 degrees as one mesh, as two meshes, as plane and mesh: the same path
  const double c = std::cos(0.21), s = std::sin(0.21);
  const std::vector<Vec3> floor{{0, 0.01, 0}, {0.03, 0.01, 0}, {0.03, 0.01, 0.06}, {0, 0.01, 0.06}};
  const std::vector<Vec3> ramp{{0.03, 0.01, 0},
                               {0.03 + 0.03 * c, 0.01 + 0.03 * s, 0},
                               {0.03 + 0.03 * c, 0.01 + 0.03 * s, 0.06},
                               {0.03, 0.01, 0.06}};
  std::vector<Vec3> both = floor;
  both.insert(both.end(), ramp.begin(), ramp.end());
  const std::vector<std::array<int, 3>> square{{0, 2, 1}, {0, 3, 2}};
  const std::string one = mesh_wall(mesh_file(both, {{0, 2, 1}, {0, 3, 2}, {4, 6, 5}, {4, 7, 6}}));
  const std::string second = "[[wall]]\nname = \"ramp\"\n" + mesh_wall(mesh_file(ramp, square));
  const std::string two = mesh_wall(mesh_file(floor, square)) + second;
  const std::string plane = "shape = \"plane\"\npoint = [0, 0.01, 0]\nnormal = [0, 1, 0]\n" + second;
  const Vec3 x{0.02, 0.01302, k_middle}, v{0.3, 0, 0.02};
  for (const std::string& law : {k_smooth, k_rough}) {
    const Swing a = swing(one, x, v, "", law, 8000);
    EXPECT_LT(a.residual, k_most) << law;
    for (const std::string& walls : {two, plane}) {
      const Swing b = swing(walls, x, v, "", law, 8000);
      EXPECT_LT(b.residual, k_most) << law;
      EXPECT_LT(norm(b.x - a.x), 1e-9) << law;
    }
  }
}

}  // namespace
}  // namespace talus::physics
