// Averages and fluxes against closed forms.
#include "core/averages.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"

namespace talus {
namespace {

constexpr double k_pi = 3.14159265358979323846;

Scene box(Vec3 lower, Vec3 upper, Boundary side = Boundary::wall) {
  Scene s;
  s.domain.lower = lower;
  s.domain.upper = upper;
  for (auto& b : s.domain.boundary) b = {side, side};
  s.materials = {{"a", 1000, 0, 0}, {"b", 3000, 0, 0}};
  s.dt = 0.001;
  return s;
}

void add(Frame& f, ParticleId id, Vec3 x, double r, Vec3 v = {}, int material = 0) {
  f.id.push_back(id);
  f.x.push_back(x);
  f.v.push_back(v);
  f.r.push_back(r);
  f.material.push_back(static_cast<std::uint8_t>(material));
}

TEST(Averages, SphereCutByOneFaceCountsItsExactCap) {
  Frame f;
  add(f, 0, {0, 0, 1.0}, 0.5);
  const Scene s = box({-2, -2, -2}, {2, 2, 2});
  for (double face : {0.5, 0.6, 1.0, 1.37, 1.5}) {
    const double h = face - 0.5;  // height of the cap below the face
    const double cap = k_pi * h * h * (3 * 0.5 - h) / 3;
    const auto a = average_region(f, s, {{-1, -1, 0}, {1, 1, face}, 0});
    EXPECT_NEAR(a.solid_fraction * 4 * face, cap, 1e-15);
  }
}

TEST(Averages, VelocityTemperatureAndStressAreMassAndVolumeWeighted) {
  Frame f;
  add(f, 0, {0.2, 0.2, 0.2}, 0.1, {1, 0, 0}, 0);
  add(f, 1, {0.8, 0.8, 0.8}, 0.1, {5, 0, 0}, 1);  // three times the density
  f.coordination = {2, 6};
  f.stress = {{10, 0, 0, 0, 0, 0}, {30, 0, 0, 0, 7, 0}};
  const Scene s = box({0, 0, 0}, {1, 1, 1});
  const auto a = average_region(f, s, {{0, 0, 0}, {1, 1, 1}, 0});
  const double volume = 4.0 / 3 * k_pi * 0.001;
  EXPECT_NEAR(a.particles, 2, 1e-14);
  EXPECT_NEAR(a.velocity.x, 4, 1e-14);                             // (1 + 3*5) / 4
  EXPECT_NEAR(a.temperature, (1 * 9 + 3 * 1) / (3.0 * 4), 1e-14);  // deviations -3 and 1
  EXPECT_NEAR(a.coordination, 4, 1e-14);
  EXPECT_NEAR(a.stress[0], 40 * volume, 1e-14);
  EXPECT_NEAR(a.stress[4], 7 * volume, 1e-14);
  const auto none = average_region(f, s, {{0.4, 0.4, 0.4}, {0.5, 0.5, 0.5}, 0});
  EXPECT_EQ(none.particles, 0);
  EXPECT_EQ(none.temperature, 0);
  EXPECT_EQ(none.velocity.x, 0);
}

TEST(Averages, CylinderRegionCountsWhatIsInside) {
  Frame f;
  add(f, 0, {0, 0, 0.5}, 0.1);
  add(f, 1, {0.5, 0, 0.5}, 0.1);      // centre on the lateral surface: about half inside
  add(f, 2, {0.45, 0.45, 0.5}, 0.1);  // in the box around the cylinder, outside of it
  const auto a = average_region(f, box({-1, -1, 0}, {1, 1, 1}), {{-0.5, -0.5, 0}, {0.5, 0.5, 1}, 0.5});
  EXPECT_NEAR(a.particles, 1.5, 1e-12);
  EXPECT_NEAR(a.solid_fraction, 1.5 * 4.0 / 3 * k_pi * 0.001 / (k_pi * 0.25), 1e-12);
}

TEST(Averages, GridHoldsEverySphereOnce) {
  Scene s = box({-1, 0, 2}, {1, 1, 5});
  Frame f;
  double volume = 0;
  for (int k = 0; k < 200; ++k) {
    const double a = (k * 37 % 100) / 100.0, b = (k * 61 % 100) / 100.0, c = (k * 17 % 100) / 100.0;
    const double r = 0.02 + 0.0013 * (k % 60);
    add(f, k, {-1 + r + a * (2 - 2 * r), r + b * (1 - 2 * r), 2 + r + c * (3 - 2 * r)}, r, {1, 2, 3});
    volume += 4.0 / 3 * k_pi * r * r * r;
  }
  for (auto cells : {std::array<int, 3>{1, 1, 1}, {7, 3, 11}, {40, 20, 60}}) {
    const GridData g = average_grid(f, s, cells);
    double total = 0;
    const auto& fraction = std::get<0>(g.cell_data[0].values);
    const auto& velocity = std::get<0>(g.cell_data[1].values);
    const auto& temperature = std::get<0>(g.cell_data[2].values);
    ASSERT_EQ(fraction.size(), static_cast<std::size_t>(cells[0] * cells[1] * cells[2]));
    for (std::size_t c = 0; c < fraction.size(); ++c) {
      total += fraction[c] * g.spacing.x * g.spacing.y * g.spacing.z;
      if (fraction[c] > 1e-12) {
        EXPECT_NEAR(velocity[3 * c + 2], 3, 1e-9);
      }
      EXPECT_LT(temperature[c], 1e-20);
    }
    EXPECT_NEAR(total, volume, 1e-12);
  }
  EXPECT_THROW(average_grid(f, s, {0, 1, 1}), Error);
}

TEST(Averages, PeriodicGridWrapsAndAgreesWithRegions) {
  Scene s = box({0, 0, 0}, {1, 1, 1}, Boundary::periodic);
  Frame f;
  add(f, 0, {0, 0.5, 0.5}, 0.2);  // half of it appears at the other end
  const GridData g = average_grid(f, s, {4, 1, 1});
  const auto& fraction = std::get<0>(g.cell_data[0].values);
  EXPECT_NEAR(fraction[0], fraction[3], 1e-14);
  EXPECT_NEAR(fraction[0] * 0.25, 0.5 * 4.0 / 3 * k_pi * 0.008, 1e-14);
  EXPECT_EQ(fraction[1], 0);
  const auto region = average_region(f, s, {{0, 0, 0}, {0.25, 1, 1}, 0});
  EXPECT_NEAR(region.solid_fraction, fraction[0], 1e-14);
}

Scene flux_scene(Vec3 point, Vec3 normal) {
  Scene s = box({0, 0, 0}, {1, 1, 1});
  s.domain.boundary[2][0] = Boundary::open;
  s.output.flux_planes = {{"p", point, normal}};
  return s;
}

Frame at(double time, std::vector<std::pair<ParticleId, Vec3>> particles, Vec3 v = {}) {
  Frame f;
  f.time = time;
  for (auto [id, x] : particles) add(f, id, x, 0.1, v, id % 2 == 0 ? 0 : 1);
  return f;
}
const double k_mass = 4.0 / 3 * k_pi * 0.001 * 1000;  // of an even id; odd ones weigh three times as much

TEST(Flux, CountsNetPassagesAlongTheNormal) {
  FluxPlanes flux(flux_scene({0, 0, 0.5}, {0, 0, -1}));
  flux.update(at(0, {{0, {0.5, 0.5, 0.6}}, {1, {0.5, 0.5, 0.7}}, {2, {0.1, 0.1, 0.2}}}));
  EXPECT_EQ(flux.totals()[0].particles, 0);
  flux.update(at(1, {{0, {0.5, 0.5, 0.4}}, {1, {0.5, 0.5, 0.3}}, {2, {0.1, 0.1, 0.2}}}));
  EXPECT_EQ(flux.totals()[0].particles, 2);
  EXPECT_NEAR(flux.totals()[0].mass, 4 * k_mass, 1e-12);
  flux.update(at(2, {{0, {0.5, 0.5, 0.8}}, {1, {0.5, 0.5, 0.3}}, {2, {0.1, 0.1, 0.2}}}));
  EXPECT_EQ(flux.totals()[0].particles, 1);  // one came back
  EXPECT_NEAR(flux.totals()[0].mass, 3 * k_mass, 1e-12);
}

TEST(Flux, ParticlesThatLeftBetweenFramesPassedThePlanesBelow) {
  FluxPlanes flux(flux_scene({0, 0, 0.2}, {0, 0, -1}));
  flux.update(at(0, {{0, {0.5, 0.5, 0.6}}, {1, {0.5, 0.5, 0.1}}, {2, {0.5, 0.5, 0.9}}}));
  flux.update(at(1, {{2, {0.5, 0.5, 0.5}}, {3, {0.5, 0.5, 0.1}}}));  // 0 and 1 left below, 3 is new
  EXPECT_EQ(flux.totals()[0].particles, 1);                          // 1 was below before
  flux.update(at(2, {{3, {0.5, 0.5, 0.1}}}));
  EXPECT_EQ(flux.totals()[0].particles, 2);
}

TEST(Flux, RemovalByAnEventIsNoPassage) {
  Scene s = flux_scene({0, 0, 0.2}, {0, 0, -1});
  Event e;
  e.action = Event::Action::remove;
  e.time = 0.5;
  s.events = {e};
  FluxPlanes flux(s);
  flux.update(at(0, {{0, {0.5, 0.5, 0.6}}}));
  flux.update(at(1, {}));
  EXPECT_EQ(flux.totals()[0].particles, 0);
}

TEST(Flux, PeriodicWrapIsNoPassageOfAPlaneInTheMiddleButOneAtTheSeam) {
  for (auto [plane, expected] : {std::pair{0.5, 0}, {0.97, 1}, {0.02, 1}}) {
    Scene s = flux_scene({plane, 0, 0}, {1, 0, 0});
    s.domain.boundary[0] = {Boundary::periodic, Boundary::periodic};
    FluxPlanes flux(s);
    flux.update(at(0, {{0, {0.95, 0.5, 0.5}}}));
    flux.update(at(1, {{0, {0.05, 0.5, 0.5}}}));
    EXPECT_EQ(flux.totals()[0].particles, expected) << plane;
    flux.update(at(2, {{0, {0.95, 0.5, 0.5}}}));
    EXPECT_EQ(flux.totals()[0].particles, 0) << plane;
  }
}

TEST(Flux, StateSurvivesACheckpoint) {
  const Scene s = flux_scene({0, 0, 0.5}, {0, 0, -1});
  const Frame first = at(0, {{0, {0.5, 0.5, 0.6}}, {1, {0.5, 0.5, 0.7}}}), second = at(1, {{0, {0.5, 0.5, 0.4}}});
  FluxPlanes whole(s), resumed(s);
  whole.update(first);
  resumed.load(whole.save());
  whole.update(second);
  resumed.update(second);
  EXPECT_EQ(whole.totals()[0].particles, 2);
  EXPECT_EQ(resumed.totals()[0].particles, 2);
  EXPECT_EQ(whole.save(), resumed.save());
  auto bytes = whole.save();
  bytes.pop_back();
  EXPECT_THROW(resumed.load(bytes), Error);
  EXPECT_THROW(resumed.load({}), Error);
  Scene other = s;
  other.output.flux_planes.push_back(other.output.flux_planes[0]);
  EXPECT_THROW(FluxPlanes(other).load(whole.save()), Error);
}

}  // namespace
}  // namespace talus
