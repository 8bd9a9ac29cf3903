// The narrow phase against a loop over all candidates, on every instruction set: which pairs touch, and where each
// finds its history.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/rng.hpp"
#include "kernels/kernel_table.hpp"

namespace talus {
namespace {

struct NarrowResult {
  std::vector<std::int32_t> ci, cj;
  std::vector<std::uint8_t> mask;
  std::vector<double> h[k_max_history];
  std::int64_t end[3];
};

NarrowResult run_narrow(const KernelTable& k, const Column<double>& p, const Column<std::int32_t>& pi,
                        const Column<std::int32_t>& pj, std::vector<std::uint8_t> mask, const std::vector<double>* old,
                        const std::int64_t* end, bool periodic, int columns) {
  const std::size_t n = pi.size() + 2 * k_pad;
  NarrowArgs a{};
  a.p = p.data();
  a.pi = pi.data();
  a.pj = pj.data();
  a.mask = mask.data();
  for (int q = 0; q < 3; ++q) {
    a.end[q] = end[q];
    a.half[q] = periodic ? 2.5 : 1e300;
    a.period[q] = periodic ? 5 : 0;
  }
  a.periodic = periodic ? 1 : 0;
  Column<HistoryRun> runs(n);
  if (columns > 0) a.runs = runs.data();
  Column<std::int32_t> ci(n), cj(n);
  a.ci = ci.data();
  a.cj = cj.data();
  k.narrow(a);
  NarrowResult r;
  const auto m = static_cast<std::size_t>(a.contact_end[2]), m_new = static_cast<std::size_t>(-1);
  r.ci.assign(ci.begin(), ci.begin() + static_cast<std::ptrdiff_t>(m));
  r.cj.assign(cj.begin(), cj.begin() + static_cast<std::ptrdiff_t>(m));
  r.mask = mask;
  for (std::size_t n = 0, run = 0; n < m; ++n) {
    while (run < static_cast<std::size_t>(a.run_count) && runs[run].to <= static_cast<std::int32_t>(n)) ++run;
    std::size_t from = n;
    if (run > 0)
      from = runs[run - 1].from < 0 ? m_new : n - static_cast<std::size_t>(runs[run - 1].to - runs[run - 1].from);
    for (int q = 0; q < columns; ++q) r.h[q].push_back(from == m_new ? 0.0 : old[q].at(from));
  }
  for (int q = 0; q < 3; ++q) r.end[q] = a.contact_end[q];
  return r;
}

TEST(Narrow, CarriesTheHistoryOfTouchingPairsAndStartsNewOnesAtZero) {
  const CounterRng rng(3, 2, 0);
  std::uint64_t c = 0;
  for (const int columns : {0, 1, 3, 4, 5, 8})
    for (const bool periodic : {false, true}) {
      const int rows = 60;
      Column<double> p(4 * (rows + 16));
      for (int k = 0; k < rows + 16; ++k) {
        for (int q = 0; q < 3; ++q) p[4 * k + q] = k < rows ? 5 * rng.uniform(c++) : 1e150;
        p[4 * k + 3] = k < rows ? 0.3 + 0.3 * rng.uniform(c++) : 0;
      }
      Column<std::int32_t> pi, pj;
      std::int64_t end[3];
      for (int s = 0; s < 3; ++s) {
        const int n = 400 + 37 * s;
        for (int k = 0; k < n; ++k) {
          const auto i = static_cast<std::int32_t>(rng.uniform(c++) * rows);
          auto j = static_cast<std::int32_t>(rng.uniform(c++) * rows);
          pi.push_back(i);
          pj.push_back(i == j ? (j + 1) % rows : j);
        }
        while (pi.size() % 8 != 0) {
          pi.push_back(rows);
          pj.push_back(rows);
        }
        end[s] = static_cast<std::int64_t>(pi.size());
      }
      std::vector<std::uint8_t> mask(pi.size() / 8 + 16, 0);
      std::vector<double> old[k_max_history];
      for (std::size_t s = 0; s < pi.size(); ++s)
        if (pi[s] < rows && rng.uniform(c++) < 0.5) {
          mask[s / 8] |= static_cast<std::uint8_t>(1U << (s % 8));
          for (auto& h : old) h.push_back(rng.uniform(c++));
        }
      const NarrowResult r = run_narrow(select_kernels(Isa::scalar), p, pi, pj, mask, old, end, periodic, columns);
      std::size_t n = 0, was = 0;
      for (std::size_t s = 0; s < pi.size(); ++s) {
        double d2 = 0;
        for (int q = 0; q < 3; ++q) {
          double d = p[4 * pi[s] + q] - p[4 * pj[s] + q];
          if (periodic) d -= 5 * std::nearbyint(d / 5);
          d2 += d * d;
        }
        const double reach = p[4 * pi[s] + 3] + p[4 * pj[s] + 3];
        const bool touched = (mask[s / 8] >> (s % 8) & 1) != 0, touches = pi[s] < rows && d2 < reach * reach;
        ASSERT_EQ((r.mask[s / 8] >> (s % 8) & 1) != 0, touches);
        if (touches) {
          ASSERT_EQ(r.ci[n], pi[s]);
          ASSERT_EQ(r.cj[n], pj[s]);
          for (int q = 0; q < columns; ++q) ASSERT_EQ(r.h[q][n], touched ? old[q][was] : 0.0);
          ++n;
        }
        was += touched ? 1 : 0;
      }
      EXPECT_EQ(n, r.ci.size());
      EXPECT_GT(n, 15U);
      for (const Isa isa : available_isas()) {
        const NarrowResult t = run_narrow(select_kernels(isa), p, pi, pj, mask, old, end, periodic, columns);
        EXPECT_EQ(t.ci, r.ci) << isa_name(isa);
        EXPECT_EQ(t.cj, r.cj) << isa_name(isa);
        EXPECT_EQ(t.mask, r.mask) << isa_name(isa);
        for (int q = 0; q < columns; ++q) EXPECT_EQ(t.h[q], r.h[q]) << isa_name(isa);
        for (int q = 0; q < 3; ++q) EXPECT_EQ(t.end[q], r.end[q]) << isa_name(isa);
      }
    }
}

}  // namespace
}  // namespace talus
