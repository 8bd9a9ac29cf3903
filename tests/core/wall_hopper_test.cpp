// Claims about cases/hopper: every scene and mesh loads, meshes are the primitives to their faceting, the closed silo
// holds what falls into it, and behind the opened gate everything leaves by way of the chute.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/meshes/mesh_file.hpp"
#include "core/scene/scene_file.hpp"
#include "paths.hpp"
#include "wall_support.hpp"

namespace talus {
namespace {

using namespace wall_test;

const std::filesystem::path k_folder = std::filesystem::path(TALUS_SOURCE_DIR) / "cases" / "hopper";

Scene hopper(const std::string& name) { return load_scene((k_folder / name).string(), {}); }

TEST(HopperCase, EveryMeshIsCleanAndSmall) {
  std::uintmax_t bytes = 0;
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(k_folder / "meshes")) {
    const Mesh m = read_mesh(entry.path().string(), {}, 0.006);
    EXPECT_EQ(m.report.degenerate + m.report.duplicate + m.report.forked_edges, 0) << entry.path();
    bytes += entry.file_size();
    ++files;
  }
  EXPECT_EQ(files, 6);
  EXPECT_LT(bytes, 300000u);
}

TEST(HopperCase, EverySceneBuildsItsWallsAndKeepsItsStepAboveTwentyPerContact) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(k_folder)) {
    if (entry.path().extension() != ".toml") continue;
    const Scene s = load_scene(entry.path().string(), {});
    const WallSet walls(s, 0.0045);
    EXPECT_GT(walls.size(), 2) << entry.path();
    ASSERT_EQ(s.sources.size(), 1u);
    const double m = s.materials[0].density * M_PI / 6 * std::pow(s.sources[0].size.min, 3);
    const double contact_time = M_PI * std::sqrt(0.5 * m / s.contact.normal_stiffness);
    EXPECT_GT(contact_time / s.dt, 20) << entry.path();
    // The fill has room: at most 0.42 of the region, which a lattice of the largest diameter can hold.
    const Region& r = s.sources[0].region;
    const Vec3 e = r.upper - r.lower;
    const double volume = r.radius > 0 ? M_PI * r.radius * r.radius * e.z : e.x * e.y * e.z;
    EXPECT_LT(static_cast<double>(s.sources[0].number) * M_PI / 6 * 130e-9 / volume, 0.42) << entry.path();
    ++scenes;
  }
  EXPECT_EQ(scenes, 9);
}

TEST(HopperCase, MeshAndPrimitiveWallsAgreeToTheFaceting) {
  const WallSet mesh(hopper("hopper-20k.toml"), 0.02), primitive(hopper("hopper-20k-primitive.toml"), 0.02);
  const CounterRng rng(6, 6);
  int compared = 0;
  for (std::uint64_t k = 0; k < 20000; ++k) {
    const Vec3 c{rng.uniform(3 * k, -0.1, 0.2), rng.uniform(3 * k + 1, -0.08, 0.08),
                 rng.uniform(3 * k + 2, -0.25, 0.3)};
    const auto a = touch(mesh, c, 0.01), b = touch(primitive, c, 0.01);
    if (a.empty() || b.empty()) continue;
    const auto nearer = [](const WallContact& p, const WallContact& q) { return p.distance < q.distance; };
    const double da = std::min_element(a.begin(), a.end(), nearer)->distance;
    const double db = std::min_element(b.begin(), b.end(), nearer)->distance;
    ASSERT_NEAR(da, db, 4e-4);  // sagitta of the chute's 36 corners; 0.1 mm for the silo's 72
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

/// Frictionless grains that do not see each other fall through the case's walls.
void drop_through(const std::string& name, double floor_after) {
  const Scene s = hopper(name);
  WallSet walls(s, 0.02);
  const double dt = 4e-5, radius = 0.0025, mass = 1.64e-4, stiffness = 2000, damping = 0.15;
  const CounterRng rng(12, 3);
  std::vector<Vec3> x, v;
  const Region& r = s.sources[0].region;
  for (std::uint64_t k = 0; x.size() < 60; ++k) {
    const double a = rng.uniform(3 * k, -0.07, 0.07), b = rng.uniform(3 * k + 1, -0.07, 0.07);
    if (a * a + b * b > 0.07 * 0.07 || std::fabs(b) > r.upper.y - 0.003) continue;
    x.push_back({a, b, rng.uniform(3 * k + 2, r.lower.z + 0.01, r.lower.z + 0.05)});
    v.push_back({});
  }
  std::vector<std::vector<std::int32_t>> lists(x.size());
  std::vector<char> gone(x.size(), 0);
  const double opened = s.walls[s.walls[1].name == "gate" ? 1 : 2].motion.start;
  const auto steps = static_cast<std::int64_t>((opened + 1.5) / dt);
  std::int64_t left = 0;
  for (std::int64_t n = 1; n <= steps; ++n) {
    walls.set_step(n, dt);
    const bool renew = n % 20 == 1;
    if (renew) walls.mark(20, dt, 0.001, 0.005);
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (gone[k]) continue;
      x[k] = x[k] + dt * v[k];
      if (n * dt < opened) {
        ASSERT_GT(x[k].z, 0) << name << ": grain " << k << " left the closed silo at step " << n;
      } else if (x[k].z < s.domain.lower.z || x[k].x > s.domain.upper.x) {
        ASSERT_GT(x[k].x, floor_after) << name << ": grain " << k << " missed the chute";
        gone[k] = 1;
        ++left;
        continue;
      }
      if (renew) {
        lists[k].clear();
        walls.candidates(x[k], radius + 0.004, lists[k]);
      }
      WallContact c[WallSet::k_max_contacts];
      const int m = walls.contacts(x[k], radius, lists[k], c);
      Vec3 force{0, 0, -9.81 * mass};
      for (int i = 0; i < m; ++i) {
        const double vn = dot(v[k] - c[i].velocity, c[i].normal);
        force = force + (stiffness * (radius - c[i].distance) - damping * vn) * c[i].normal;
      }
      v[k] = v[k] + (dt / mass) * force;
    }
  }
  EXPECT_EQ(left, 60) << name;
}

TEST(HopperCase, ClosedSiloHoldsAndTheChuteCarriesMeshCone) { drop_through("hopper-20k.toml", 0.1); }
TEST(HopperCase, ClosedSiloHoldsAndTheChuteCarriesPrimitiveCone) { drop_through("hopper-20k-primitive.toml", 0.1); }
TEST(HopperCase, ClosedSiloHoldsAndTheChuteCarriesMeshWedge) { drop_through("hopper-20k-wedge.toml", 0.1); }

}  // namespace
}  // namespace talus
