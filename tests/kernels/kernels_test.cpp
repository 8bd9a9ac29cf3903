// Laws and scatter against the scalar oracle, and all instruction sets against each other bit for bit, on random
// batches that cover block tails, sliding and sticking, first and last touching steps.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/rng.hpp"
#include "kernels/kernel_table.hpp"
#include "kernels/reference.hpp"

namespace talus {
namespace {

struct Batch {
  Column<double> p, v;
  std::vector<reference::Pair> pairs;
  Column<std::int32_t> i, j;
  std::vector<Vec3> history, second;
  std::vector<double> radius, predicted;
};

ContactLaw contact_law(ContactModel model, bool partial_slip = false) {
  ContactLaw l;
  l.model = model;
  l.partial_slip = partial_slip;
  return l;
}
const ContactLaw k_laws[] = {contact_law(ContactModel::linear), contact_law(ContactModel::hertz_mindlin),
                             contact_law(ContactModel::hertz_mindlin, true)};

/// n touching pairs of random spheres: rows 2k and 2k + 1.
Batch make_batch(int n, bool rotation, std::uint64_t seed) {
  const CounterRng rng(seed, 1, 0);
  std::uint64_t c = 0;
  const auto u = [&] { return 2 * rng.uniform(c++) - 1; };
  Batch b;
  const int stride = rotation ? 8 : 4;
  b.p.resize(4 * (2 * n + 16));
  b.v.resize(stride * (2 * n + 16));
  std::fill(b.p.begin(), b.p.end(), 0.0);
  std::fill(b.v.begin(), b.v.end(), 0.0);
  for (int k = 2 * n; k < 2 * n + 16; ++k) {
    for (int q = 0; q < 3; ++q) b.p[4 * k + q] = 1e150;
    b.v[stride * k + stride - 1] = 1;
  }
  for (int k = 0; k < n; ++k) {
    reference::Pair t;
    t.ri = 0.5 * (1 + 0.5 * u());
    t.rj = 0.5 * (1 + 0.5 * u());
    Vec3 dir{u(), u(), u()};
    dir = (1 / norm(dir)) * dir;
    const double delta = k % 5 == 0 ? 1e-6 * (1.001 + u()) : 1e-2 * (0.5 + 0.49 * u());
    t.xj = {10 * u(), 10 * u(), 10 * u()};
    t.xi = t.xj + (t.ri + t.rj - delta) * dir;
    t.vi = {u(), u(), u()};
    t.vj = {u(), u(), u()};
    if (rotation) {
      t.wi = {u(), u(), u()};
      t.wj = {u(), u(), u()};
    }
    t.mi = 1 + 0.5 * u();
    t.mj = k % 7 == 0 ? INFINITY : 1 + 0.5 * u();
    const auto put = [&](int row, Vec3 x, double r, Vec3 v, Vec3 w, double m) {
      const double x4[4] = {x.x, x.y, x.z, r};
      std::memcpy(b.p.data() + 4 * row, x4, sizeof x4);
      double* q = b.v.data() + stride * row;
      for (int e = 0; e < 3; ++e) q[e] = v[e];
      if (rotation)
        for (int e = 0; e < 3; ++e) q[4 + e] = r * w[e];
      q[stride - 1] = 1 / m;
    };
    put(2 * k, t.xi, t.ri, t.vi, t.wi, t.mi);
    put(2 * k + 1, t.xj, t.rj, t.vj, t.wj, t.mj);
    // the oracle must see what the rows hold, rounding included
    t.xi = {b.p[8 * k], b.p[8 * k + 1], b.p[8 * k + 2]};
    b.pairs.push_back(t);
    b.i.push_back(2 * k);
    b.j.push_back(2 * k + 1);
    b.history.push_back(1e-3 * Vec3{u(), u(), u()});
    b.second.push_back(1e-3 * Vec3{u(), u(), u()});
    // 0: new to the law, which then looks whether it has touched just now
    b.predicted.push_back(k % 4 == 0 ? 0.0 : u());
    b.radius.push_back(k % 3 == 0 ? 0.0 : 0.1 * (1 + 0.9 * u()));
    if (delta < -1.25e-3 * dot(t.vi - t.vj, dir)) {  // has touched within the step: nothing is stored yet
      b.history.back() = b.second.back() = {};
      b.radius.back() = b.predicted.back() = 0;
    }
  }
  for (int k = 0; k < k_pad; ++k) {
    b.i.push_back(2 * n);
    b.j.push_back(2 * n);
  }
  return b;
}

struct Output {
  std::vector<double> r[8], h[k_max_history], e[3];
};

/// Column of the predicted velocity (LawArgs::recall).
int recall_column(const LawInfo& law, bool friction) { return friction ? law.history : 0; }

/// A gathered block with its history, ready for a law.
struct ReadyBlock {
  alignas(64) double x[4][k_block + k_pad], geo[4][k_block + k_pad],
      r[8][k_block + k_pad] = {}, e[3][k_block + k_pad], t[4][k_block + k_pad] = {}, reff[k_block + k_pad];
  alignas(64) std::int32_t pair[k_block + k_pad] = {};
  Column<double> h[k_max_history];
  Block block{};

  ReadyBlock(const KernelTable& k, Batch& b, int n, const LawInfo& law, bool friction) {
    std::fill(reff, reff + k_block + k_pad, 1.0);
    GatherArgs g{};
    g.v = b.v.data();
    g.p = b.p.data();
    g.i = b.i.data();
    g.j = b.j.data();
    g.n = n;
    g.x = x;
    g.r = r;
    g.g = geo;
    g.reff = law.wants_reff ? reff : nullptr;
    k.gather[friction ? 1 : 0](g);
    block.n = n;
    block.x = x[0];
    block.y = x[1];
    block.z = x[2];
    block.w = x[3];
    block.g = geo;
    block.r = r;
    for (int q = 0; q < k_max_history; ++q) {
      h[q].assign(static_cast<std::size_t>(n + k_pad), 0.0);
      for (int s = 0; s < n; ++s)
        if (q == recall_column(law, friction))
          h[q][s] = b.predicted[static_cast<std::size_t>(s)];
        else if (q < 3)
          h[q][s] = b.history[static_cast<std::size_t>(s)][q];
        else
          h[q][s] = law.history > 4 && q > 3 ? b.second[static_cast<std::size_t>(s)][std::min(q - 4, 2)]
                                             : b.radius[static_cast<std::size_t>(s)];
      block.h_in[q] = block.h[q] = h[q].data();
    }
    block.reff = reff;
    block.pair = pair;
    block.e = e;
    block.t = t;
  }
  ReadyBlock(const ReadyBlock&) = delete;
};

Output run_law(const KernelTable& k, Batch& b, int n, const LawInfo& law, bool friction, bool multi, bool energy,
               const LawArgs& args) {
  const auto ready = std::make_unique<ReadyBlock>(k, b, n, law, friction);
  k.law[law_index(law, friction, multi, energy)](ready->block, args);
  Output o;
  for (int q = 0; q < 8; ++q) o.r[q].assign(ready->r[q], ready->r[q] + n);
  for (int q = 0; q < k_max_history; ++q) o.h[q].assign(ready->h[q].begin(), ready->h[q].begin() + n);
  if (energy)
    for (int q = 0; q < 3; ++q) o.e[q].assign(ready->e[q], ready->e[q] + n);
  return o;
}

LawArgs law_args(ContactModel model, int variant) {
  LawArgs a{};
  if (model == ContactModel::linear)
    a.one = {2e3, 6e2, 30, 15, 0.4};
  else
    a.one = {1e5, 8e4, 0.5, 0.4, 0.4};
  a.dt = 1e-3;
  a.by_restitution = variant % 2;
  if (a.by_restitution != 0 && model == ContactModel::linear) a.one.gn = 0.3;
  a.centred = (variant / 2) % 2;
  a.onset = a.centred;
  a.recall = a.centred != 0 ? (variant / 16) % 2 : 0;
  a.balanced = model == ContactModel::linear && variant % 3 == 1 ? 1 : 0;
  a.synchronised = (variant / 4) % 2;
  a.contact_lever = (variant / 8) % 2;
  a.clip = variant % 5 == 3 ? 1 : 0;
  a.total = variant % 5 >= 3 ? 1 : 0;
  a.start = variant % 7 == 6 ? 1 : 0;
  return a;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

TEST(Law, AgreesWithTheScalarOracle) {
  // Rounding only: forces cancel to about 1e-3 of their terms at most, hence 1e-11 of the largest force in the batch.
  // The synchronised form expands 1/|c|^2 and leaves (v dt / 2 d)^2 = 3e-6 of the velocity here: 1e-5.
  for (const ContactLaw& law : k_laws)
    for (int variant = 0; variant < 32; ++variant)
      for (const bool friction : {false, true}) {
        const int n = 125;
        Batch b = make_batch(n, friction, 7 + static_cast<std::uint64_t>(variant));
        const LawArgs a = law_args(law.model, variant);
        const Output o = run_law(select_kernels(Isa::scalar), b, n, law_info(law), friction, false, false, a);
        double top = 0;
        const double tolerance = a.synchronised != 0 ? 1e-5 : 1e-11;
        for (int k = 0; k < n; ++k)
          for (int q = 0; q < 3; ++q) top = std::max(top, std::abs(o.r[q][static_cast<std::size_t>(k)]));
        for (int k = 0; k < n; ++k) {
          const auto s = static_cast<std::size_t>(k);
          Vec3 h = b.history[s], second = b.second[s];
          double radius = b.radius[s], predicted = b.predicted[s];
          const reference::Pair& p = b.pairs[s];
          const auto expect = law.model == ContactModel::linear
                                  ? reference::linear(p, a.one, a, friction, h, predicted)
                                  : reference::hertz_mindlin(p, a.one, a, friction, h, radius, predicted,
                                                             law.partial_slip ? &second : nullptr);
          if (a.recall != 0) {
            const int q = recall_column(law_info(law), friction);
            ASSERT_NEAR(o.h[q][s], predicted, tolerance * std::max(1.0, top)) << "variant " << variant << " pair " << k;
          }
          for (int q = 0; q < 3; ++q) {
            ASSERT_NEAR(o.r[q][s], expect.force[q], tolerance * top)
                << law_info(law).name << " variant " << variant << " pair " << k;
            if (friction) {
              ASSERT_NEAR(p.ri * o.r[4 + q][s], expect.torque_i[q], tolerance * top);
              ASSERT_NEAR(p.rj * o.r[4 + q][s], expect.torque_j[q], tolerance * top);
              ASSERT_NEAR(o.h[q][s], h[q], tolerance * (law.model == ContactModel::linear ? 1 : top))
                  << law_info(law).name << " variant " << variant << " pair " << k;
              if (law.partial_slip) {
                ASSERT_NEAR(o.h[4 + q][s], second[q], tolerance * top) << "variant " << variant << " pair " << k;
              }
            }
          }
        }
      }
}

TEST(Law, GivesTheSameBitsOnEveryInstructionSet) {
  for (const ContactLaw& law : k_laws)
    for (int variant = 0; variant < 32; ++variant)
      for (int kind = 0; kind < 8; ++kind)
        for (const int n : {1, 3, 8, 61, 128}) {
          const bool friction = kind % 2 != 0, multi = kind / 2 % 2 != 0, energy = kind / 4 != 0;
          Batch b = make_batch(n, friction, 100 + static_cast<std::uint64_t>(variant));
          LawArgs a = law_args(law.model, variant);
          a.table = &a.one;
          const Output o = run_law(select_kernels(Isa::scalar), b, n, law_info(law), friction, multi, energy, a);
          for (const Isa isa : available_isas()) {
            const Output t = run_law(select_kernels(isa), b, n, law_info(law), friction, multi, energy, a);
            for (int q = 0; q < 8; ++q)
              if (friction || q < 4) {
                ASSERT_TRUE(same_bits(o.r[q], t.r[q]))
                    << isa_name(isa) << " lane " << q << " variant " << variant << " kind " << kind;
              }
            for (int q = 0; q < 3; ++q) ASSERT_TRUE(same_bits(o.e[q], t.e[q])) << isa_name(isa) << " energy " << q;
            {
              const int columns = (friction ? law_info(law).history : 0) + a.recall;
              for (int q = 0; q < columns; ++q)
                ASSERT_TRUE(same_bits(o.h[q], t.h[q])) << isa_name(isa) << " history " << q;
            }
          }
        }
}

TEST(Law, SwappingThePartnersNegatesTheForceExactly) {
  // Pairs across a chunk border are evaluated by both owners: antisymmetry must hold to the bit (DESIGN 2.6).
  for (const ContactLaw& law : k_laws) {
    const int n = 128;
    Batch b = make_batch(n, true, 5);
    const LawArgs a = law_args(law.model, 30);  // all options
    const KernelTable& k = select_kernels(Isa::automatic);
    const Output o = run_law(k, b, n, law_info(law), true, false, false, a);
    std::swap(b.i, b.j);
    for (Vec3& h : b.history) h = -h;
    for (Vec3& h : b.second) h = -h;
    const Output t = run_law(k, b, n, law_info(law), true, false, false, a);
    for (std::size_t s = 0; s < static_cast<std::size_t>(n); ++s)
      for (int q = 0; q < 3; ++q) {
        ASSERT_EQ(o.r[q][s], -t.r[q][s]);
        ASSERT_EQ(o.r[4 + q][s], t.r[4 + q][s]);
        ASSERT_EQ(o.h[q][s], -t.h[q][s]);
      }
    for (int q = 3; q <= law_info(law).history; ++q)  // scalars do not turn round
      for (std::size_t s = 0; s < static_cast<std::size_t>(n); ++s)
        ASSERT_EQ(o.h[q][s], law.partial_slip && q > 3 && q < 7 ? -t.h[q][s] : t.h[q][s]) << q;
  }
}

/// Force rows of all grains and the history of a batch, by the law and a plain scatter, or by a trial whose scatter
/// applies the Coulomb limit. The contacts in [from, to) act on both partners. Three contacts add to each own row,
/// three or more to each partner row (two would commute), as in a list; `late`: the contacts of the second half are
/// added first, by law and scatter.
struct Summed {
  Column<double> f, h[k_max_history];
};

Summed sum_forces(const KernelTable& k, Batch& b, int n, int from, int to, const LawArgs& args, bool trial,
                  bool late = false) {
  const LawInfo& law = law_info(ContactModel::linear);
  const auto ready = std::make_unique<ReadyBlock>(k, b, n, law, true);
  Summed sum;
  sum.f.assign(b.v.size(), 0.0);
  Column<std::int32_t> own = b.i, partner = b.j;  // the padding keeps the dead row
  for (int s = 0; s < n; ++s) {
    own[static_cast<std::size_t>(s)] = s / 3;
    partner[static_cast<std::size_t>(s)] = n + 5 * s % (n / 9 + 1);
  }
  const ScatterArgs rows{sum.f.data(), own.data(), partner.data(), n, from, to, ready->r};
  if (trial) {
    const double back = k.trial(ready->block, args);
    k.scatter_limited(LimitArgs{rows,
                                ready->t,
                                args.contact_lever != 0 ? ready->geo[3] : nullptr,
                                {ready->h[0].data(), ready->h[1].data(), ready->h[2].data()},
                                back});
  } else {
    k.law[law_index(law, true, false, false)](ready->block, args);
    if (late) {  // tests of the test: another order of the sums
      alignas(64) double r[8][k_block + k_pad] = {};
      const int half = n / 2;
      for (int q = 0; q < 8; ++q) std::copy(ready->r[q] + half, ready->r[q] + n, r[q]);
      k.scatter[1](
          ScatterArgs{sum.f.data(), own.data() + half, partner.data() + half, n - half, from - half, to - half, r});
      k.scatter[1](ScatterArgs{sum.f.data(), own.data(), partner.data(), half, from, to, ready->r});
    } else {
      k.scatter[1](rows);
    }
  }
  sum.f.resize(static_cast<std::size_t>(16 * n));                  // without the dead row, which padding lanes write to
  for (std::size_t s = 7; s < sum.f.size(); s += 8) sum.f[s] = 0;  // nobody reads what a law leaves there
  for (int q = 0; q < k_max_history; ++q) sum.h[q].assign(ready->h[q].begin(), ready->h[q].begin() + n);
  return sum;
}

bool same_bits(const Column<double>& a, const Column<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

// Rows repeat within a vector, as own rows and as partners of contacts before: every row must get its terms in list
// order, section by section.
TEST(Scatter, AddsEveryRowsTermsInListOrder) {
  const CounterRng rng(17, 1, 0);
  std::uint32_t draws = 0;
  const auto u = [&] { return rng.uniform(draws++); };
  int repeated = 0, both_ways = 0;
  for (int round = 0; round < 400; ++round) {
    const int rows = 3 + static_cast<int>(u() * 40), most = 1 + round % 5;
    // rows [0, rows) of a chunk, lower ones behind them, then higher ones
    Column<std::int32_t> own, partner;
    int from = 0, to = 0;
    for (int section = 0; section < 3; ++section) {
      if (section == 1) from = static_cast<int>(own.size());
      if (!(section == 1 && round % 7 == 0))  // now and then no pair within the chunk
        for (int i = 0; i < rows; ++i) {
          int j = section == 1 ? i : (section == 0 ? rows : 2 * rows);
          for (int m = static_cast<int>(u() * (most + 1)); m > 0; --m) {
            j += 1 + static_cast<int>(u() * 4);
            if (section == 1 && j >= rows) break;
            own.push_back(i);
            partner.push_back(j);
          }
        }
      if (section == 1) to = static_cast<int>(own.size());
    }
    const int n = std::min<int>(static_cast<int>(own.size()), k_block);
    const std::size_t all = static_cast<std::size_t>(6 * rows) + 400;
    own.resize(own.size() + k_block + k_pad, static_cast<std::int32_t>(all) - 1);
    partner.resize(own.size(), static_cast<std::int32_t>(all) - 1);
    from = std::min(from, n);
    to = std::min(to, n);
    alignas(64) double r[8][k_block + k_pad] = {};
    for (auto& column : r)
      for (double& x : column) x = 2 * u() - 1;
    for (int q = 0; q < n; ++q) {
      const auto a = static_cast<std::size_t>(q);
      repeated += q > 0 && own[a] == own[a - 1] ? 1 : 0;
      for (int p = std::max(0, q - 7); p < q; ++p)
        both_ways += p >= from && q < to && partner[static_cast<std::size_t>(p)] == own[a] ? 1 : 0;
    }
    for (const int width : {4, 8}) {
      Column<double> wanted(width * all, 0.0);
      for (int q = 0; q < n; ++q) {
        double* fi = wanted.data() + static_cast<std::ptrdiff_t>(width) * own[static_cast<std::size_t>(q)];
        for (int c = 0; c < width; ++c) fi[c] = fi[c] + r[c][q];
        if (q < from || q >= to) continue;
        double* fj = wanted.data() + static_cast<std::ptrdiff_t>(width) * partner[static_cast<std::size_t>(q)];
        for (int c = 0; c < width; ++c) fj[c] = c < 3 ? fj[c] - r[c][q] : fj[c] + r[c][q];
      }
      for (const Isa isa : available_isas()) {
        Column<double> f(width * all, 0.0);
        select_kernels(isa).scatter[width == 8 ? 1 : 0](
            ScatterArgs{f.data(), own.data(), partner.data(), n, from, to, r});
        ASSERT_TRUE(same_bits(f, wanted)) << isa_name(isa) << " width " << width << " round " << round;
      }
    }
  }
  // else it would be blind to what it is for
  EXPECT_GT(repeated, 1000);
  EXPECT_GT(both_ways, 1000);
}

// The engine takes the trial wherever it may (LawRules::trial): the limit must not leave a trace of where it was
// applied.
TEST(Law, TrialWithLimitedScatterGivesTheBitsOfLawAndScatter) {
  int sliding = 0, sticking = 0;
  for (int variant = 0; variant < 32; ++variant) {
    LawArgs a = law_args(ContactModel::linear, variant);
    a.balanced = 0;  // the trial knows the default slider only
    for (const int n : {1, 7, 8, 61, 128})
      for (const Isa isa : available_isas()) {
        const KernelTable& k = select_kernels(isa);
        Batch b = make_batch(n, true, 300 + static_cast<std::uint64_t>(variant));
        const int from = n / 3, to = n - n / 4;
        const Summed law = sum_forces(k, b, n, from, to, a, false), trial = sum_forces(k, b, n, from, to, a, true);
        ASSERT_TRUE(same_bits(law.f, trial.f)) << isa_name(isa) << " variant " << variant << " n " << n;
        if (n == 128) {
          ASSERT_FALSE(same_bits(law.f, sum_forces(k, b, n, from, to, a, false, true).f))
              << "blind to the order of sums";
        }
        for (int q = 0; q < law_info(ContactModel::linear).history + a.recall; ++q)
          ASSERT_TRUE(same_bits(law.h[q], trial.h[q])) << isa_name(isa) << " history " << q << " variant " << variant;
        // a contact that the limit does not reach has the same spring without a limit
        LawArgs rough = a;
        rough.one.mu = 1e9;
        const Summed stuck = sum_forces(k, b, n, from, to, rough, true);
        for (std::size_t s = 0; s < static_cast<std::size_t>(n); ++s)
          (stuck.h[0][s] == trial.h[0][s] && stuck.h[1][s] == trial.h[1][s] ? sticking : sliding) += 1;
      }
  }
  EXPECT_GT(sliding, 1000) << "both must occur, or half of it is not tested";
  EXPECT_GT(sticking, 1000);
}

/// Two parts of a list of late contacts, the first nearly full.
struct LateParts {
  std::unique_ptr<LateContacts> part[2] = {std::make_unique<LateContacts>(), std::make_unique<LateContacts>()};
  static constexpr int k_full = k_block - 3, k_first = 1000;
  explicit LateParts(Block& b) {
    part[0]->n = k_full;
    part[0]->next = part[1].get();
    b.late = part[0].get();
    b.first = k_first;
  }
  int count() const { return part[0]->n - k_full + part[1]->n; }
  /// The q-th that has been added: its list and its place there.
  std::pair<LateContacts*, int> at(int q) const {
    return q < 3 ? std::pair{part[0].get(), k_full + q} : std::pair{part[1].get(), q - 3};
  }
};

// Where contacts that begin or end leave their block, they have the forces and histories that they have in it.
TEST(Law, LateContactsHaveTheBitsThatTheyHaveInTheirBlock) {
  const LawInfo& info = law_info(ContactModel::linear);
  int late = 0, others = 0;
  for (int variant = 0; variant < 32; ++variant) {
    LawArgs a = law_args(ContactModel::linear, variant);
    a.balanced = 0;
    for (const int n : {7, 61, 128})
      for (const Isa isa : available_isas()) {
        const KernelTable& k = select_kernels(isa);
        Batch b = make_batch(n, true, 900 + static_cast<std::uint64_t>(variant));
        const Output in_block = run_law(k, b, n, info, true, false, true, a);
        ReadyBlock law(k, b, n, info, true), trial(k, b, n, info, true);
        const LateParts by_law(law.block), by_trial(trial.block);
        k.law[law_index(info, true, false, true)](law.block, a);
        k.trial(trial.block, a);
        ASSERT_EQ(by_law.count(), by_trial.count());
        std::vector<bool> is_late(static_cast<std::size_t>(n));
        for (int part = 0; part < 2; ++part) {
          LateContacts& of = *by_trial.part[part];
          const double back = of.n > 0 ? k.late(of, a) : 0;
          Column<double> f(static_cast<std::size_t>(8 * k_block + 8), 0.0);
          std::vector<std::int32_t> own(k_block + k_pad);
          std::iota(own.begin(), own.end(), 0);
          k.scatter_limited(LimitArgs{{f.data(), own.data(), own.data(), of.n, 0, 0, of.r},
                                      of.t,
                                      a.contact_lever != 0 ? of.g[3] : nullptr,
                                      {of.h[0], of.h[1], of.h[2]},
                                      back});
          for (int q = part == 0 ? LateParts::k_full : 0; q < of.n; ++q)
            for (int c = 0; c < 7; ++c)
              ASSERT_EQ(f[static_cast<std::size_t>(8 * q + c)],
                        in_block.r[c][static_cast<std::size_t>(of.at[q] - LateParts::k_first)]);
        }
        for (int q = 0; q < by_law.count(); ++q) {
          const auto [laws, w] = by_law.at(q);
          const auto [trials, u] = by_trial.at(q);
          ASSERT_EQ(laws->at[w], trials->at[u]);
          const auto s = static_cast<std::size_t>(laws->at[w] - LateParts::k_first);
          is_late[s] = true;
          for (int c = 0; c < 8; ++c) {
            ASSERT_EQ(laws->r[c][w], in_block.r[c][s]);
            ASSERT_EQ(law.r[c][s], 0) << "in both places";
          }
          for (int c = 0; c < info.history + a.recall; ++c) ASSERT_EQ(trials->h[c][u], in_block.h[c][s]);
        }
        for (std::size_t s = 0; s < static_cast<std::size_t>(n); ++s) {
          for (int c = 0; c < info.history + a.recall; ++c) ASSERT_EQ(law.h[c][s], in_block.h[c][s]);
          for (int c = 0; c < 3; ++c) ASSERT_EQ(law.e[c][s], in_block.e[c][s]);
          for (int c = 0; c < 8 && !is_late[s]; ++c) ASSERT_EQ(law.r[c][s], in_block.r[c][s]);
          for (const int c : {0, 1, 2, 3, 7}) {
            if (is_late[s]) {
              ASSERT_EQ(trial.r[c][s], 0) << "in both places";
            }
          }
          ++(is_late[s] ? late : others);
        }
      }
  }
  EXPECT_GT(late, 1000);
  EXPECT_GT(others, 1000);
}

}  // namespace
}  // namespace talus
