// Touches of one surface share what they overlap with: the distance to the place where none of them is touched.
#include "core/walls/shared_overlaps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "core/base/rng.hpp"

namespace talus {
namespace {

Touch face(double tilt, double azimuth, double overlap, int surface = 0) {
  Touch t;
  t.normal = {std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt)};
  t.overlap = overlap;
  t.surface = surface;
  return t;
}

/// Least distance to { x : x.n >= overlap of every face }, by projections in turn (Dykstra).
Vec3 nearest_free(const std::vector<Touch>& faces) {
  Vec3 x;
  std::vector<Vec3> correction(faces.size());
  for (int round = 0; round < 100000; ++round) {
    double change = 0;
    for (std::size_t k = 0; k < faces.size(); ++k) {
      const Vec3 y = x + correction[k];
      const double lack = std::max(0.0, faces[k].overlap - dot(y, faces[k].normal));
      const Vec3 z = y + lack * faces[k].normal;
      correction[k] = y - z;
      change = std::max(change, norm(z - x));
      x = z;
    }
    if (change < 1e-15) break;
  }
  return x;
}

TEST(SharedOverlaps, OneSharpFoldOrOtherSurfacesKeepTheirOwn) {
  std::vector<Touch> one{face(0, 0, 1)}, sharp{face(0, 0, 1), face(0.6, 0, 1)},
      corner{face(0, 0, 1), face(M_PI / 2, 0, 1)};
  std::vector<Touch> two{face(0, 0, 1), face(0.2, 0, 1, 1)};
  for (auto* touches : {&one, &sharp, &corner, &two}) EXPECT_FALSE(share_overlaps(*touches));
}

TEST(SharedOverlaps, JointOverlapIsTheDistanceToWhereNothingIsTouched) {
  const CounterRng rng(11, 1);
  std::uint64_t draw = 0;
  int shared[4]{};
  for (int scene = 0; scene < 2000; ++scene) {
    std::vector<Touch> faces;
    const int n = 2 + scene % 4;
    // all within 16 degrees of one direction, so that each pair is below 32
    for (int k = 0; k < n; ++k)
      faces.push_back(
          face(rng.uniform(draw, 0, 0.275), rng.uniform(draw + 1, 0, 2 * M_PI), rng.uniform(draw + 2, 0.97, 1))),
          draw += 3;
    const Vec3 right = nearest_free(faces);
    ASSERT_TRUE(share_overlaps(faces));
    const auto joint = std::find_if(faces.begin(), faces.end(), [](const Touch& t) { return t.share > 0; });
    ASSERT_NE(joint, faces.end());
    const JointContact c = joint_contact(faces, joint->group);
    EXPECT_NEAR(c.overlap, norm(right), 1e-9) << "scene " << scene;
    EXPECT_NEAR(norm(c.overlap * c.normal - right), 0, 1e-7) << "scene " << scene;
    ++shared[c.members];
  }
  for (int members = 1; members <= 3; ++members) EXPECT_GT(shared[members], 20) << members;
}

TEST(SharedOverlaps, OfAChainOfFacetsTheForceHasNoLeap) {
  // slopes of -20, 0, 20 degrees: the outer two are no neighbours; the grain sinks straight down, or askew
  const double tilt = 20 * M_PI / 180;
  for (const double side : {0.0, 0.01, 0.1}) {
    Vec3 last;
    double sum = 0, largest = 0;
    for (int k = 0; k <= 20000; ++k) {
      const double depth = 0.1 * k / 20000;
      const Vec3 x{side * depth, 0, -depth};
      std::vector<Touch> faces;
      for (const auto& [t, azimuth, gap] : {std::tuple{tilt, 0.0, 0.008}, {0.0, 0.0, 0.0}, {tilt, M_PI, 0.008}}) {
        Touch f = face(t, azimuth, 0);
        f.overlap = -dot(x, f.normal) - gap;
        if (f.overlap > 0) faces.push_back(f);
      }
      Vec3 force;
      if (!faces.empty() && share_overlaps(faces)) {
        int contacts = 0;
        for (int g = 0; g < static_cast<int>(faces.size()); ++g) {
          if (faces[g].group != g) continue;
          const JointContact c = joint_contact(faces, g);
          force = force + c.overlap * c.normal;
          contacts += c.overlap > 0;
        }
        EXPECT_EQ(contacts, 1);
      } else if (!faces.empty()) {
        force = faces[0].overlap * faces[0].normal;
      }
      sum += norm(force - last);
      largest = std::max(largest, norm(force - last));
      last = force;
    }
    EXPECT_LT(largest, 3e-5) << "a step sinks by 5e-6, wedged up to three times as much: " << side;
    EXPECT_GT(sum, 0.09);
  }
}

TEST(SharedOverlaps, FacetsInOnePlaneAndCopiesAreOneContact) {
  for (const double tilt : {0.0, 1e-12, 1e-9, 1e-6}) {
    std::vector<Touch> faces{face(0, 0, 1), face(tilt, 0, 1), face(tilt, 2, 1), face(0, 0, 1)};
    ASSERT_TRUE(share_overlaps(faces));
    int contacts = 0;
    for (int k = 0; k < 4; ++k) {
      if (faces[k].group != k) continue;
      const JointContact c = joint_contact(faces, k);
      if (!(c.overlap > 0)) continue;
      ++contacts;
      EXPECT_NEAR(c.overlap, 1, 1e-6);
      EXPECT_NEAR(norm(c.normal - Vec3{0, 0, 1}), 0, 2e-6);
    }
    EXPECT_EQ(contacts, 1) << tilt;
  }
}

TEST(SharedOverlaps, CornersOfSpheresAreJudgedWithoutTheirOverlap) {
  // two corners whose normals pass the limit while the sphere sinks in: the same contacts before and after
  const double radius = 1, half = 0.2739;  // 1 - 2 half^2 = 0.84996: apart
  for (const double depth : {1e-6, 1e-3, 1e-2, 5e-2}) {
    const double height = std::sqrt((radius - depth) * (radius - depth) - half * half);
    std::vector<Touch> corners;
    for (const double x : {-half, half}) {
      Touch t;
      t.foot = {x, 0, -height};
      t.normal = (-1 / norm(t.foot)) * t.foot;
      t.overlap = radius - norm(t.foot);
      t.radius = radius;
      corners.push_back(t);
    }
    EXPECT_FALSE(share_overlaps(corners)) << depth;
    for (Touch& t : corners) t.foot.x = 0.9 * t.foot.x;
    EXPECT_TRUE(share_overlaps(corners)) << depth;
  }
}

}  // namespace
}  // namespace talus
