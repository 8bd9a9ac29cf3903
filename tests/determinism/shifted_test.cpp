// A scene moved in space by an offset that no coordinate rounds under gives the same bits relative to the domain's
// corner: storage is relative to it (DESIGN 2), far from the origin nothing is lost.
// Positions are multiples of 2^-30 m, offsets multiples of 2^-20 m below 2^10 m: every sum is exact in 53 bits.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/base/rng.hpp"
#include "tests/determinism/scenes.hpp"
#include "tests/determinism/variants.hpp"

namespace talus::determinism {
namespace {

double grid(double x) { return std::floor(x * 0x1p30) * 0x1p-30; }

Vec3 grid(Vec3 v) { return {grid(v.x), grid(v.y), grid(v.z)}; }

/// The sheared bed with grains from a file, everything shifted by `by`.
Scene shifted(Vec3 by, bool walls) {
  Scene s = sheared_bed();
  const Vec3 size = grid(s.domain.upper - s.domain.lower);
  std::string csv = "x,y,z,radius,vx,vy,vz\n";
  const CounterRng rng(5, 6);
  std::uint64_t n = 0;
  const double pitch = grid(2.05e-3);
  for (int z = 0; z < 9; ++z)
    for (int y = 0; y < 7; ++y)
      for (int x = 0; x < 11; ++x) {
        const Vec3 c = grid(Vec3{0.5 + x + rng.uniform(n), 0.5 + y + rng.uniform(n + 1), 0.5 + z});
        const Vec3 at =
            grid(Vec3{pitch * (0.5 + x) + 1e-4 * (c.x - std::floor(c.x)), pitch * (0.5 + y), pitch * (0.6 + z)}) + by;
        char line[256];
        std::snprintf(line, sizeof line, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", at.x, at.y, at.z,
                      rng.uniform(n + 2, 0.85e-3, 1e-3), rng.uniform(n + 3, -0.5, 0.5), rng.uniform(n + 4, -0.5, 0.5),
                      rng.uniform(n + 5, -0.8, 0.2));
        csv += line;
        n += 6;
      }
  s.domain.lower = by;
  s.domain.upper = size + by;
  Source file;
  file.kind = Source::Kind::file;
  file.name = "bed";
  file.file = temporary_file("shifted_" + std::to_string(by.x) + ".csv", csv);
  s.sources = {file};
  s.groups[0].region->lower = by;
  s.groups[0].region->upper = Vec3{size.x, size.y, grid(1.8e-3)} + by;
  s.groups[1].region->lower = grid(Vec3{0, 0, 0.0165}) + by;
  s.groups[1].region->upper = size + by;
  if (walls) {
    WallSpec obstacle;
    obstacle.name = "obstacle";
    obstacle.shape = WallShape::box;
    obstacle.lower = grid(Vec3{0.009, 0.005, -0.001}) + by;
    obstacle.upper = grid(Vec3{0.013, 0.009, 0.004}) + by;
    obstacle.motion.velocity = {0.05, 0, 0.02};
    s.walls = {obstacle};
    s.allow_initial_overlap = true;
    s.max_overlap = 4;  // the obstacle starts inside the crowd
  } else {
    s.domain.boundary[2] = {Boundary::periodic, Boundary::periodic};
  }
  return s;
}

std::uint64_t hash_of(const Scene& scene) {
  RunOptions o;
  o.threads = 1;
  Simulation sim(scene, o);
  std::int64_t contacts = 0;
  for (int part = 0; part < 10; ++part) {
    sim.run(k_steps / 10);
    contacts += sim.counters().contacts;
  }
  EXPECT_GT(sim.particles(), 600);
  EXPECT_GT(contacts, 1000);
  return sim.state_hash();
}

TEST(Shifted, PeriodicSceneKeepsItsBitsAnywhere) {
  const std::uint64_t home = hash_of(shifted({}, false));
  EXPECT_EQ(hash_of(shifted({1, -2, 4}, false)), home);
  EXPECT_EQ(hash_of(shifted({0.25, 300.125, -700.0625}, false)), home);
}

TEST(Shifted, SceneWithWallsKeepsItsBitsAnywhere) {
  const std::uint64_t home = hash_of(shifted({}, true));
  EXPECT_EQ(hash_of(shifted({1, -2, 4}, true)), home);
  EXPECT_EQ(hash_of(shifted({0.25, 300.125, -700.0625}, true)), home);
}

// An offset under which coordinates do round is another scene: the comparison can fail.
TEST(Shifted, RoundingOffsetIsAnotherScene) {
  EXPECT_NE(hash_of(shifted({0.1, 0.3, 1e8 / 3}, false)), hash_of(shifted({}, false)));
}

}  // namespace
}  // namespace talus::determinism
