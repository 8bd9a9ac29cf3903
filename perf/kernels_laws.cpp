// Rows of the contact laws, of the trial and the limiting scatter that the linear law takes in a step, and of what is
// added to laws: rolling and twisting moments, cohesion, necks, the carry-over of their history. Who calls it:
// perf/kernels.cpp.
#include <algorithm>
#include <cstring>

#include "perf/kernels_measure.hpp"
#include "perf/touching.hpp"

namespace talus::perf {

namespace {

/// The first block of real contacts of the small bed, in L1. Laws work in place: their input is put back from a copy
/// before each call, the copy is timed alone and taken off.
struct LawBlock {
  Bed& bed = Bed::get(false);
  Touching touching{bed};
  BlockBuffers run, kept;
  alignas(64) double history[k_max_columns][k_block + k_pad] = {};
  Block block{};
  LawArgs args = bed.w.law_args;
  std::size_t input_rows;  ///< that restore() puts back

  explicit LawBlock(bool friction) : input_rows(friction ? 8 : 4) {
    const Chunk& c = chunk();
    GatherArgs gather = gather_args(bed.w, c, 0, kept);
    select_kernels(Isa::automatic).gather[1](gather);
    if (!friction) std::memcpy(kept.r[3], kept.r[7], sizeof kept.r[7]);  // without rotation 1/m_i + 1/m_j is in lane 3
    std::memcpy(run.x, kept.x, sizeof run.x);
    std::memcpy(run.g, kept.g, sizeof run.g);
    std::fill(run.reff, run.reff + k_block, 0.25);
    for (int k = 0; k < std::min(k_max_history, bed.w.has.history_columns); ++k)
      std::copy_n(c.h[k].data(), k_block, history[k]);
    block.n = block_size(c, 0);
    block.x = run.x[0];
    block.y = run.x[1];
    block.z = run.x[2];
    block.w = run.x[3];
    block.g = run.g;
    block.r = run.r;
    for (int k = 0; k < k_max_history; ++k) block.h_in[k] = block.h[k] = history[k];
    block.reff = run.reff;
    block.pair = run.pair;
    block.e = run.e;
    block.t = run.t;
    restore();
  }
  [[nodiscard]] const Chunk& chunk() const { return *bed.w.chunks[0]; }
  void restore() {
    std::memcpy(run.r, kept.r, sizeof run.r[0] * input_rows);
    benchmark::ClobberMemory();
  }
  /// ns per contact of what `copy` does.
  template <class F>
  double cost(F copy) const {
    constexpr int repeats = 20000;
    const double begin = now_ns();
    for (int k = 0; k < repeats; ++k) copy();
    return (now_ns() - begin) / repeats / block.n;
  }
};

void label_copy(benchmark::State& state, double copy) {
  state.SetLabel("copy taken off: " + std::to_string(copy) + " ns");
}

struct LawCase {
  ContactModel model;
  bool friction, multi, energy;
  [[nodiscard]] std::string name() const {
    return std::string("law_") + law_info(model).name + (friction ? "" : "_frictionless") + (multi ? "_multi" : "") +
           (energy ? "_energy" : "");
  }
};

void run_law(benchmark::State& state, const KernelTable& t, const LawCase& law) {
  LawBlock b(law.friction);
  const LawInfo& info = law_info(law.model);
  // 4/3 E*, 8 G*, alpha: grains of reduced units; JKR: pulled off by a few times their weight
  if (info.wants_reff) b.args.one = {1e7, 1e7, 0.3, 0.2, 0.5, 1};
  const PairParameters table[1] = {b.args.one};
  b.args.table = table;
  const double copy = b.cost([&] { b.restore(); });
  const int index = law_index(info, law.friction, law.multi, law.energy);
  // in: distance and what follows from it, motion, history; out: force rows, history, energies. All of it in L1
  const double lanes = 8 + (law.friction ? 8 + 7 : 4 + 4) +
                       2.0 * ((law.friction ? info.history : 0) + b.bed.w.law_args.recall) + (info.wants_reff ? 1 : 0) +
                       (law.energy ? 3 : 0) + (law.multi ? 0.5 : 0);
  measure(
      state, t, {law.name(), static_cast<double>(b.block.n), 8 * lanes},
      [&](const KernelTable& k) {
        b.restore();
        k.law[index](b.block, b.args);
      },
      copy);
  label_copy(state, copy);
}

void run_trial(benchmark::State& state, const KernelTable& t) {
  LawBlock b(true);
  const double copy = b.cost([&] { b.restore(); });
  const double lanes = 8 + 8 + 8 + 3 + 2.0 * (3 + b.bed.w.law_args.recall);
  measure(
      state, t, {"trial_linear", static_cast<double>(b.block.n), 8 * lanes},
      [&](const KernelTable& k) {
        b.restore();
        benchmark::DoNotOptimize(k.trial(b.block, b.args));
      },
      copy);
  label_copy(state, copy);
}

/// The scatter of a step: every block of the bed with the trial of its first one.
void run_scatter_limited(benchmark::State& state, const KernelTable& t, bool large) {
  BlockBuffers trial;
  double back = 0;
  {
    LawBlock law(true);  // holds the small bed's scratch
    back = select_kernels(Isa::automatic).trial(law.block, law.args);
    trial = law.run;
  }
  Bed& b = Bed::get(large);
  Touching touching(b);
  for (const auto& c : b.w.chunks)
    for (int q = 0; q < 3; ++q) grow(c->scratch->h[q], static_cast<std::size_t>(c->contact_end[2]) + 2 * k_pad);
  const double bytes = 8 + 2 * k_row8 * b.particles / b.contacts + 2 * 3 * 8;
  measure(state, t, {std::string("scatter_limited") + size_name(large), b.contacts, bytes}, [&](const KernelTable& k) {
    touching.blocks([&](Chunk& c, std::int64_t k0) {
      Scratch& s = *c.scratch;
      const int n = block_size(c, k0);
      const auto within = [&](std::int64_t q) { return static_cast<int>(std::clamp<std::int64_t>(q - k0, 0, n)); };
      k.scatter_limited({{s.f.data() - 8L * c.lo, s.ci.data() + k0, s.cj.data() + k0, n, within(c.contact_end[0]),
                          within(c.contact_end[1]), trial.r},
                         trial.t,
                         trial.g[3],
                         {s.h[0].data() + k0, s.h[1].data() + k0, s.h[2].data() + k0},
                         back});
    });
  });
}

struct MomentCase {
  const char* name;
  int rolling, twisting;
};

void run_moments(benchmark::State& state, const KernelTable& t, const MomentCase& c) {
  LawBlock b(true);
  const KernelTable& best = select_kernels(Isa::automatic);
  best.law[law_index(law_info(ContactModel::linear), true, false, false)](b.block, b.args);
  best.spin({b.bed.w.p.data(), b.bed.w.v.data(), b.chunk().scratch->ci.data(), b.chunk().scratch->cj.data(), b.block.n,
             b.kept.s});
  const auto restore = [&] {
    std::memcpy(b.run.s, b.kept.s, sizeof b.run.s);
    benchmark::ClobberMemory();
  };
  const double copy = b.cost(restore);
  alignas(64) static double slid[k_block + k_pad];
  std::fill_n(slid, k_block + k_pad, b.args.dt);
  MomentBlock m{};
  m.n = b.block.n;
  m.x = b.block.x;
  m.y = b.block.y;
  m.z = b.block.z;
  m.r = b.block.r;
  m.reff = b.block.reff;
  m.slid = slid;
  m.s = b.run.s;
  const int columns = (c.rolling == 2 ? 3 : 0) + c.twisting;
  std::memset(b.history, 0, sizeof b.history);
  for (int q = 0; q < k_max_moment; ++q) m.h[q] = b.history[q];
  MomentArgs args{};
  args.one = {0.3, 0.3, 0.2, 0.3, 0};
  args.dt = b.args.dt;
  args.rolling = c.rolling;
  args.twisting = c.twisting;
  args.centred = b.args.centred;
  measure(
      state, t, {c.name, static_cast<double>(m.n), 8.0 * (3 + 4 + 1 + 4 + 3 + 2 * columns)},
      [&](const KernelTable& k) {
        restore();
        k.moments(m, args);
      },
      copy);
  label_copy(state, copy);
}

void run_spin(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = Bed::get(large);
  Touching touching(b);
  BlockBuffers buffers;
  const double bytes = 8 + (k_row4 + k_row8) * b.particles / b.contacts;
  measure(state, t, {std::string("spin") + size_name(large), b.contacts, bytes}, [&](const KernelTable& k) {
    touching.blocks([&](const Chunk& c, std::int64_t k0) {
      k.spin({b.w.p.data(), b.w.v.data(), c.scratch->ci.data() + k0, c.scratch->cj.data() + k0, block_size(c, k0),
              buffers.s});
    });
  });
}

void run_cohesion(benchmark::State& state, const KernelTable& t) {
  LawBlock b(true);
  b.input_rows = 3;
  const double copy = b.cost([&] { b.restore(); });
  const CohesionArgs args{1e3, nullptr, b.bed.w.p.data(), b.chunk().scratch->ci.data(), b.chunk().scratch->cj.data(),
                          0};
  measure(
      state, t, {"cohesion_sjkr", static_cast<double>(b.block.n), 8.0 * (4 + 3 + 3) + 8},
      [&](const KernelTable& k) {
        b.restore();
        k.cohesion(b.block, args);
      },
      copy);
  label_copy(state, copy);
}

void run_narrow_adhesive(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = Bed::get(large);
  Touching touching(b);
  const double range[1] = {1e-30};  // nothing hangs: every call finds the contacts that it leaves
  const double bytes = 8.25 + k_row4 * b.particles / b.candidates;
  measure(state, t, {std::string("narrow_adhesive") + size_name(large), b.candidates, bytes},
          [&](const KernelTable& k) {
            for (const auto& c : b.w.chunks) {
              NarrowArgs a{};
              a.p = b.w.p.data();
              a.pi = c->pi.data();
              a.pj = c->pj.data();
              a.mask = c->mask.data();
              std::copy_n(c->end, 3, a.end);
              a.ci = c->scratch->ci.data();
              a.cj = c->scratch->cj.data();
              k.narrow_adhesive(a, {nullptr, 1, range});
            }
          });
}

/// Four columns, as rolling and twisting have them, over touching sets that have not changed: the usual case.
void run_carry(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = Bed::get(large);
  Touching touching(b);
  constexpr int columns = 4;
  for (const auto& c : b.w.chunks)
    for (auto& h : c->scratch->h) grow(h, static_cast<std::size_t>(c->contact_end[2]) + 2 * k_pad);
  const double bytes = 2.0 * columns * 8 + 0.25 * b.candidates / b.contacts;
  measure(state, t, {std::string("carry") + size_name(large), b.contacts, bytes}, [&](const KernelTable& k) {
    for (const auto& c : b.w.chunks) {
      CarryArgs a{};
      a.before = a.now = c->mask.data();
      a.slots = c->end[2];
      a.columns = columns;
      for (int q = 0; q < columns; ++q) {
        a.from[q] = c->h[q].data();
        a.to[q] = c->scratch->h[q].data();
      }
      k.carry(a);
    }
  });
  state.SetLabel("per contact, 4 columns");
}

/// A row of a kernel that runs on one block in L1, for every instruction set.
void add_block(const std::string& name, const std::function<void(benchmark::State&, const KernelTable&)>& run) {
  for (const Isa isa : available_isas())
    add(name, select_kernels(isa), false, [run](benchmark::State& s, const KernelTable& t, bool) { run(s, t); });
}

}  // namespace

void register_laws() {
  for (const ContactModel model : {ContactModel::linear, ContactModel::hertz_mindlin, ContactModel::jkr})
    for (const bool energy : {false, true})
      for (const bool multi : {false, true})
        for (const bool friction : {true, false}) {
          const LawCase law{model, friction, multi, energy};
          add_block(law.name(), [law](benchmark::State& s, const KernelTable& t) { run_law(s, t, law); });
        }
  add_block("trial_linear", run_trial);
  add_kernel("scatter_limited", run_scatter_limited);
  for (const MomentCase c : {MomentCase{"moments_cdt", 1, 0}, {"moments_epsd", 2, 0}, {"moments_epsd_twisting", 2, 1}})
    add_block(c.name, [c](benchmark::State& s, const KernelTable& t) { run_moments(s, t, c); });
  add_kernel("spin", run_spin);
  add_block("cohesion_sjkr", run_cohesion);
  add_kernel("narrow_adhesive", run_narrow_adhesive);
  add_kernel("carry", run_carry);
}

}  // namespace talus::perf
