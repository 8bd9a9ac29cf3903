// Angle of repose: a bed on a rough base between a wall and a gate; the gate vanishes, grains drain over the open edge,
// and what stays is a slope. Its angle must rise with friction; no exact value exists.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladder.hpp"

namespace talus::verification {
namespace {

struct Heap {
  double angle = 0;  ///< [degrees]
  double left = 0;   ///< share of the grains that stay
  double speed = 0;  ///< median at the end [sqrt(g d)]
};

Heap drain(double mu, std::uint64_t seed) {
  const double r = 0.5, kn = 1e4, dt = k_pi * std::sqrt(0.5 / kn) / 15, width = 15, depth = 8;
  const int levels = 13;
  Scene s = open_scene({0, 0, 0}, {width, depth, 30}, dt);
  s.domain.boundary[0] = {Boundary::wall, Boundary::open};
  s.domain.boundary[1] = {Boundary::periodic, Boundary::periodic};
  s.materials[0].density = density_of(1, r);
  linear_restitution(s, kn, 0.5, 2.0 / 7.0 * kn, mu);
  s.gravity = {0, 0, -1};
  s.allow_initial_overlap = true;  // of base grains among themselves; they are fixed
  s.max_overlap = 1;
  WallSpec gate = plane("gate", {width, 0, 0}, {-1, 0, 0});
  gate.vanish = 25;
  s.walls.push_back(gate);
  std::vector<Grain> grains;
  std::uint64_t draw = 0;
  for (int i = 0; i < static_cast<int>(width); ++i)
    for (int j = 0; j < static_cast<int>(depth); ++j) {
      Grain g{{i + 0.5, j + 0.5, 0.6 + 0.5 * uniform(41, draw)}, {0, 0, 0}, r};
      g.fixed = true;
      draw += 1;
      grains.push_back(g);
    }
  const std::size_t fixed = grains.size();
  const int nx = static_cast<int>((width - 0.2) / 1.08), ny = static_cast<int>(depth / 1.08);
  for (int k = 0; k < nx * ny * levels; ++k, draw += 2) {
    const int level = k / (nx * ny);
    grains.push_back({{0.6 + (width - 1.2) / (nx - 1) * (k % nx), depth / ny * (k / nx % ny + 0.5), 2.2 + 1.05 * level},
                      {0.5 * gauss(42 + seed, draw), 0.5 * gauss(42 + seed, draw + 1), 0},
                      r});
  }
  add_grains(s, grains);
  Simulation sim(s, options());
  sim.run(std::llround(130 / dt));
  const Frame f = sim.frame();
  Heap out;
  std::vector<std::vector<double>> column(static_cast<std::size_t>(width));
  double free = 0;
  std::vector<double> speeds;
  for (std::size_t k = 0; k < f.x.size(); ++k) {
    column[static_cast<std::size_t>(std::clamp(f.x[k].x, 0.0, width - 1))].push_back(f.x[k].z);
    if (f.id[k] < static_cast<ParticleId>(fixed)) continue;
    free += 1;
    speeds.push_back(norm(f.v[k]));
  }
  out.speed = quantile(speeds, 0.5);  // single grains may still roll over the edge
  out.left = free / static_cast<double>(grains.size() - fixed);
  // surface: mean height of the three topmost grains of each slice of one diameter, away from wall and edge
  std::vector<double> x, z;
  for (std::size_t b = 1; b + 3 < column.size(); ++b) {
    std::sort(column[b].rbegin(), column[b].rend());
    x.push_back(static_cast<double>(b) + 0.5);
    z.push_back((column[b][0] + column[b][1] + column[b][2]) / 3);
  }
  out.angle = std::atan(-fit_line(x, z).slope) * 180 / k_pi;
  return out;
}

TEST(Heap, AngleOfReposeRisesWithFriction) {
  const int seeds = full() ? 8 : 3;
  double last = 0;
  for (const double mu : {0.05, 0.2, 0.8}) {
    std::vector<double> angles;
    double mean = 0;
    for (int seed = 0; seed < seeds; ++seed) {
      const Heap h = drain(mu, static_cast<std::uint64_t>(seed));
      const std::string name = "heap, mu " + std::to_string(mu).substr(0, 4) + ", seed " + std::to_string(seed);
      figure(name + ": angle of repose [deg]", h.angle,
             "stays " + std::to_string(h.left) + ", speed at the end " + std::to_string(h.speed));
      // the bed is at rest
      EXPECT_LT(h.speed, 0.01) << name;
      angles.push_back(h.angle);
      mean += h.angle / seeds;
    }
    double scatter = 0;
    for (const double a : angles) scatter += (a - mean) * (a - mean) / (seeds - 1);
    figure("heap, mu " + std::to_string(mu).substr(0, 4) + ": mean angle of repose [deg]", mean,
           "scatter of one heap " + std::to_string(std::sqrt(scatter)));
    EXPECT_GT(mean, last + 1) << mu;
    last = mean;
  }
  EXPECT_LT(last, 40);
}

}  // namespace
}  // namespace talus::verification
