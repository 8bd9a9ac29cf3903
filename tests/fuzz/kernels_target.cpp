// Kernels: contacts, rows and lists made from bytes, the same bits on every instruction set. Values cover zeros of both
// signs, denormals, infinities and what is not a number: there all sets have to agree that it is not a number.
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "kernels/kernel_table.hpp"
#include "tests/fuzz/targets.hpp"

namespace talus::fuzz {

namespace {

/// Numbers out of the input; zero when it is used up.
class Source {
 public:
  explicit Source(Bytes b) : b_(b) {}
  unsigned byte() { return at_ < b_.size() ? b_[at_++] : 0U; }
  int below(int n) { return static_cast<int>((byte() | byte() << 8) % static_cast<unsigned>(n)); }
  bool flag() { return (byte() & 1U) != 0; }
  double number() {
    static constexpr double k_special[] = {0.0,
                                           -0.0,
                                           1.0,
                                           -1.0,
                                           5e-324,
                                           -2e-308,
                                           1e-300,
                                           1e300,
                                           1e150,
                                           1e-30,
                                           -1e150,
                                           3.0e-8,
                                           std::numeric_limits<double>::infinity(),
                                           -std::numeric_limits<double>::infinity(),
                                           std::numeric_limits<double>::quiet_NaN(),
                                           0.5};
    const unsigned kind = byte();
    if (kind < 16) return k_special[kind];
    const auto bits = static_cast<std::int32_t>(byte() << 24 | byte() << 16 | byte() << 8 | byte());
    return static_cast<double>(bits) * 0x1p-31 * (kind < 64 ? 10 : 1);
  }
  /// Ordinary and positive.
  double size() { return 0.5 + 0.5 * static_cast<double>(byte()) / 256; }

 private:
  Bytes b_;
  std::size_t at_ = 0;
};

/// Outputs of a kernel as bits; all values that are no numbers are one.
class Outcome {
 public:
  void add(const double* x, std::size_t n) {
    for (std::size_t k = 0; k < n; ++k) {
      std::uint64_t u;
      std::memcpy(&u, x + k, sizeof u);
      bits_.push_back(x[k] == x[k] ? u : ~std::uint64_t{0});
    }
  }
  template <class T>
  void add_integers(const T* x, std::size_t n) {
    for (std::size_t k = 0; k < n; ++k) bits_.push_back(static_cast<std::uint64_t>(x[k]));
  }
  bool operator==(const Outcome&) const = default;

 private:
  std::vector<std::uint64_t> bits_;
};

template <class F>
void same_on_all(F run) {
  const Outcome wanted = run(select_kernels(Isa::scalar));
  for (const Isa isa : available_isas())
    if (!(run(select_kernels(isa)) == wanted)) __builtin_trap();
}

constexpr int k_rows = 40;
using Columns = double[8][k_block + k_pad];

/// Rows of grains and the contacts of a block.
struct Input {
  Column<double> p, v;
  Column<std::int32_t> i, j;
  int n = 0;
  bool rotation = false;
  Column<double> h[k_max_columns];

  explicit Input(Source& s) {
    rotation = s.flag();
    const int stride = rotation ? 8 : 4;
    p.assign(4 * (k_rows + 16), 1e150);
    v.assign(static_cast<std::size_t>(stride) * (k_rows + 16), 0.0);
    for (int k = 0; k < k_rows; ++k) {
      for (int a = 0; a < 3; ++a) p[4 * k + a] = s.number();
      p[4 * k + 3] = s.size();
      for (int a = 0; a + 1 < stride; ++a)
        if (a != 3 || !rotation) v[stride * k + a] = s.number();
      v[stride * k + stride - 1] = s.byte() % 8 == 0 ? 0.0 : s.size();
    }
    for (int k = k_rows; k < k_rows + 16; ++k) p[4 * k + 3] = 0, v[stride * k + stride - 1] = 1;
    n = 1 + s.below(k_block);
    for (int k = 0; k < n; ++k) {
      const int a = s.below(k_rows), b = s.below(k_rows);
      i.push_back(a);
      j.push_back(a == b ? (b + 1) % k_rows : b);
    }
    i.resize(static_cast<std::size_t>(n + k_pad), k_rows);
    j.resize(static_cast<std::size_t>(n + k_pad), k_rows);
    for (auto& column : h) {
      column.assign(static_cast<std::size_t>(k_block + k_pad), 0.0);
      for (int k = 0; k < n; ++k) column[static_cast<std::size_t>(k)] = s.number();
    }
  }
};

LawArgs law_args(Source& s) {
  LawArgs a{};
  a.one = {1e3 * s.size(), 5e2 * s.size(), s.size(), s.size(), s.size(), 0.1 * s.size()};
  a.dt = 1e-3 * s.size();
  a.by_restitution = s.flag() ? 1 : 0;
  a.centred = s.flag() ? 1 : 0;
  a.recall = a.centred != 0 && s.flag() ? 1 : 0;
  a.onset = s.flag() ? 1 : 0;
  a.synchronised = s.flag() ? 1 : 0;
  a.contact_lever = s.flag() ? 1 : 0;
  a.clip = s.flag() ? 1 : 0;
  a.balanced = s.flag() ? 1 : 0;
  return a;
}

/// Gather, a law, what is added to it, and the scatter.
Outcome run_block(const KernelTable& k, const Input& in, const LawInfo& law, const LawArgs& args, int kind,
                  const MomentArgs* moments, const CohesionArgs* cohesion) {
  struct Buffers {
    alignas(64) Columns x{}, g{}, r{}, e{}, t{}, s{};
    alignas(64) double reff[k_block + k_pad] = {};
    alignas(64) std::int32_t pair[k_block + k_pad] = {};
  };
  const auto b = std::make_unique<Buffers>();
  Column<double> h[k_max_columns];
  for (int q = 0; q < k_max_columns; ++q) h[q] = in.h[q];
  GatherArgs gather{};
  gather.v = in.v.data();
  gather.p = in.p.data();
  gather.i = in.i.data();
  gather.j = in.j.data();
  gather.n = in.n;
  gather.x = b->x;
  gather.r = b->r;
  gather.g = b->g;
  gather.reff = b->reff;
  k.gather[in.rotation ? 1 : 0](gather);
  Block block{};
  block.n = in.n;
  block.x = b->x[0];
  block.y = b->x[1];
  block.z = b->x[2];
  block.w = b->x[3];
  block.g = b->g;
  block.r = b->r;
  for (int q = 0; q < k_max_history; ++q) block.h_in[q] = block.h[q] = h[q].data();
  block.reff = b->reff;
  block.pair = b->pair;
  block.e = b->e;
  block.t = b->t;
  LawArgs a = args;
  a.table = &args.one;
  k.law[law.slot + (in.rotation ? 1 : 0) + kind](block, a);
  const auto n = static_cast<std::size_t>(in.n);
  Outcome out;
  if (moments != nullptr && in.rotation) {
    k.spin(SpinArgs{in.p.data(), in.v.data(), in.i.data(), in.j.data(), in.n, b->s});
    MomentBlock m{};
    m.n = in.n;
    m.x = b->x[0];
    m.y = b->x[1];
    m.z = b->x[2];
    m.r = b->r;
    m.reff = b->reff;
    m.s = b->s;
    for (int q = 0; q < k_max_moment; ++q) m.h[q] = h[k_max_history + q].data();
    m.e = b->e;
    k.moments(m, *moments);
    for (int q = 0; q < 3; ++q) out.add(b->s[q], n);
  }
  if (cohesion != nullptr) {
    CohesionArgs c = *cohesion;
    c.p = in.p.data();
    c.i = in.i.data();
    c.j = in.j.data();
    k.cohesion(block, c);
  }
  for (int q = 0; q < (in.rotation ? 7 : 3); ++q) out.add(b->r[q], n);
  for (int q = 0; q < (in.rotation ? law.history : 0) + args.recall; ++q) out.add(h[q].data(), n);
  if (kind >= 4)
    for (int q = 0; q < 3; ++q) out.add(b->e[q], n);
  Column<double> f(in.v.size(), 0.0);
  k.scatter[in.rotation ? 1 : 0](ScatterArgs{f.data(), in.i.data(), in.j.data(), in.n, in.n / 3, in.n, b->r});
  const int stride = in.rotation ? 8 : 4;
  for (int row = 0; row < k_rows; ++row) out.add(f.data() + stride * row, static_cast<std::size_t>(stride - 1));
  return out;
}

Outcome run_narrow(const KernelTable& k, const Input& in, bool periodic, unsigned seed) {
  Column<std::int32_t> pi = in.i, pj = in.j;
  pi.resize(static_cast<std::size_t>((in.n + 7) / 8 * 8));
  pj.resize(pi.size());
  for (std::size_t q = static_cast<std::size_t>(in.n); q < pi.size(); ++q) pi[q] = pj[q] = k_rows;
  const std::size_t slots = pi.size();
  pi.resize(slots + 1024, k_rows);
  pj.resize(slots + 1024, k_rows);
  std::vector<std::uint8_t> mask(slots / 8 + 16, static_cast<std::uint8_t>(seed));
  Column<HistoryRun> runs(slots + 64);
  Column<std::int32_t> ci(slots + 64), cj(slots + 64);
  NarrowArgs a{};
  a.p = in.p.data();
  a.pi = pi.data();
  a.pj = pj.data();
  a.mask = mask.data();
  a.end[0] = static_cast<std::int64_t>(slots / 24 * 8);
  a.end[1] = a.end[0];
  a.end[2] = static_cast<std::int64_t>(slots);
  for (int q = 0; q < 3; ++q) a.half[q] = periodic ? 2.5 : 1e300, a.period[q] = periodic ? 5 : 0;
  a.periodic = periodic ? 1 : 0;
  a.runs = runs.data();
  a.ci = ci.data();
  a.cj = cj.data();
  k.narrow(a);
  Outcome out;
  out.add_integers(ci.data(), static_cast<std::size_t>(a.contact_end[2]));
  out.add_integers(cj.data(), static_cast<std::size_t>(a.contact_end[2]));
  out.add_integers(a.contact_end, 3);
  out.add_integers(mask.data(), slots / 8);
  for (int q = 0; q < a.run_count; ++q) out.add_integers(&runs[static_cast<std::size_t>(q)].to, 1);
  for (int q = 0; q < a.run_count; ++q) out.add_integers(&runs[static_cast<std::size_t>(q)].from, 1);
  return out;
}

Outcome run_integrate(const KernelTable& k, const Input& in, bool periodic, bool stream, double viscous, double local) {
  const auto stride = static_cast<std::size_t>(in.rotation ? 8 : 4);
  Column<double> f(in.v.size(), 0.0), p2(in.p.size(), 0.0), v2(in.v.size(), 0.0), x0 = in.p;
  for (std::size_t q = 0; q < f.size() && q < in.h[0].size(); ++q) f[q] = in.h[0][q];
  for (int row = 0; row < k_rows; ++row) x0[4 * row + 3] = 1e-6;
  Column<std::int32_t> left(k_rows + 16);
  IntegrateArgs a{};
  a.lo = 0;
  a.hi = k_rows;
  a.p = in.p.data();
  a.v = in.v.data();
  a.f = f.data();
  a.p2 = p2.data();
  a.v2 = v2.data();
  a.x0 = x0.data();
  a.dt = a.kick = 1e-3;
  a.gravity[2] = -9.81;
  for (int q = 0; q < 3; ++q) {
    a.upper[q] = 5;
    a.wrap[q] = periodic ? 5 : 0;
    a.half[q] = periodic ? 2.5 : 1e300;
  }
  a.upper[3] = a.half[3] = 1e300;
  a.viscous = viscous;
  a.local = local;
  a.stream = stream ? 1 : 0;
  a.unstable = 1e6;
  a.out = left.data();
  k.integrate[in.rotation ? 1 : 0](a);
  Outcome out;
  out.add(p2.data(), 4 * k_rows);
  out.add(v2.data(), stride * k_rows);
  out.add_integers(left.data(), static_cast<std::size_t>(a.out_count));
  const std::int32_t rest[] = {a.out_count, a.expired, a.unstable_row};
  out.add_integers(rest, 3);
  return out;
}

}  // namespace

void kernels(Bytes input) {
  Source s(input);
  const int what = s.below(4), model = s.below(3), kind = 2 * s.below(4);
  const bool first = s.flag(), second = s.flag();
  LawArgs args = law_args(s);
  MomentArgs moments{};
  moments.one = {s.size(), s.size(), s.size(), s.size(), 0, 0};
  moments.dt = args.dt;
  moments.rolling = s.below(3);
  moments.twisting = s.below(2);
  moments.centred = args.centred;
  const CohesionArgs cohesion{s.size(), nullptr, nullptr, nullptr, nullptr, kind >= 4 ? 1 : 0};
  const auto in = std::make_unique<Input>(s);
  if (what == 0)
    return same_on_all(
        [&](const KernelTable& k) { return run_narrow(k, *in, first, args.centred != 0 ? 0xffU : 0x5aU); });
  if (what == 1)
    return same_on_all([&](const KernelTable& k) {
      return run_integrate(k, *in, first, second, args.clip != 0 ? 0.1 : 0, args.onset != 0 ? 0.2 : 0);
    });
  static constexpr ContactModel k_models[] = {ContactModel::linear, ContactModel::hertz_mindlin, ContactModel::jkr};
  const LawInfo& law = law_info(k_models[model]);
  same_on_all([&](const KernelTable& k) {
    return run_block(k, *in, law, args, kind, first ? &moments : nullptr, second ? &cohesion : nullptr);
  });
}

}  // namespace talus::fuzz
