// Rolling, twisting, JKR, SJKR and the adhesive narrow phase against the scalar oracle, and all instruction sets
// against each other bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/base/rng.hpp"
#include "kernels/kernel_table.hpp"
#include "kernels/reference.hpp"

namespace talus {
namespace {

constexpr int k_size = k_block + k_pad;
constexpr double k_pi = 3.14159265358979323846;

/// n touching pairs with spins, stiffness and pressing force as a law would have left them, and histories.
struct Contacts {
  int n;
  std::vector<reference::Pair> pairs;
  Column<double> p, v;
  Column<std::int32_t> i, j;
  alignas(64) double x[4][k_size] = {}, r[8][k_size] = {}, reff[k_size], slid[k_size], h[k_max_moment][k_size] = {};

  Contacts(int count, std::uint64_t seed, double relative_overlap = 0.01) : n(count) {
    const CounterRng rng(seed, 1, 0);
    std::uint64_t c = 0;
    const auto u = [&] { return 2 * rng.uniform(c++) - 1; };
    p.assign(4 * static_cast<std::size_t>(2 * n + 16), 0.0);
    v.assign(8 * static_cast<std::size_t>(2 * n + 16), 0.0);
    for (int k = 0; k < k_size; ++k) {
      reff[k] = 1;
      slid[k] = 1e-3 * (k % 5 == 4 ? 0.5 + 0.4 * std::sin(k) : k % 11 == 3 ? 0 : 1);  // touched, at the start, usual
      x[0][k] = x[3][k] = 1;
      r[7][k] = 1;
    }
    for (int k = 0; k < n; ++k) {
      reference::Pair t;
      t.ri = 0.5 + 0.25 * u();
      t.rj = 0.5 + 0.25 * u();
      Vec3 dir{u(), u(), u()};
      dir = (1 / norm(dir)) * dir;
      t.xj = {u(), u(), u()};
      t.xi = t.xj + (t.ri + t.rj - relative_overlap * (k % 4 == 0 ? 1e-3 : 0.5 + 0.4 * u())) * dir;
      t.wi = {u(), u(), u()};
      t.wj = k % 6 == 0 ? t.wi : Vec3{u(), u(), u()};
      t.mi = 1 + 0.5 * u();
      t.mj = k % 7 == 0 ? INFINITY : 1 + 0.5 * u();
      const auto row = static_cast<std::size_t>(2 * k);
      const auto put = [&](std::size_t at, Vec3 centre, double radius, Vec3 spin, double m) {
        for (int q = 0; q < 3; ++q) {
          p[4 * at + static_cast<std::size_t>(q)] = centre[q];
          v[8 * at + 4 + static_cast<std::size_t>(q)] = radius * spin[q];
        }
        p[4 * at + 3] = radius;
        v[8 * at + 7] = 1 / m;
      };
      put(row, t.xi, t.ri, t.wi, t.mi);
      put(row + 1, t.xj, t.rj, t.wj, t.mj);
      const Vec3 d = t.xi - t.xj;
      for (int q = 0; q < 3; ++q) x[q][k] = d[q];
      x[3][k] = t.ri + t.rj;
      reff[k] = t.ri * t.rj / (t.ri + t.rj);
      r[7][k] = std::max(0.0, 2 + 2.5 * u());  // some do not press at all
      r[3][k] = 100 * (1 + 0.5 * u());
      const double size = 0.05;
      for (int q = 0; q < 3; ++q) h[q][k] = size * u();
      h[3][k] = size * u();
      h[4][k] = k % 3 == 0 ? 0 : 100 * (1 + 0.5 * u());
      pairs.push_back(t);
      i.push_back(2 * k);
      j.push_back(2 * k + 1);
    }
    for (int k = 0; k < k_pad; ++k) {
      i.push_back(2 * n);
      j.push_back(2 * n);
    }
  }
};

struct MomentResult {
  std::vector<double> m[3], h[k_max_moment], e[3];
};

MomentArgs moment_arguments(int variant) {
  MomentArgs a{};
  a.one = {0.3, 0.2, 0.1, 0.25, 0};
  a.dt = 1e-3;
  a.rolling = variant % 3;
  a.twisting = variant / 3 % 2;
  a.rescale = a.rolling != 1 && variant / 6 % 2 != 0 ? 1 : 0;
  a.centred = variant / 12 % 2;
  return a;
}

/// Columns as the law lays them out: rolling 3, twisting 1, stiffness 1, each only where it is used.
std::vector<int> columns_of(const MomentArgs& a) {
  std::vector<int> c;
  if (a.rolling == 2) c = {0, 1, 2};
  if (a.twisting != 0) c.push_back(3);
  if (a.rescale != 0) c.push_back(4);
  return c;
}

MomentResult run_moments(const KernelTable& k, Contacts& c, const MomentArgs& args, bool energy, bool multi,
                         bool swap = false) {
  alignas(64) static double s[4][k_size], e[3][k_size], h[k_max_moment][k_size], x[3][k_size], r[8][k_size];
  alignas(64) static std::int32_t pair[k_size];
  std::memset(pair, 0, sizeof pair);
  std::memset(e, 0, sizeof e);
  std::memcpy(r, c.r, sizeof r);
  const double sign = swap ? -1 : 1;
  for (int q = 0; q < 3; ++q)
    for (int t = 0; t < k_size; ++t) {
      x[q][t] = sign * c.x[q][t];
    }
  k.spin({c.p.data(), c.v.data(), (swap ? c.j : c.i).data(), (swap ? c.i : c.j).data(), c.n, s});
  MomentArgs a = args;
  a.table = multi ? &a.one : nullptr;
  MomentBlock b{};
  b.n = c.n;
  b.x = x[0];
  b.y = x[1];
  b.z = x[2];
  b.r = r;
  b.reff = c.reff;
  b.slid = c.slid;
  b.pair = pair;
  b.s = s;
  b.e = energy ? e : nullptr;
  const std::vector<int> columns = columns_of(a);
  for (std::size_t q = 0; q < columns.size(); ++q) {
    std::memcpy(h[q], c.h[columns[q]], sizeof h[q]);
    if (swap && columns[q] < 3)
      for (double& t : h[q]) t = -t;
    b.h[q] = h[q];
  }
  k.moments(b, a);
  MomentResult o;
  for (int q = 0; q < 3; ++q) o.m[q].assign(s[q], s[q] + c.n);
  for (std::size_t q = 0; q < columns.size(); ++q) o.h[columns[q]].assign(h[q], h[q] + c.n);
  if (energy)
    for (int q = 0; q < 3; ++q) o.e[q].assign(e[q], e[q] + c.n);
  return o;
}

TEST(Moments, AgreeWithTheScalarOracle) {
  int slid = 0, stuck = 0;
  for (int variant = 0; variant < 24; ++variant) {
    Contacts c(125, 40 + static_cast<std::uint64_t>(variant));
    const MomentArgs a = moment_arguments(variant);
    const MomentResult o = run_moments(select_kernels(Isa::scalar), c, a, false, false);
    for (int k = 0; k < c.n; ++k) {
      const auto s = static_cast<std::size_t>(k);
      reference::MomentHistory h{{c.h[0][k], c.h[1][k], c.h[2][k]}, c.h[3][k], c.h[4][k]};
      const Vec3 m = reference::moments(c.pairs[s], c.r[7][k], c.r[3][k], c.slid[k], a.one, a, h);
      for (int q = 0; q < 3; ++q) {
        ASSERT_NEAR(o.m[q][s], m[q], 1e-13) << "variant " << variant << " pair " << k;
        if (a.rolling == 2) {
          ASSERT_NEAR(o.h[q][s], h.rolling[q], 1e-13);
        }
      }
      if (a.twisting != 0) {
        ASSERT_NEAR(o.h[3][s], h.twisting, 1e-13);
      }
      if (a.rescale != 0) {
        ASSERT_EQ(o.h[4][s], c.r[3][k]);
      }
      if (a.rolling == 2) {
        const double limit = a.one.rolling * c.reff[k];
        (norm(h.rolling) < 0.999 * limit * c.r[7][k] ? stuck : slid) += 1;
      }
    }
  }
  EXPECT_GT(slid, 50);
  EXPECT_GT(stuck, 50);
}

TEST(Moments, SameBitsOnEveryInstructionSetAndOppositeForSwappedPartners) {
  for (int variant = 0; variant < 24; ++variant)
    for (const int n : {1, 3, 8, 61, 128})
      for (const bool multi : {false, true}) {
        Contacts c(n, 90 + static_cast<std::uint64_t>(variant));
        const MomentArgs a = moment_arguments(variant);
        const MomentResult o = run_moments(select_kernels(Isa::scalar), c, a, true, multi);
        for (const Isa isa : available_isas()) {
          const MomentResult t = run_moments(select_kernels(isa), c, a, true, multi);
          for (int q = 0; q < 3; ++q) {
            ASSERT_EQ(std::memcmp(o.m[q].data(), t.m[q].data(), 8 * o.m[q].size()), 0) << isa_name(isa);
            ASSERT_EQ(std::memcmp(o.e[q].data(), t.e[q].data(), 8 * o.e[q].size()), 0) << isa_name(isa);
          }
          for (const int q : columns_of(a))
            ASSERT_EQ(std::memcmp(o.h[q].data(), t.h[q].data(), 8 * o.h[q].size()), 0) << isa_name(isa);
        }
        const MomentResult s = run_moments(select_kernels(Isa::automatic), c, a, true, multi, true);
        for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
          for (int q = 0; q < 3; ++q) {
            ASSERT_EQ(o.m[q][k], -s.m[q][k]);
            ASSERT_EQ(o.e[q][k], s.e[q][k]);
            if (a.rolling == 2) {
              ASSERT_EQ(o.h[q][k], -s.h[q][k]);
            }
          }
          if (a.twisting != 0) {
            ASSERT_EQ(o.h[3][k], s.h[3][k]) << "the same about either normal";
          }
        }
      }
}

/// Frictionless JKR at n overlaps of a pair with R* and E*, without dashpot; returns force [0], stiffness [1].
std::vector<double> run_jkr(const KernelTable& k, const std::vector<double>& delta, double radius, double e_star,
                            double w, std::vector<double>& stiffness) {
  alignas(64) static double x[4][k_size], g[4][k_size], r[8][k_size], e[3][k_size], reff[k_size];
  std::memset(r, 0, sizeof r);
  Block b{};
  b.n = static_cast<int>(delta.size());
  for (int q = 0; q < k_size; ++q) {
    x[0][q] = 2 * radius - (q < b.n ? delta[static_cast<std::size_t>(q)] : 0);
    x[1][q] = x[2][q] = 0;
    x[3][q] = 2 * radius;
    r[3][q] = 1;
    reff[q] = 0.5 * radius;
  }
  b.x = x[0];
  b.y = x[1];
  b.z = x[2];
  b.w = x[3];
  b.r = r;
  b.reff = reff;
  b.e = e;
  b.g = g;
  k.geometry(GeometryArgs{b.n, x[0], x[1], x[2], x[3], r[3], g});
  LawArgs a{};
  a.one.kn = 4.0 / 3.0 * e_star;
  a.one.w = w;
  a.dt = 1e-6;
  k.law[law_index(law_info(ContactModel::jkr), false, false, false)](b, a);
  stiffness.assign(r[3], r[3] + b.n);
  return {r[0], r[0] + b.n};
}

TEST(Jkr, AgreesWithBisectionOfThePapersEquationsFromPullOffToDeepOverlap) {
  for (const double w : {1e-3, 0.1, 5.0})
    for (const double radius : {1e-6, 1e-3, 1.0}) {
      const double e_star = 1e7, reff = 0.5 * radius;
      const double kappa = k_pi * w / (8 * e_star), unit = std::cbrt(kappa * kappa * reff);
      std::vector<double> delta, stiffness;
      for (int k = 0; k < 120; ++k) delta.push_back(unit * (-3 + 1e-6 * std::pow(1.25, k)));
      std::vector<double> inside;
      for (const double d : delta)
        if (d < 0.5 * reff) inside.push_back(d);
      const auto force = run_jkr(select_kernels(Isa::scalar), inside, radius, e_star, w, stiffness);
      for (std::size_t k = 0; k < inside.size(); ++k) {
        // the kernel forms delta from the distance: rounding of 2 r against the scale of the curve
        const double exact = 2 * radius - (2 * radius - inside[k]);
        const reference::JkrState s = reference::jkr(exact, reff, e_star, w);
        const double noise = 4e-16 * radius / unit;
        const double tolerance = (1e-12 + 20 * std::sqrt(noise)) * (k_pi * w * reff + std::fabs(s.force));
        ASSERT_NEAR(force[k], s.force, tolerance) << "w " << w << " r " << radius << " delta/unit " << inside[k] / unit;
        ASSERT_NEAR(stiffness[k] / (2 * e_star * s.radius), 1, 1e-10 + 20 * std::sqrt(noise));
      }
      for (const Isa isa : available_isas()) {
        std::vector<double> other;
        const auto t = run_jkr(select_kernels(isa), inside, radius, e_star, w, other);
        ASSERT_EQ(std::memcmp(t.data(), force.data(), 8 * t.size()), 0) << isa_name(isa);
        ASSERT_EQ(std::memcmp(other.data(), stiffness.data(), 8 * t.size()), 0) << isa_name(isa);
      }
    }
}

TEST(Jkr, WithoutAdhesionIsHertz) {
  const std::vector<double> delta = {1e-7, 1e-6, 1e-5};
  std::vector<double> stiffness;
  const auto force = run_jkr(select_kernels(Isa::automatic), delta, 1e-3, 1e7, 0, stiffness);
  for (std::size_t k = 0; k < delta.size(); ++k) {
    const double d = 2e-3 - (2e-3 - delta[k]);
    EXPECT_NEAR(force[k] / (4.0 / 3.0 * 1e7 * std::sqrt(0.5e-3 * d) * d), 1, 1e-6);
  }
}

TEST(Cohesion, PullsInProportionToTheAreaOfIntersectionOnEveryInstructionSet) {
  for (const bool wall : {false, true})
    for (const bool multi : {false, true}) {
      Contacts c(61, 9, 0.05);
      std::vector<double> scalar;
      for (const Isa isa : {Isa::scalar, Isa::sse2, Isa::avx2, Isa::avx512}) {
        const auto all = available_isas();
        if (std::find(all.begin(), all.end(), isa) == all.end()) continue;
        alignas(64) static double r[8][k_size], e[3][k_size], w[k_size];
        alignas(64) static std::int32_t pair[k_size];
        std::memcpy(r, c.r, sizeof r);
        std::memset(e, 0, sizeof e);
        std::memset(pair, 0, sizeof pair);
        for (int k = 0; k < k_size; ++k) {
          const double d = std::sqrt(c.x[0][k] * c.x[0][k] + c.x[1][k] * c.x[1][k] + c.x[2][k] * c.x[2][k]);
          w[k] = wall ? 1.01 * d : c.x[3][k];
        }
        Block b{};
        b.n = c.n;
        b.x = c.x[0];
        b.y = c.x[1];
        b.z = c.x[2];
        b.w = w;
        b.r = r;
        b.e = e;
        b.pair = pair;
        const double density = 3.0;
        CohesionArgs a{density, multi ? &density : nullptr, wall ? nullptr : c.p.data(), c.i.data(), c.j.data(), 1};
        select_kernels(isa).cohesion(b, a);
        std::vector<double> bits;
        for (int k = 0; k < c.n; ++k) {
          const reference::Pair& p = c.pairs[static_cast<std::size_t>(k)];
          const Vec3 d = p.xi - p.xj;
          const double ri = wall ? w[k] : p.ri, expect = reference::sjkr(norm(d), ri, p.rj, wall, density);
          for (int q = 0; q < 3; ++q)
            ASSERT_NEAR(r[q][k] - c.r[q][k], -expect * d[q] / norm(d), 1e-13) << "wall " << wall;
          // energy: minus the work of the attraction from touch, by Simpson's rule
          double work = 0;
          const double touch = wall ? ri : p.ri + p.rj, h = (touch - norm(d)) / 64;
          for (int s = 0; s <= 64; ++s)
            work += (s == 0 || s == 64 ? 1
                     : s % 2 != 0      ? 4
                                       : 2) *
                    h / 3 * reference::sjkr(norm(d) + s * h, ri, p.rj, wall, density);
          ASSERT_NEAR(e[0][k], -work, 1e-13);
          for (int q = 0; q < 3; ++q) bits.push_back(r[q][k]);
          bits.push_back(e[0][k]);
        }
        if (scalar.empty()) scalar = bits;
        ASSERT_EQ(std::memcmp(bits.data(), scalar.data(), 8 * bits.size()), 0) << isa_name(isa);
      }
    }
}

TEST(NarrowAdhesive, HoldsPairsUntilRuptureOnlyIfTheyWereInContact) {
  // four pairs at the same gap, inside and outside the range, attached before or not; one that touches anew
  const double r = 0.5, reff = 0.25, range = 27 * 1e-6 * 1e-6, longest = std::cbrt(range * reff);
  Column<double> p(4 * 32, 0.0);
  Column<std::int32_t> pi, pj;
  const double gaps[] = {0.99 * longest, 0.99 * longest, 1.01 * longest, 1.01 * longest,
                         -1e-3,          -1e-3,          0.5 * longest,  1};
  const unsigned was = 0b01010101;
  for (int k = 0; k < 8; ++k) {
    for (int side = 0; side < 2; ++side) {
      const auto row = static_cast<std::size_t>(4 * (2 * k + side));
      p[row] = 10 * k + (side == 0 ? 0 : 2 * r + gaps[k]);
      p[row + 3] = r;
    }
    pi.push_back(2 * k);
    pj.push_back(2 * k + 1);
  }
  for (const Isa isa : available_isas()) {
    std::vector<std::uint8_t> mask(16, 0);
    mask[0] = was;
    const std::vector<std::uint8_t> before = mask;
    Column<std::int32_t> ci(64), cj(64);
    NarrowArgs a{};
    a.p = p.data();
    a.pi = pi.data();
    a.pj = pj.data();
    a.mask = mask.data();
    for (int q = 0; q < 3; ++q) {
      a.end[q] = q == 0 ? 0 : 8;
      a.half[q] = 1e300;
    }
    a.ci = ci.data();
    a.cj = cj.data();
    const KernelTable& t = select_kernels(isa);
    t.narrow_adhesive(a, {nullptr, 1, &range});
    EXPECT_EQ(mask[0], 0b01110001) << isa_name(isa);
    EXPECT_EQ(a.contact_end[0], 0);
    EXPECT_EQ(a.contact_end[2], 4);
    EXPECT_EQ(ci[0], 0);
    EXPECT_EQ(cj[3], 13);
    // history follows: those of slots 0, 2, 4, 6 before; 5 is new
    Column<double> from(32, 0.0), to(32, -1.0);
    for (int q = 0; q < 4; ++q) from[static_cast<std::size_t>(q)] = 1 + q;
    CarryArgs c{before.data(), mask.data(), 8, 1, {from.data()}, {to.data()}};
    t.carry(c);
    const double expect[] = {1, 3, 0, 4};
    for (std::size_t q = 0; q < 4; ++q) EXPECT_EQ(to[q], expect[q]) << isa_name(isa);
  }
}

}  // namespace
}  // namespace talus
