// Claims about history across facets: match() hands it on, and 10^4 edge crossings under friction equal the plane.
#include <gtest/gtest.h>

#include <cmath>

#include "wall_support.hpp"

namespace talus {
namespace {

using namespace wall_test;

WallContact contact(std::int32_t wall, std::int32_t element, Vec3 normal) {
  WallContact c;
  c.wall = wall;
  c.element = element;
  c.normal = normal;
  return c;
}

std::vector<std::int32_t> matched(const std::vector<WallContact>& before, const std::vector<WallContact>& now) {
  std::vector<std::int32_t> from(now.size());
  WallSet().match(before, now, from.data());
  return from;
}

TEST(WallHistory, SameElementGoesFirstWhateverItsNormal) {
  const Vec3 up{0, 0, 1}, side{1, 0, 0};
  EXPECT_EQ(matched({contact(0, 4, up), contact(0, 5, up)}, {contact(0, 5, side), contact(0, 9, up)}),
            (std::vector<std::int32_t>{1, 0}));
}

TEST(WallHistory, ClosestNormalOfTheSameWallOnly) {
  const Vec3 up{0, 0, 1}, near = (1 / std::sqrt(1.01)) * Vec3{0.1, 0, 1}, far = (1 / std::sqrt(1.25)) * Vec3{0.5, 0, 1};
  // The best pair wins over the order of the new contacts.
  EXPECT_EQ(matched({contact(0, 1, up)}, {contact(0, 2, near), contact(0, 3, up)}), (std::vector<std::int32_t>{-1, 0}));
  EXPECT_EQ(matched({contact(0, 1, up)}, {contact(1, 20, up)}), (std::vector<std::int32_t>{-1}));
  EXPECT_EQ(matched({contact(0, 1, up)}, {contact(0, 2, far)}), (std::vector<std::int32_t>{-1}));  // cosine 0.894
  EXPECT_EQ(matched({contact(0, 1, up)}, {contact(0, 2, near)}), (std::vector<std::int32_t>{0}));
  EXPECT_EQ(matched({}, {contact(0, 2, near)}), (std::vector<std::int32_t>{-1}));
  EXPECT_TRUE(matched({contact(0, 2, near)}, {}).empty());
}

/// Tangential spring with a Coulomb limit, as a contact law integrates it.
struct Spring {
  double mu = 0.5;
  Vec3 stretch;
  Vec3 force(Vec3 normal, Vec3 velocity, double overlap, double dt) {
    constexpr double kn = 1e4, kt = 400;
    const Vec3 tangential = velocity - dot(velocity, normal) * normal;
    stretch = stretch - dot(stretch, normal) * normal;
    stretch = stretch + dt * tangential;
    const double ft = kt * length(stretch), limit = mu * kn * overlap;
    if (ft > limit) stretch = (limit / ft) * stretch;
    return (kn * overlap) * normal - kt * stretch;
  }
};

/// With friction 1e9 nothing ever slides and the spring holds the whole path: one lost history would show for good.
class WallHistoryDrag : public ::testing::TestWithParam<double> {};

TEST_P(WallHistoryDrag, TenThousandEdgeCrossingsUnderFrictionEqualThePlane) {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> facets;
  const int n = 60;
  const double pitch = 0.02, z = 0.25;
  random_plane(n, pitch, z, 21, points, facets);
  const WallSet mesh(scene_with({mesh_wall(write_obj("drag.obj", points, facets))}), 0.02);
  const WallSet plane(scene_with({plane_wall({0, 0, z}, {0, 0, 1})}), 0.02);

  const double radius = 0.01, overlap = 1e-4, dt = 1e-4;
  Spring on_mesh{GetParam(), {}}, on_plane{GetParam(), {}};
  std::vector<WallContact> before_mesh, before_plane;
  std::vector<std::int32_t> from;
  std::int64_t crossings = 0, slides = 0, sticks = 0;
  Vec3 x{0.1, 0.1, z + radius - overlap};
  // Constant speed along the legs of a billiard path; a turn every so often puts the spring through stick and slip.
  Vec3 v{1.0, 0.77, 0};
  while (crossings < 10000) {
    for (int k = 0; k < 2; ++k)
      if ((x[k] < 0.05 && v[k] < 0) || (x[k] > n * pitch - 0.05 && v[k] > 0)) v[k] = -v[k];
    x = x + dt * v;
    const auto a = touch(mesh, x, radius), b = touch(plane, x, radius);
    ASSERT_EQ(a.size(), 1u);
    ASSERT_EQ(b.size(), 1u);
    from.assign(1, -1);
    mesh.match(before_mesh, a, from.data());
    if (from[0] < 0) {
      ASSERT_TRUE(before_mesh.empty()) << "history lost at crossing " << crossings;
      on_mesh.stretch = {};
    }
    if (!before_mesh.empty() && before_mesh[0].element != a[0].element) ++crossings;
    const Vec3 fm = on_mesh.force(a[0].normal, v, radius - a[0].distance, dt);
    const Vec3 fp = on_plane.force(b[0].normal, v, radius - b[0].distance, dt);
    (length(on_plane.stretch) < 0.999 * GetParam() * 1e4 * overlap / 400 ? sticks : slides) += 1;
    ASSERT_NEAR(length(fm - fp), 0, 1e-10 * length(fp)) << "crossing " << crossings;
    ASSERT_NEAR(length(on_mesh.stretch - on_plane.stretch), 0, 1e-10 * length(on_plane.stretch));
    before_mesh = a;
    before_plane = b;
  }
  EXPECT_GT(GetParam() < 1 ? slides : sticks, 10000);
  EXPECT_GT(sticks, 200);
}
INSTANTIATE_TEST_SUITE_P(SlidingAndSticking, WallHistoryDrag, ::testing::Values(0.5, 1e9));

}  // namespace
}  // namespace talus
