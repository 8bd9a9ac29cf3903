// Contact of two superquadrics: against spheres, an independent solver for ellipsoids, contacts with a known answer.
#include "core/shapes/pair_contact.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "core/shapes/direction_search.hpp"
#include "tests/shapes/shape_support.hpp"

namespace talus::shapes {
namespace {
using testing::Draw;
using testing::known_contact;
using testing::KnownContact;

bool full() {
  const char* word = std::getenv("TALUS_FULL");
  return word != nullptr && *word == '1';
}

TEST(PairContact, SpheresAgreeWithTheSphereFormula) {
  Draw draw(11);
  PairCount count;
  for (int k = 0; k < 2000; ++k) {
    const double ri = draw.uniform(0.2, 1), rj = draw.uniform(0.2, 1),
                 overlap = draw.uniform(0, 0.1) * std::min(ri, rj);
    const Vec3 n = draw.direction();
    const Body i = make_body({{ri, ri, ri}, 2, 2}, ri, {1, 2, 3}, draw.turn());
    const Body j = make_body({{rj, rj, rj}, 2, 2}, rj, Vec3{1, 2, 3} + (ri + rj - overlap) * n, draw.turn());
    PairMemory memory;
    const PairContact c = solve_pair(i, j, memory, count);
    EXPECT_NEAR(c.overlap, overlap, 1e-12);
    EXPECT_LT(norm(c.normal - n), 1e-12);
    EXPECT_LT(norm(c.point - (i.centre + (ri - 0.5 * overlap) * n)), 1e-12);
  }
  EXPECT_EQ(count.from_memory + count.along_path, count.pairs);
}

/// Ellipsoids in long double, without support functions of the code: the stationary n satisfies
/// (A / h_A + B / h_B - overlap) n = d with A = R diag(a^2) R^T, h_A = sqrt(n A n). Newton's method on n, whose
/// derivative is taken by differences of a step that long doubles resolve.
struct Reference {
  long double a[3][3], b[3][3], d[3];
  using V = std::array<long double, 3>;
  static V times(const long double (&m)[3][3], const V& n) {
    V r{};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) r[i] += m[i][k] * n[k];
    return r;
  }
  static long double inner(const V& x, const V& y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; }
  long double value(const V& n) const {
    return std::sqrt(inner(n, times(a, n))) + std::sqrt(inner(n, times(b, n))) -
           (n[0] * d[0] + n[1] * d[1] + n[2] * d[2]);
  }
  V gradient(const V& n) const {
    const V an = times(a, n), bn = times(b, n);
    const long double ha = std::sqrt(inner(n, an)), hb = std::sqrt(inner(n, bn));
    V g{};
    for (int k = 0; k < 3; ++k) g[k] = an[k] / ha + bn[k] / hb - d[k];
    return g;
  }
  static V unit(V v) {
    const long double s = std::sqrt(inner(v, v));
    for (auto& x : v) x /= s;
    return v;
  }
  /// Best of many directions, then descent with a step that halves until it is lost in rounding.
  V minimum(Draw& draw) const {
    V best{0, 0, 1};
    long double low = value(best);
    for (int k = 0; k < 3000; ++k) {
      const Vec3 u = draw.direction();
      const V n{u.x, u.y, u.z};
      if (value(n) < low) low = value(n), best = n;
    }
    for (int round = 0; round < 200; ++round) {
      const V g = gradient(best);
      V u = unit(std::fabs(best[0]) < 0.6L ? V{0, best[2], -best[1]} : V{-best[2], 0, best[0]});
      V v{best[1] * u[2] - best[2] * u[1], best[2] * u[0] - best[0] * u[2], best[0] * u[1] - best[1] * u[0]};
      const long double e = 1e-7L;
      long double h[2][2];
      const V* axis[2] = {&u, &v};
      for (int p = 0; p < 2; ++p) {
        V up = best, down = best;
        for (int k = 0; k < 3; ++k) up[k] += e * (*axis[p])[k], down[k] -= e * (*axis[p])[k];
        const V gu = gradient(unit(up)), gd = gradient(unit(down));
        for (int q = 0; q < 2; ++q)
          h[p][q] = (inner(gu, *axis[q]) - inner(gd, *axis[q])) / (2 * e) - (p == q ? inner(g, best) : 0);
      }
      const long double g1 = inner(g, u), g2 = inner(g, v), det = h[0][0] * h[1][1] - h[0][1] * h[1][0];
      long double t1 = -g1, t2 = -g2;
      if (det > 0 && h[0][0] > 0) t1 = (h[0][1] * g2 - h[1][1] * g1) / det, t2 = (h[0][1] * g1 - h[0][0] * g2) / det;
      long double share = 1;
      V next = best;
      for (int half = 0; half < 60; ++half, share /= 2) {
        for (int k = 0; k < 3; ++k) next[k] = best[k] + share * (t1 * u[k] + t2 * v[k]);
        next = unit(next);
        if (value(next) <= value(best)) break;
      }
      const long double way = std::fabs(share) * std::sqrt(t1 * t1 + t2 * t2);
      best = next;
      if (way < 1e-13L) break;  // the next error is its square
    }
    return best;
  }
};

void fill(long double (&m)[3][3], const Superquadric& s, const Rotation& r) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      m[i][k] = 0;
      for (int e = 0; e < 3; ++e)
        m[i][k] += static_cast<long double>(r.row[i][e]) * s.axes[e] * s.axes[e] * r.row[k][e];
    }
}

double least_radius(const Superquadric& ellipsoid) {
  const double c = testing::least_axis(ellipsoid);
  return c * c / std::max({ellipsoid.axes.x, ellipsoid.axes.y, ellipsoid.axes.z});
}

TEST(PairContact, EllipsoidsAgreeWithAnIndependentSolver) {
  Draw draw(12);
  double worst_overlap = 0, worst_normal = 0;
  for (int k = 0; k < 1000; ++k) {
    const Superquadric si = draw.shape(2, 2, 10), sj = draw.shape(2, 2, 10);
    const Quaternion qi = draw.turn(), qj = draw.turn();
    Body i = make_body(si, least_radius(si), {}, qi), j = make_body(sj, least_radius(sj), {}, qj);
    const Vec3 n = draw.direction();
    const double overlap = draw.uniform(0, 0.01) * std::min(testing::least_axis(si), testing::least_axis(sj));
    const Vec3 xi = to_space(i.turn, support_point(si, to_body(i.turn, n)).point);
    const Vec3 xj = to_space(j.turn, support_point(sj, to_body(j.turn, -n)).point);
    j.centre = (xi - xj) - (overlap + draw.uniform(-1e-3, 1e-3)) * n + 0.01 * draw.uniform() * draw.direction();
    PairMemory memory;
    PairCount count;
    const PairContact c = solve_pair(i, j, memory, count, 10);  // also pairs that are apart
    Reference r;
    fill(r.a, si, i.turn);
    fill(r.b, sj, j.turn);
    for (int e = 0; e < 3; ++e) r.d[e] = j.centre[e];
    const auto m = r.minimum(draw);
    worst_overlap = std::max(worst_overlap, std::fabs(static_cast<double>(r.value(m)) - c.overlap));
    worst_normal = std::max(worst_normal, norm(c.normal - Vec3{double(m[0]), double(m[1]), double(m[2])}));
  }
  std::printf("ellipsoids, 1000 pairs: overlap within %.1e R, normal within %.1e\n", worst_overlap, worst_normal);
  EXPECT_LT(worst_overlap, 1e-9);
  EXPECT_LT(worst_normal, 1e-8);
}

/// No direction near the normal, at any scale, has a smaller overlap.
double gain_nearby(const Body& i, const Body& j, const PairContact& c, Draw& draw) {
  const PairForm<Plain> p = pair_form(i, j);
  double gain = 0;
  for (const double scale : {1e-9, 1e-7, 1e-5, 1e-3, 1e-2}) {
    const Vec3 n = c.normal + scale * draw.direction(), m = to_body(i.turn, (1 / norm(n)) * n);
    gain = std::max(gain, c.overlap - evaluate<Plain>(p, {m.x, m.y, m.z}, k_eta).delta);
  }
  return gain / p.size;
}

TEST(PairContact, RandomPairsUpToExponent20AndAspect10AreAllSolved) {
  Draw draw(13);
  PairCount count;
  const int n = full() ? 1000000 : 20000;
  double worst = 0, worst_gain = 0, worst_point = 0;
  for (int k = 0; k < n; ++k) {
    const double least = k % 8 < 4 ? 2 : 20;
    const KnownContact c = known_contact(draw, k % 4, least, 20, 10, 1e-3);
    PairMemory memory;
    const PairContact r = solve_pair(c.i, c.j, memory, count);
    worst = std::max(worst, std::fabs(r.overlap - c.overlap));
    worst_gain = std::max(worst_gain, gain_nearby(c.i, c.j, r, draw));
    const Vec3 on_i = to_body(c.i.turn, r.point + (0.5 * r.overlap) * r.normal);
    const Vec3 on_j = to_body(c.j.turn, (r.point - (0.5 * r.overlap) * r.normal) - c.j.centre);
    worst_point =
        std::max({worst_point, std::fabs(testing::gauge(c.si, on_i) - 1), std::fabs(testing::gauge(c.sj, on_j) - 1)});
  }
  std::printf(
      "%d pairs: overlap within %.1e, points within %.1e; along the path %ld, with care %ld, searched %ld, bracketed "
      "%ld; "
      "evaluations %.1f on average, at most %ld\n",
      n, worst, worst_point, long(count.along_path), long(count.with_care), long(count.searched), long(count.bracketed),
      double(count.evaluations) / n, long(count.most_evaluations));
  EXPECT_LT(worst, 1e-9);
  EXPECT_LT(worst_gain, 1e-12);
  EXPECT_LT(worst_point, 1e-6);
  EXPECT_EQ(count.along_path + count.with_care + count.searched, n);
  EXPECT_LT(count.with_care + count.searched, n / 100);
}

TEST(PairContact, TheMemoryOfTheLastStepGivesTheSameContactForLess) {
  Draw draw(14);
  PairCount cold, warm;
  for (int k = 0; k < 1000; ++k) {
    KnownContact c = known_contact(draw, k % 4, 2, 20, 10, 1e-3);
    PairMemory memory;
    PairCount first;
    solve_pair(c.i, c.j, memory, first);
    const Quaternion q =
        normalised({1, draw.uniform(-1e-4, 1e-4), draw.uniform(-1e-4, 1e-4), draw.uniform(-1e-4, 1e-4)});
    const Rotation small = rotation(q), old = c.j.turn;
    for (int a = 0; a < 3; ++a) {
      const Vec3 axis = to_space(small, {old.row[0][a], old.row[1][a], old.row[2][a]});
      for (int b = 0; b < 3; ++b) c.j.turn.row[b][a] = axis[b];
    }
    c.j.centre = c.j.centre + 1e-4 * draw.direction();
    PairMemory none;
    const PairContact w = solve_pair(c.i, c.j, memory, warm, 1), s = solve_pair(c.i, c.j, none, cold, 1);
    EXPECT_NEAR(w.overlap, s.overlap, 1e-12);
    EXPECT_LT(norm(w.normal - s.normal), 1e-7);
  }
  EXPECT_GT(warm.from_memory, 970);
  EXPECT_LT(warm.evaluations, 0.7 * static_cast<double>(cold.evaluations));
}

TEST(PairContact, DeepOverlapsAreTheLeastOverAllDirections) {
  Draw draw(15);
  PairCount count;
  int deep = 0;
  for (int k = 0; k < 60; ++k) {
    const Superquadric si = draw.shape(2, 20, 4), sj = draw.shape(2, 20, 4);
    const Body i = make_body(si, smallest_radius(si), {}, draw.turn());
    const Body j = make_body(sj, smallest_radius(sj), 0.3 * draw.direction(), draw.turn());
    PairMemory memory;
    const PairContact c = solve_pair(i, j, memory, count);
    deep += c.deep;
    const PairForm<Plain> p = pair_form(i, j);
    double least = 1e300;
    for (int t = 0; t < 2000; ++t) {
      const Vec3 n = draw.direction();
      least = std::min(least, evaluate<Plain>(p, {n.x, n.y, n.z}, k_eta).delta);
    }
    EXPECT_LE(c.overlap, least + 1e-12) << k;
  }
  EXPECT_GT(deep, 30);
  EXPECT_EQ(count.deep, deep);
  EXPECT_EQ(count.bracketed, 0);
}

TEST(PairContact, ConcentricBodiesHaveAnAnswer) {
  for (const double n : {2.0, 20.0}) {
    const Superquadric s{{1, 0.5, 0.25}, n, n};
    const Body b = make_body(s, smallest_radius(s), {}, {});
    PairMemory memory;
    PairCount count;
    const PairContact c = solve_pair(b, b, memory, count);
    EXPECT_NEAR(c.overlap, 0.5, 1e-8) << n;
    EXPECT_NEAR(std::fabs(c.normal.z), 1, 1e-6);
  }
}

TEST(PairContact, ForceHasNoJumpWhenABodySlidesOverAnEdge) {
  const Superquadric cube{{1, 1, 1}, 20, 20}, ball{{0.3, 0.3, 0.3}, 2, 2}, small{{0.3, 0.2, 0.25}, 20, 20};
  for (const Superquadric& other : {ball, small}) {
    const Body i = make_body(cube, smallest_radius(cube), {}, {});
    Body j = make_body(other, smallest_radius(other), {}, normalised({0.9, 0.1, 0.3, 0.2}));
    const double room = smallest_radius(cube) / 0.9 + smallest_radius(other) / 0.9, depth = 0.01, step = 1e-4;
    // Over the upper face towards and beyond the edge, sinking as the face ends, with the memory of the last place.
    PairMemory memory;
    PairCount count;
    const double top = 1 + support_point(other, to_body(j.turn, {0, 0, -1})).h - depth;
    Vec3 last{};
    double steepest = 0;
    int touching = 0;
    for (int k = 0; k < 4000; ++k) {
      const double x = 0.9 + step * k;
      j.centre = {x, 0.2, x < 1.05 ? top : top - 1.5 * (x - 1.05)};
      const PairContact c = solve_pair(i, j, memory, count);
      const Vec3 force = fmax2(c.overlap, 0) * c.normal;
      touching += c.overlap > 0;
      ASSERT_LT(c.overlap, 0.9 * room) << "the path leaves what has one minimum";
      // d(overlap n) <= (1 + overlap / (radius - overlap)) d(centre)
      const double way = k == 0 ? 0 : norm(force - last), moved = 1.81 * step;
      last = force;
      steepest = std::max(steepest, way / moved);
      if (k == 0) continue;
      ASSERT_LT(way, (1 + 2 * fmax2(c.overlap, 0) / (room - fmax2(c.overlap, 0))) * moved + 1e-9) << "at " << x;
    }
    EXPECT_GT(touching, 100);
    EXPECT_GT(steepest, 0.1);
  }
}

}  // namespace
}  // namespace talus::shapes
