// Kernels on contacts, rows and lists made from bytes: the same bits on every instruction set. Values cover zeros of
// both signs, denormals, infinities and what is not a number: there all sets have to agree that it is not a number.
#include <cstring>
#include <memory>
#include <vector>

#include "kernels/kernel_table.hpp"
#include "tests/fuzz/values.hpp"

namespace talus::fuzz {

namespace {

constexpr int k_rows = 14;    ///< the row behind them is the dead one
constexpr int k_slots = 128;  ///< of a list
constexpr int k_size = k_block + k_pad;
using Column8 = double[8][k_size];

/// Outputs of a kernel as bits; all values that are no numbers are one.
class Outcome {
 public:
  void add(const double* x, int n) {
    if (n == 0) return;
    std::uint64_t* to = room(n);
    std::memcpy(to, x, sizeof(double) * static_cast<std::size_t>(n));
    for (int k = 0; k < n; ++k)
      if (x[k] != x[k]) to[k] = ~std::uint64_t{0};
  }
  template <class T>
  void add_integers(const T* x, std::int64_t n) {
    if (n == 0) return;
    std::uint64_t* to = room(n);
    for (std::int64_t k = 0; k < n; ++k) to[k] = static_cast<std::uint64_t>(x[k]);
  }
  bool operator==(const Outcome&) const = default;

 private:
  std::uint64_t* room(std::int64_t n) {
    const std::size_t old = bits_.size();
    bits_.resize(old + static_cast<std::size_t>(n));
    return bits_.data() + old;
  }
  std::vector<std::uint64_t> bits_;
};

template <class Run>
void same_on_all(const char* what, Run run) {
  const Outcome wanted = run(select_kernels(Isa::scalar));
  for (const Isa isa : available_isas())
    if (isa != Isa::scalar) claim(run(select_kernels(isa)) == wanted, what);
}

/// Rows of grains, pairs of them, and numbers for histories.
struct Input {
  Column<double> p, v;
  Column<std::int32_t> i, j;
  int n = 0;
  int rotation = 0;
  double pool[23];

  explicit Input(Values& s) {
    rotation = s.flag();
    n = 1 + s.below(48);
    const int stride = rotation != 0 ? 8 : 4;
    p.assign(4 * (k_rows + k_pad), 1e150);
    v.assign(static_cast<std::size_t>(stride * (k_rows + k_pad)), 0.0);
    for (int k = 0; k < k_rows + k_pad; ++k) {
      const bool dead = k >= k_rows;
      double *x = p.data() + 4L * k, *u = v.data() + static_cast<long>(stride) * k;
      for (int a = 0; a < 3 && !dead; ++a) x[a] = s.any();
      x[3] = dead ? 0 : s.between(0.5, 1);
      for (int a = 0; a + 1 < stride && !dead; ++a) u[a] = a == 3 ? 0 : s.any();
      u[stride - 1] = dead ? 1.0 : (s.below(8) == 0 ? 0.0 : s.between(0.5, 1));
    }
    for (double& x : pool) x = s.any();
    i.assign(k_slots + 1024, k_rows);
    j.assign(k_slots + 1024, k_rows);
    unsigned walk = 0;  // pairs that go on when the bytes are used up
    for (int k = 0; k < n; ++k) {
      walk = walk * 5 + 1 + s.byte();
      const int a = static_cast<int>(walk % k_rows), b = static_cast<int>(walk / k_rows % k_rows);
      i[static_cast<std::size_t>(k)] = a;
      j[static_cast<std::size_t>(k)] = a == b ? (b + 1) % k_rows : b;
    }
  }
  Column<double> history(int column) const {
    Column<double> h(k_size, 0.0);
    for (int k = 0; k < n; ++k) h[static_cast<std::size_t>(k)] = pool[(7 * column + 3 * k) % 23];
    return h;
  }
};

LawArgs law_args(Values& s) {
  LawArgs a{};
  a.one = {s.between(0, 1e4), s.between(1, 1e3), s.between(0, 2), s.between(0, 2), s.between(0, 1), s.between(0, 0.1)};
  a.dt = s.between(0, 2e-3);
  a.by_restitution = s.flag();
  a.centred = s.flag();
  a.recall = a.centred & s.flag();
  a.onset = s.flag();
  a.synchronised = s.flag();
  a.contact_lever = s.flag();
  a.clip = s.flag();
  a.balanced = s.flag();
  return a;
}

/// A gathered block with its histories.
struct Ready {
  alignas(64) Column8 x{}, g{}, r{}, e{}, t{}, s{};
  alignas(64) double reff[k_size] = {}, slid[k_size] = {};
  alignas(64) std::int32_t pair[k_size] = {};
  Column<double> h[k_max_columns];
  Block block{};

  Ready(const KernelTable& k, const Input& in, int periodic, Outcome& out) {
    for (int q = 0; q < k_max_columns; ++q) h[q] = in.history(q);
    GatherArgs a{};
    a.v = in.v.data();
    a.p = in.p.data();
    a.i = in.i.data();
    a.j = in.j.data();
    a.n = in.n;
    a.x = x;
    a.r = r;
    a.g = g;
    a.reff = reff;
    a.deep = 0.5;
    a.periodic = periodic;
    for (int q = 0; q < 3; ++q) a.half[q] = periodic != 0 ? 2.5 : 1e300, a.period[q] = periodic != 0 ? 5 : 0;
    k.gather[in.rotation](a);
    out.add_integers(&a.deep_found, 1);
    for (int q = 0; q < 4; ++q) out.add(x[q], in.n), out.add(g[q], in.n);
    block.n = in.n;
    block.x = x[0];
    block.y = x[1];
    block.z = x[2];
    block.w = x[3];
    block.g = g;
    block.r = r;
    for (int q = 0; q < k_max_history; ++q) block.h_in[q] = block.h[q] = h[q].data();
    block.reff = reff;
    block.pair = pair;
    block.e = e;
    block.t = t;
    block.slid = slid;
  }
  Ready(const Ready&) = delete;
};

ScatterArgs scatter_args(const Input& in, Ready& b, Column<double>& f) {
  f.assign(in.v.size(), 0.0);
  return {f.data(), in.i.data(), in.j.data(), in.n, in.n / 3, in.n - in.n / 4, b.r};
}

void add_rows(Outcome& out, const Input& in, const Column<double>& f) {
  const int stride = in.rotation != 0 ? 8 : 4;
  for (int row = 0; row < k_rows; ++row) out.add(f.data() + stride * row, stride - 1);
}

struct AddOns {
  MomentArgs moments{};
  CohesionArgs cohesion{};
  bool turning = false, pulling = false;
};

AddOns add_ons(Values& s, const LawArgs& law) {
  AddOns a;
  a.turning = s.flag() != 0;
  a.pulling = s.flag() != 0;
  a.moments.one = {s.between(0, 1), s.between(0, 1), s.between(0, 1), s.between(0, 1), 0};
  a.moments.dt = law.dt;
  a.moments.rolling = s.below(3);
  a.moments.twisting = s.flag();
  a.moments.rescale = s.flag();
  a.moments.centred = law.centred;
  a.cohesion.one = s.between(0, 10);
  return a;
}

/// Gather, a law, what is added to it, and the scatter. `kind`: as law_index(), without friction.
Outcome run_block(const KernelTable& k, const Input& in, const LawInfo& law, const LawArgs& args, int kind,
                  int periodic, const AddOns& add) {
  Outcome out;
  const auto b = std::make_unique<Ready>(k, in, periodic, out);
  LawArgs a = args;
  a.table = &args.one;
  k.law[law.slot() + in.rotation + kind](b->block, a);
  if (add.turning && in.rotation != 0) {
    k.spin(SpinArgs{in.p.data(), in.v.data(), in.i.data(), in.j.data(), in.n, b->s});
    MomentBlock m{};
    m.n = in.n;
    m.x = b->x[0];
    m.y = b->x[1];
    m.z = b->x[2];
    m.r = b->r;
    m.reff = b->reff;
    m.slid = b->slid;
    m.pair = b->pair;
    m.s = b->s;
    for (int q = 0; q < k_max_moment; ++q) m.h[q] = b->h[k_max_history + q].data();
    m.e = kind >= 4 ? b->e : nullptr;
    MomentArgs moments = add.moments;
    moments.table = kind % 4 != 0 ? &add.moments.one : nullptr;
    k.moments(m, moments);
    for (int q = 0; q < 3; ++q) out.add(b->s[q], in.n);
    for (int q = k_max_history; q < k_max_columns; ++q) out.add(b->h[q].data(), in.n);
  }
  if (add.pulling) {
    CohesionArgs c = add.cohesion;
    c.table = kind % 4 != 0 ? &add.cohesion.one : nullptr;
    c.p = in.p.data();
    c.i = in.i.data();
    c.j = in.j.data();
    c.energy = kind >= 4 ? 1 : 0;
    k.cohesion(b->block, c);
  }
  for (int q = 0; q < (in.rotation != 0 ? 7 : 4); ++q) out.add(b->r[q], in.n);
  for (int q = 0; q < (in.rotation != 0 ? law.history : 0) + args.recall; ++q) out.add(b->h[q].data(), in.n);
  for (int q = 0; q < 3 && kind >= 4; ++q) out.add(b->e[q], in.n);
  Column<double> f;
  k.scatter[in.rotation](scatter_args(in, *b, f));
  add_rows(out, in, f);
  return out;
}

/// The linear law up to the Coulomb limit and the scatter that applies it.
Outcome run_trial(const KernelTable& k, const Input& in, const LawArgs& args, int periodic) {
  Outcome out;
  const auto b = std::make_unique<Ready>(k, in, periodic, out);
  const double back = k.trial(b->block, args);
  out.add(&back, 1);
  Column<double> f;
  k.scatter_limited(LimitArgs{scatter_args(in, *b, f),
                              b->t,
                              args.contact_lever != 0 ? b->g[3] : nullptr,
                              {b->h[0].data(), b->h[1].data(), b->h[2].data()},
                              back});
  add_rows(out, in, f);
  for (int q = 0; q < 3 + args.recall; ++q) out.add(b->h[q].data(), in.n);
  return out;
}

/// Of two lists of late contacts the first is nearly full, so that some go on in the second.
struct LateParts {
  std::unique_ptr<LateContacts> part[2] = {std::make_unique<LateContacts>(), std::make_unique<LateContacts>()};
  static constexpr int k_first = 1000;
  int full;
  LateParts(Block& b, int room) : full(k_block - room) {
    part[0]->n = full;
    part[0]->next = part[1].get();
    b.late = part[0].get();
    b.first = k_first;
  }
};

bool same(double a, double b) { return a == b || (a != a && b != b); }

/// A finished trial leaves a limit of 1e150 N, which no force that means anything exceeds.
bool means_something(const Ready& b, int at) {
  for (int c = 0; c < 8; ++c)
    if (!(b.r[c][at] > -1e100 && b.r[c][at] < 1e100)) return false;
  return true;
}

/// Contacts that begin or end leave their block for lists (`room`: places of the first), and are finished there:
/// places, forces and histories have to be those that they have in their block.
Outcome run_late(const KernelTable& k, const Input& in, const LawArgs& a, int periodic, int room) {
  Outcome out;
  const auto whole = std::make_unique<Ready>(k, in, periodic, out),
             by_law = std::make_unique<Ready>(k, in, periodic, out),
             by_trial = std::make_unique<Ready>(k, in, periodic, out);
  const int law = law_index(law_info(ContactModel::linear), true, false, false);
  k.law[law](whole->block, a);
  LateParts laws(by_law->block, room), trials(by_trial->block, room);
  k.law[law](by_law->block, a);
  k.trial(by_trial->block, a);
  for (int p = 0; p < 2; ++p) {
    const LateContacts& of_law = *laws.part[p];
    LateContacts& of = *trials.part[p];
    const int from = p == 0 ? trials.full : 0;
    claim(of.n == of_law.n, "law and trial set aside other contacts");
    const double back = of.n > 0 ? k.late(of, a) : 0;
    Column<double> f(static_cast<std::size_t>(8 * (k_block + k_pad)), 0.0);
    std::vector<std::int32_t> own(k_size);
    for (int q = 0; q < k_size; ++q) own[static_cast<std::size_t>(q)] = q < k_block ? q : k_block;
    k.scatter_limited(LimitArgs{{f.data(), own.data(), own.data(), of.n, 0, 0, of.r},
                                of.t,
                                a.contact_lever != 0 ? of.g[3] : nullptr,
                                {of.h[0], of.h[1], of.h[2]},
                                back});
    for (int q = from; q < of.n; ++q) {
      const int at = of.at[q] - LateParts::k_first;
      claim(at == of_law.at[q] - LateParts::k_first && at >= 0 && at < in.n, "a late contact has lost its place");
      for (int c = 0; c < 7; ++c) {
        claim(same(f[static_cast<std::size_t>(8 * q + c)], whole->r[c][at]) || !means_something(*whole, at),
              "a late force is not that of the block");
        claim(same(of_law.r[c][q], whole->r[c][at]), "a late force of the law is not that of the block");
        claim(by_law->r[c][at] == 0, "a late force is in both places");
      }
      for (int c = 0; c < 3 + a.recall; ++c)
        claim(same(of.h[c][q], whole->h[c][static_cast<std::size_t>(at)]) || !means_something(*whole, at),
              "a late history is not that of the block");
      out.add_integers(&at, 1);
      out.add(f.data() + 8L * q, 7);
    }
  }
  for (int c = 0; c < 3 + a.recall; ++c) {
    for (std::size_t q = 0; q < static_cast<std::size_t>(in.n); ++q)
      claim(same(by_law->h[c][q], whole->h[c][q]), "a history of a block that late contacts left has changed");
    out.add(by_law->h[c].data(), in.n);
  }
  return out;
}

/// Narrow phase of three sections; with a range of adhesion the one whose contacts hold beyond touch, and its
/// histories.
Outcome run_narrow(const KernelTable& k, const Input& in, int periodic, unsigned was, const double* range) {
  constexpr int groups = k_slots / 8;
  std::vector<std::uint8_t> mask(groups + 16);
  for (int g = 0; g < groups; ++g) mask[static_cast<std::size_t>(g)] = static_cast<std::uint8_t>(was * (2U * g + 1U));
  const std::vector<std::uint8_t> before = mask;
  Column<HistoryRun> runs(k_slots + 64);
  Column<std::int32_t> ci(k_slots + 64), cj(k_slots + 64);
  NarrowArgs a{};
  a.p = in.p.data();
  a.pi = in.i.data();
  a.pj = in.j.data();
  a.mask = mask.data();
  a.end[0] = in.n / 24 * 8;
  a.end[1] = in.n / 12 * 8;
  a.end[2] = (in.n + 7) / 8 * 8;
  for (int q = 0; q < 3; ++q) a.half[q] = periodic != 0 ? 2.5 : 1e300, a.period[q] = periodic != 0 ? 5 : 0;
  a.periodic = periodic;
  a.runs = range == nullptr && (was & 1U) != 0 ? runs.data() : nullptr;
  a.ci = ci.data();
  a.cj = cj.data();
  Outcome out;
  if (range == nullptr) {
    k.narrow(a);
    for (int q = 0; q < a.run_count; ++q) out.add_integers(&runs[static_cast<std::size_t>(q)].to, 1);
    for (int q = 0; q < a.run_count; ++q) out.add_integers(&runs[static_cast<std::size_t>(q)].from, 1);
  } else {
    k.narrow_adhesive(a, {nullptr, 1, range});
    Column<double> from(k_slots + 64, 0.0), to(k_slots + 64, 0.0);
    for (int q = 0; q < k_slots; ++q) from[static_cast<std::size_t>(q)] = in.pool[q % 23];
    k.carry(CarryArgs{before.data(), mask.data(), a.end[2], 1, {from.data()}, {to.data()}});
    out.add(to.data(), static_cast<int>(a.contact_end[2]));
  }
  out.add_integers(a.contact_end, 3);
  out.add_integers(ci.data(), a.contact_end[2]);
  out.add_integers(cj.data(), a.contact_end[2]);
  out.add_integers(mask.data(), a.end[2] / 8);
  return out;
}

struct Course {
  int periodic, stream, drift;
  double viscous, local, kick;
};

Outcome run_integrate(const KernelTable& k, const Input& in, const Course& c) {
  const int stride = in.rotation != 0 ? 8 : 4;
  Column<double> f(in.v.size(), 0.0), p2(in.p.size(), 0.0), v2(in.v.size(), 0.0), x0 = in.p, loss(in.p.size(), 0.0);
  for (int q = 0; q < stride * k_rows; ++q) f[static_cast<std::size_t>(q)] = in.pool[(5 * q + 1) % 23];
  for (int row = 0; row < k_rows; ++row) x0[static_cast<std::size_t>(4 * row + 3)] = 1e-6;
  Column<float> drift(static_cast<std::size_t>(4 * (k_rows + k_pad)), 0.0F);
  for (int q = 0; q < 4 * k_rows; ++q)
    if (q % 4 != 3) drift[static_cast<std::size_t>(q)] = static_cast<float>(q) * 0.01F;
  Column<std::int32_t> left(k_rows + k_pad);
  IntegrateArgs a{};
  a.hi = k_rows;
  a.p = in.p.data();
  a.v = in.v.data();
  a.f = f.data();
  a.p2 = p2.data();
  a.v2 = v2.data();
  a.x0 = x0.data();
  a.drift = c.drift != 0 ? drift.data() : nullptr;
  a.drift_stride = c.drift == 1 ? 4 : 0;
  a.drift_time = 0.25;
  a.dt = 1e-3;
  a.kick = c.kick;
  a.gravity[2] = -9.81;
  for (int q = 0; q < 3; ++q) {
    a.upper[q] = 5;
    a.wrap[q] = c.periodic != 0 ? 5 : 0;
    a.half[q] = c.periodic != 0 ? 2.5 : 1e300;
  }
  a.upper[3] = a.half[3] = 1e300;
  a.viscous = c.viscous;
  a.local = c.local;
  a.loss = loss.data();
  a.stream = c.stream;
  a.unstable = 1e6;
  a.out = left.data();
  k.integrate[in.rotation](a);
  Outcome out;
  out.add(p2.data(), 4 * k_rows);
  out.add(v2.data(), stride * k_rows);
  out.add(f.data(), stride * k_rows);
  out.add(loss.data(), 4 * k_rows);
  out.add_integers(left.data(), a.out_count);
  const std::int32_t rest[] = {a.out_count, a.expired, a.unstable_row};
  out.add_integers(rest, 3);
  return out;
}

}  // namespace

void kernels(Bytes input) {
  Values s(input);
  const int what = s.below(6), model = s.below(4), kind = 2 * s.below(4), periodic = s.flag();
  const unsigned was = s.byte();
  const LawArgs args = law_args(s);
  const AddOns add = add_ons(s, args);
  const double range = s.between(0, 0.1);
  const Course course{periodic, s.flag(), s.below(3), s.flag() * 0.1, s.flag() * 0.2, s.between(0, 1e-3)};
  const auto in = std::make_unique<Input>(s);
  if (what <= 1)
    return same_on_all("narrow phase", [&](const KernelTable& k) {
      return run_narrow(k, *in, periodic, was, what == 0 ? nullptr : &range);
    });
  if (what == 2) return same_on_all("integration", [&](const KernelTable& k) { return run_integrate(k, *in, course); });
  if (what == 3 && in->rotation != 0 && args.balanced == 0) {
    same_on_all("trial", [&](const KernelTable& k) { return run_trial(k, *in, args, periodic); });
    LawArgs late = args;
    late.total = was & 1U;
    late.start = was >> 1 & 1U;
    const int room = static_cast<int>(was >> 2) % 16;
    return same_on_all("late contacts", [&](const KernelTable& k) { return run_late(k, *in, late, periodic, room); });
  }
  static constexpr ContactModel k_models[] = {ContactModel::linear, ContactModel::hertz_mindlin, ContactModel::jkr,
                                              ContactModel::hertz_mindlin};
  ContactLaw chosen;
  chosen.model = k_models[model];
  chosen.partial_slip = model == 3;
  const LawInfo& law = law_info(chosen);
  same_on_all("contact law", [&](const KernelTable& k) { return run_block(k, *in, law, args, kind, periodic, add); });
}

}  // namespace talus::fuzz
