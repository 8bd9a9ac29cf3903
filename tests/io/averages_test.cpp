// Averages against closed forms.
#include "core/frame/averages.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"

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

/// Edges and corners: where more than one side cuts a grain, its share is no product of slabs.
TEST(Averages, BoxesCountTheExactOverlapAtEdgesAndInside) {
  Frame f;
  add(f, 0, {0.5, 0.5, 0.5}, 0.2);
  const Scene s = box({0, 0, 0}, {1, 1, 1});
  const auto share = [&](Vec3 lower, Vec3 upper) { return average_region(f, s, {lower, upper, 0}).particles; };
  EXPECT_NEAR(average_region(f, s, {{0.45, 0.45, 0.45}, {0.55, 0.55, 0.55}, 0}).solid_fraction, 1, 1e-12);
  // sides at 0.75 r: their edge is further than r from the centre
  EXPECT_EQ(share({0.65, 0.65, 0}, {1, 1, 1}), 0);
  EXPECT_NEAR(share({0.5, 0.5, 0}, {1, 1, 1}), 0.25, 1e-12);
  // an edge at (a, b): the parts beyond and before it are those of one side
  const double cap = share({0.62, 0, 0}, {1, 1, 1});
  EXPECT_NEAR(share({0.62, 0.55, 0}, {1, 1, 1}) + share({0.62, 0, 0}, {1, 0.55, 1}), cap, 1e-12);
  EXPECT_LT(share({0.62, 0.55, 0}, {1, 1, 1}), 0.9 * cap * share({0, 0.55, 0}, {1, 1, 1}));  // what slabs would give
  const GridData g = average_grid(f, s, {10, 10, 10});  // cells smaller than the grain: full in its middle
  const auto& fraction = std::get<0>(g.cell_data[0].values);
  EXPECT_NEAR(fraction[555], 1, 1e-12);
  Frame smaller;
  add(smaller, 0, {0.5, 0.5, 0.5}, 0.17);  // its cell at (6, 6, 6) is cut by three slabs, but its corner is 1.02 r away
  EXPECT_EQ(std::get<0>(average_grid(smaller, s, {10, 10, 10}).cell_data[0].values)[666], 0);
}

/// Where sizes change on their own, a frame says what its grains weigh.
TEST(Averages, VelocitiesAreWeighedByTheMassOfTheFrame) {
  Frame f;
  add(f, 0, {0.2, 0.2, 0.2}, 0.1, {0, 0, 0});
  add(f, 1, {0.7, 0.7, 0.7}, 0.15, {1, 0, 0});
  f.mass = {2, 2};
  const auto a = average_region(f, box({0, 0, 0}, {1, 1, 1}), {{0, 0, 0}, {1, 1, 1}, 0});
  EXPECT_NEAR(a.velocity.x, 0.5, 1e-14);
  EXPECT_NEAR(a.temperature, 0.25 / 3, 1e-14);
}

TEST(Averages, CylinderRegionCountsWhatIsInside) {
  Frame f;
  add(f, 0, {0, 0, 0.5}, 0.1);
  add(f, 1, {0.5, 0, 0.5}, 0.1);      // centre on the lateral surface: 0.4812343 inside (lenses summed along the axis)
  add(f, 2, {0.45, 0.45, 0.5}, 0.1);  // in the box around the cylinder, outside of it
  const auto a = average_region(f, box({-1, -1, 0}, {1, 1, 1}), {{-0.5, -0.5, 0}, {0.5, 0.5, 1}, 0.5});
  EXPECT_NEAR(a.particles, 1.4812343, 1e-6);
  EXPECT_NEAR(a.solid_fraction, a.particles * 4.0 / 3 * k_pi * 0.001 / (k_pi * 0.25), 1e-12);
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

TEST(Averages, GridKeepsTheThreeShearStressesApartInTheOrderOfVtk) {
  Scene s = box({0, 0, 0}, {1, 1, 1});
  s.output.stress = true;
  Frame f;
  add(f, 0, {0.5, 0.5, 0.5}, 0.1);
  f.stress = {{1, 2, 3, 12, 13, 23}};  // xx yy zz xy xz yz
  const GridData g = average_grid(f, s, {1, 1, 1});
  const auto& column = g.cell_data.back();
  ASSERT_EQ(column.name, "stress");
  const auto& stress = std::get<0>(column.values);
  const double volume = 4.0 / 3 * k_pi * 0.001, vtk[] = {1, 2, 3, 12, 23, 13};  // xx yy zz xy yz xz
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(stress[k], vtk[k] * volume, 1e-15) << k;
}

}  // namespace
}  // namespace talus
