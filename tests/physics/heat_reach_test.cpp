// What grains exchange heat with and through what: both layers of gas, images, grown grains, walls behind a layer.
// Expected flows are sums over pairs and images by the formulae of core/heat, or closed forms of resistances in series.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/heat/contact.hpp"
#include "core/heat/radiation.hpp"
#include "tests/part_values.hpp"
#include "tests/physics/physics_support.hpp"

namespace talus::physics {
namespace {

constexpr double k_rho = 2500, k_c = 800, k_k = 5, k_r = 5e-3, k_dt = 1e-3;

std::vector<double> temperatures(const Simulation& sim) {
  for (const ExtraColumn& c : sim.frame().extra)
    if (c.name == "temperature") return c.values;
  ADD_FAILURE() << "no temperatures";
  return {};
}

Grain still(Vec3 x, double r = k_r) {
  Grain g;
  g.x = x;
  g.r = r;
  g.fixed = true;
  return g;
}

/// Fixed grains of their own temperatures; every step is a heat step.
Scene resting(const std::vector<Grain>& grains, const std::vector<double>& T, Vec3 upper = {1, 1, 1}) {
  Scene s = open_scene({0, 0, 0}, upper, k_dt);
  s.materials[0].density = k_rho;
  s.allow_unstable_step = s.allow_initial_overlap = true;
  linear_law(s, 1, 0);
  s.heat.on = true;
  s.heat.every = 1;
  s.heat.temperature = 300;
  MatterHeat m;
  m.capacity = Curve::constant(k_c);
  m.conductivity = Curve::constant(k_k);
  s.heat.matter = {m};
  for (std::size_t k = 0; k < grains.size(); ++k) {
    add_grains(s, {grains[k]});
    s.heat.sources.push_back({T[k], false});
  }
  return s;
}

/// What each grain gains in the first heat step [W].
std::vector<double> flows(const Scene& s, const std::vector<Grain>& grains, const std::vector<double>& T) {
  Simulation sim(s, options());
  sim.run(1);
  std::vector<double> q = temperatures(sim);
  for (std::size_t k = 0; k < q.size(); ++k) q[k] = (q[k] - T[k]) * sphere_mass(k_rho, grains[k].r) * k_c / k_dt;
  return q;
}

TEST(HeatReach, GasConductsUpToTheEndOfBothLayersOfAnySizes) {
  constexpr double k_gas = 0.03, k_layer = 0.4;
  for (const double q : {1.0, 0.5, 0.1}) {
    const double r_star = heat::reduced(k_r, q * k_r), end = 2 * k_layer * (2 * r_star);  // two layers of the mean 2 R*
    for (const double share : {0.1, 0.49, 0.51, 0.9, 0.999, 1.001}) {
      const double gap = share * end;
      const std::vector<Grain> two{still({0.5, 0.5, 0.5}), still({0.5 + k_r + q * k_r + gap, 0.5, 0.5}, q * k_r)};
      Scene s = resting(two, {400, 300});
      s.heat.gap.conductivity = k_gas;
      const double wanted = 100 * heat::gap_conductance(k_gas, 2 * r_star, gap, k_layer, s.heat.gap.least_gap);
      EXPECT_EQ(wanted > 0, share < 1);
      EXPECT_NEAR(flows(s, two, {400, 300})[1], wanted, 1e-9) << q << " " << share;
    }
  }
}

/// Grains of a box with periodic sides of length L, along x and y, at random.
struct ThinBox {
  static constexpr double k_l = 4.2 * k_r;
  std::vector<Grain> grains;
  std::vector<double> T;
  explicit ThinBox(Vec3 shift = {}) {
    const auto folded = [](double x) { return x - k_l * std::floor(x / k_l); };
    for (std::uint64_t k = 0; k < 6; ++k) {
      const double r = k_r * (0.5 + 0.5 * uniform(31, k));
      const Vec3 x{k_l * uniform(32, k), k_l * uniform(33, k), 0.02 + 1.2 * k_r * static_cast<double>(k)};
      grains.push_back(still({folded(x.x + shift.x), folded(x.y + shift.y), x.z + shift.z}, r));
      T.push_back(400 + 800 * uniform(34, k));
    }
  }
  Scene scene(double range) const {
    Scene s = resting(grains, T, {k_l, k_l, 0.3});
    for (std::size_t k : {0U, 1U}) s.domain.boundary[k] = {Boundary::periodic, Boundary::periodic};
    s.heat.gap.conductivity = 0.03;
    s.heat.matter[0].conductivity = Curve::constant(0);  // grains that happen to touch
    s.heat.radiation.grains = true;
    s.heat.radiation.range = range;
    s.max_overlap = 1;
    return s;
  }
};

/// By images of all grains, two more periods each way than any reach.
std::vector<double> by_images(const ThinBox& b, const Scene& s) {
  const std::size_t n = b.grains.size();
  const int most = static_cast<int>(k_r * (2 + s.heat.radiation.range) / ThinBox::k_l) + 2;
  const auto each = [&](std::size_t i, auto fn) {
    for (std::size_t j = 0; j < n; ++j)
      for (int x = -most; x <= most; ++x)
        for (int y = -most; y <= most; ++y) {
          if (i == j && x == 0 && y == 0) continue;
          const double r = b.grains[i].r, q = b.grains[j].r;
          const double d = norm(b.grains[j].x + Vec3{x * ThinBox::k_l, y * ThinBox::k_l, 0} - b.grains[i].x);
          const bool sees = d < r + q + s.heat.radiation.range * 0.5 * (r + q);
          fn(j, sees ? heat::exchange_area(r, q, d) : 0.0,
             heat::gap_conductance(0.03, 2 * heat::reduced(r, q), d - r - q, s.heat.gap.layer, s.heat.gap.least_gap));
        }
  };
  std::vector<double> shade(n), q(n);
  for (std::size_t i = 0; i < n; ++i) {
    double seen = 0;
    each(i, [&](std::size_t, double area, double) { seen += area; });
    shade[i] = std::min(1.0, 4 * k_pi * b.grains[i].r * b.grains[i].r / seen);
  }
  const double grey = heat::grey_factor(0.9, 0.9);
  for (std::size_t i = 0; i < n; ++i)
    each(i, [&](std::size_t j, double area, double gap) {
      const double black = heat::k_stefan * area * std::min(shade[i], shade[j]) * grey;
      q[i] += gap * (b.T[j] - b.T[i]) + black * (std::pow(b.T[j], 4) - std::pow(b.T[i], 4));
    });
  return q;
}

TEST(HeatReach, EveryImageInAThinPeriodicBoxTakesPart) {
  for (const double range : {0.5, 1.5, 10.0}) {
    const ThinBox box;
    const Scene s = box.scene(range);
    const std::vector<double> q = flows(s, box.grains, box.T), wanted = by_images(box, s);
    for (std::size_t k = 0; k < q.size(); ++k) EXPECT_NEAR(q[k], wanted[k], 1e-7 * std::fabs(wanted[k]) + 1e-9) << k;
    const ThinBox moved({0.37 * ThinBox::k_l, 0.81 * ThinBox::k_l, 0.013});
    const std::vector<double> there = flows(moved.scene(range), moved.grains, moved.T);
    for (std::size_t k = 0; k < q.size(); ++k) EXPECT_NEAR(there[k], q[k], 1e-7 * std::fabs(q[k]) + 1e-9) << k;
  }
}

TEST(HeatReach, GrainsThatHaveGrownSeeAsFarAsTheirRadiiWhereverTheyAre) {
  // one grows by more than a half beside one that is held at its temperature
  const auto hottest = [](double x) {
    const std::vector<Grain> two{{{x, 0.05, 0.05}, {}, k_r}, {{x + 0.0202, 0.05, 0.05}, {}, k_r}};
    Scene s = resting(two, {300, 300}, {0.1, 0.1, 0.1});
    s.dt = 1e-4;
    s.heat.every = 10;
    s.heat.matter[0].capacity = Curve::constant(100);
    s.heat.matter[0].expansion = 1e-3;
    s.heat.sources[1].held = true;
    s.heat.gas.on = true;
    s.heat.gas.film = 1000;
    s.heat.gas.temperature = TimeTable::constant(1300);
    s.heat.radiation.grains = true;
    Simulation sim(s, options());
    sim.run(4000);
    return value_of(sim, "heat.highest");
  };
  const double there = hottest(0.0197);
  for (const double x : {0.0198, 0.0199, 0.0201}) EXPECT_NEAR(hottest(x), there, 1e-8) << x;
}

/// A grain that rests on a wall with a layer [m, W/m/K].
struct OnLayer {
  static constexpr double k_overlap = 1e-5, k_T = 600, k_wall = 900;
  static double layer() { return 0.05 * k_pi * k_r * k_r / 0.01; }
  static double touch() { return 2 * k_k * std::sqrt(k_r * k_overlap); }
  static Scene scene(bool layered) {
    Scene s = resting({still({0.5, 0.5, k_r - k_overlap})}, {k_T});
    s.walls = {plane("floor", {0, 0, 0}, {0, 0, 1})};
    WallHeat w;
    w.wall = "floor";
    w.temperature = TimeTable::constant(k_wall);
    if (layered) w.layer = {0.01, 0.05};
    s.heat.walls = {w};
    return s;
  }
  static double flow(const Scene& s) {
    Simulation sim(s, options());
    sim.run(1);
    return value_of(sim, "heat.flow.floor");
  }
};

TEST(HeatWalls, ContactAndGapPassALayerTogether) {
  const double most = OnLayer::layer() * (OnLayer::k_wall - OnLayer::k_T);
  for (const double gas : {0.0, 1e-3, 0.1, 10.0}) {
    Scene s = OnLayer::scene(true);
    s.heat.gap.conductivity = gas;
    double beside = OnLayer::touch();
    if (gas > 0) beside += heat::gap_conductance_to_plane(gas, k_r, -OnLayer::k_overlap, 0.4, s.heat.gap.least_gap);
    const double flow = OnLayer::flow(s);
    EXPECT_NEAR(flow / (most / (1 + OnLayer::layer() / beside)), 1, 1e-9) << gas;
    EXPECT_LT(flow, most);
  }
}

TEST(HeatWalls, LayerPassesWhatItsSurfaceRadiatesToo) {
  const double T = OnLayer::k_T, Tw = OnLayer::k_wall, most = OnLayer::layer() * (Tw - T);
  const double distance = k_r - OnLayer::k_overlap;
  for (const double range : {1.5, 10.0}) {
    Scene s = OnLayer::scene(true);
    s.heat.radiation.grains = true;
    s.heat.radiation.range = range;
    const double reach = k_r * (1 + 0.5 * range);
    const double black =
        heat::k_stefan * 4 * k_pi * k_r * k_r * heat::share_of_plane(distance, reach) * heat::grey_factor(0.9, 0.9);
    double low = T, high = Tw;  // of the layer's surface: what it gets it gives
    for (int k = 0; k < 200; ++k) {
      const double at = 0.5 * (low + high);
      const double gives = OnLayer::touch() * (at - T) + black * (std::pow(at, 4) - std::pow(T, 4));
      (gives < OnLayer::layer() * (Tw - at) ? low : high) = at;
    }
    const double flow = OnLayer::flow(s);
    EXPECT_NEAR(flow / (OnLayer::layer() * (Tw - low)), 1, 1e-9);
    EXPECT_LT(flow, most);
    EXPECT_GT(flow, most / (1 + OnLayer::layer() / OnLayer::touch()));
  }
}

TEST(HeatWalls, ConductAsTheirMaterialDoesAtTheTemperatureOfTheWall) {
  Scene s = OnLayer::scene(false);
  s.heat.matter[0].conductivity = {{}, 0, 0, 0, {600, 900}, {1, 10}};
  EXPECT_NEAR(OnLayer::flow(s), 4 * (1 * 10.0) / (1 + 10) * std::sqrt(k_r * OnLayer::k_overlap) * 300, 1e-9);
}

}  // namespace
}  // namespace talus::physics
