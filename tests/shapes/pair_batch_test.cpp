// Batches of pairs: every instruction set gives the bits of one pair alone.
#include "kernels/bodies/pair_batch.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <vector>

#include "kernels/kernel_table.hpp"
#include "tests/shapes/shape_support.hpp"

namespace talus::shapes {
namespace {
using testing::Draw;
using testing::known_contact;

struct Batch {
  std::int64_t pairs, stride;
  std::vector<double> in, out;
  explicit Batch(std::int64_t n) : pairs(n), stride((n + 7) / 8 * 8), in(PairColumns::k_in * stride, 1.0) {}
  void set(std::int64_t k, const PairForm<Plain>& p, double range, const Triple<Plain>& n, double eta, double care) {
    int column = 0;
    const auto put = [&](double v) { in[column++ * stride + k] = v; };
    for (const DualForm<Plain>& f : {p.i, p.j})
      for (const double v : {f.axes2.x, f.axes2.y, f.axes2.z, f.p1, f.p2}) put(v);
    for (const auto& row : p.turn)
      for (const double v : {row.x, row.y, row.z}) put(v);
    for (const double v : {p.d.x, p.d.y, p.d.z, p.size, range, n.x, n.y, n.z, eta, care}) put(v);
    ASSERT_EQ(column, PairColumns::k_in);
  }
  void solve(const char* isa, int most) {
    out.assign(PairColumns::k_out * stride, 0.0);
    pair_solver(isa)({pairs, stride, in.data(), out.data()}, most);
  }
};

TEST(PairBatch, EveryInstructionSetGivesTheBitsOfOnePairAlone) {
  Draw draw(31);
  const int n = 1003;  // not a whole number of batches
  Batch batch(n);
  std::vector<double> want(PairColumns::k_out * batch.stride, 0.0);
  int solved = 0;
  for (int k = 0; k < n; ++k) {
    const auto c = known_contact(draw, k % 4, 2, k % 3 == 0 ? 2 : 20, 10, 1e-3);
    const PairForm<Plain> p = pair_form(c.i, c.j);
    const Triple<Plain> start = unit<Plain>(p.d);
    batch.set(k, p, 0, start, 1, 1);
    PairState<Plain> s{};
    s.n = start;
    s.eta = s.care = 1;
    iterate<Plain>(p, s, 80);
    solved += s.done;
    int column = 0;
    for (const double v :
         {s.n.x, s.n.y, s.n.z, s.delta, s.xi.x, s.xi.y, s.xi.z, s.residual, s.step, s.steps, s.done ? 1.0 : 0.0})
      want[column++ * batch.stride + k] = v;
  }
  EXPECT_GT(solved, n * 95 / 100);
  for (const Isa isa : available_isas()) {
    batch.solve(isa_name(isa), 80);
    int different = 0;
    for (int column = 0; column < PairColumns::k_out; ++column)
      for (int k = 0; k < n; ++k) {
        const std::int64_t at = column * batch.stride + k;
        different += std::bit_cast<std::uint64_t>(batch.out[at]) != std::bit_cast<std::uint64_t>(want[at]);
      }
    EXPECT_EQ(different, 0) << isa_name(isa);
  }
}

// A gap along any direction is proof: the overlap is the least over all of them.
TEST(PairGaps, AreNeverBelowTheOverlapAndHaveTheBitsOfAnEvaluation) {
  Draw draw(32);
  const int n = 403;
  const std::int64_t stride = (n + 7) / 8 * 8;
  std::vector<double> in(GapColumns::k_in * stride, 1.0), out(stride), want(n);
  int apart = 0;
  for (int k = 0; k < n; ++k) {
    auto c = known_contact(draw, k % 4, 2, k % 3 == 0 ? 2 : 20, 10, 1e-3);
    c.j.centre = c.j.centre + (k % 2 == 0 ? 0 : draw.uniform(0, 0.3)) * c.normal;
    const PairForm<Plain> p = pair_form(c.i, c.j);
    const Vec3 turned = to_body(c.i.turn, c.normal + draw.uniform(0, 0.5) * draw.direction());
    const Triple<Plain> along = unit<Plain>({turned.x, turned.y, turned.z}), m = to_j<Plain>(p, along);
    want[k] = evaluate<Plain>(p, along, k_eta).delta;
    int column = 0;
    const auto put = [&](double v) { in[column++ * stride + k] = v; };
    for (const auto& [form, direction] : {std::pair{p.i, along}, std::pair{p.j, m}})
      for (const double v :
           {form.axes2.x, form.axes2.y, form.axes2.z, form.p1, form.p2, direction.x, direction.y, direction.z})
        put(v);
    put(dot<Plain>(along, p.d));
    ASSERT_EQ(column, GapColumns::k_in);
    PairMemory memory;
    PairCount count;
    const double overlap = solve_pair(c.i, c.j, memory, count, 10).overlap;
    EXPECT_GE(want[k], overlap - 1e-12 * p.size);
    apart += want[k] < 0;
    if (k % 2 == 0) {  // they touch
      EXPECT_GT(want[k], 0);
    }
  }
  EXPECT_GT(apart, n / 10);
  for (const Isa isa : available_isas()) {
    pair_gaps(isa_name(isa))({n, stride, in.data(), out.data()});
    int different = 0;
    for (int k = 0; k < n; ++k)
      different += std::bit_cast<std::uint64_t>(out[k]) != std::bit_cast<std::uint64_t>(want[k]);
    EXPECT_EQ(different, 0) << isa_name(isa);
  }
}

TEST(PairBatch, UnknownInstructionSetsHaveNoSolver) {
  EXPECT_EQ(pair_solver("neon"), nullptr);
  EXPECT_EQ(pair_gaps("neon"), nullptr);
}

}  // namespace
}  // namespace talus::shapes
