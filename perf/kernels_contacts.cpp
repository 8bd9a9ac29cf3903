// Rows of the per-step kernels: narrow phase, gather, contact laws, scatter, integration, displacement check. Who calls
// it: perf/kernels.cpp. In-place rows (narrow, contact_force, integrate, step) run the three nodes of each chunk back
// to back as a step does, on the state after the last step, and charge each row its own node; gather, law and scatter
// are also run alone.
#include <algorithm>
#include <cstring>

#include "perf/bed.hpp"
#include "perf/kernels_measure.hpp"

namespace talus::perf {

namespace {

enum class Part { narrow, force, integrate, all };

/// One step of all chunks without advancing it; ns (and operations, where they count) of the parts asked for.
double step_once(World& w, const KernelTable& t, Part part) {
  w.kernels = &t;
  double ns = 0;
  Operations kept;
  const auto timed = [&](Part one, void (*node)(World&, Chunk&), Chunk& c) {
    operations() = {};
    const double begin = wall_ns();
    node(w, c);
    const double end = wall_ns();
    if (part != one && part != Part::all) return;
    ns += end - begin;
    kept.flops += operations().flops;
    kept.divisions += operations().divisions;
    kept.roots += operations().roots;
  };
  for (const auto& c : w.chunks) {
    timed(Part::narrow, narrow_chunk, *c);
    timed(Part::force, force_chunk, *c);
    timed(Part::integrate, integrate_chunk, *c);
  }
  operations() = kept;
  return ns;
}

/// Bytes per grain of the arrays that a step streams: rows P, V, X0 in, P2, V2 out, the pair list and its mask in and
/// out, the history in and out. Force rows and contact indices stay in the chunk's cache.
struct Traffic {
  double lists, history;
  explicit Traffic(const Bed& b)
      : lists((8 + 0.25) * b.candidates / b.particles),
        history(16.0 * b.w.has.history_columns * b.contacts / b.particles) {}
};
constexpr double k_row4 = 32, k_row8 = 64;

void run_part(benchmark::State& state, const KernelTable& t, bool large, Part part, const char* name) {
  Bed& b = Bed::get(large);
  const Traffic traffic(b);
  double elements = b.particles, bytes = 0;  // per grain
  if (part == Part::narrow || part == Part::all) bytes += k_row4 + traffic.lists + traffic.history;
  if (part == Part::force || part == Part::all) bytes += k_row8;
  if (part == Part::integrate || part == Part::all) bytes += 2 * k_row4 + k_row8;
  if (part == Part::narrow) elements = b.candidates;
  if (part == Part::force) elements = b.contacts;
  const Work work{std::string(name) + size_name(large), elements, bytes * b.particles / elements};
  measure(state, t, work, [&](const KernelTable& k) { return step_once(b.w, k, part); });
  state.SetLabel("per " +
                 std::string(part == Part::narrow  ? "candidate, "
                             : part == Part::force ? "contact, "
                                                   : "grain, ") +
                 std::to_string(b.candidates / b.particles) + " candidates, " +
                 std::to_string(b.contacts / b.particles) + " contacts per grain");
}

/// All chunks with their contacts in scratch, as between narrow phase and contact forces.
class Touching {
 public:
  explicit Touching(Bed& b) : b_(b) {
    b.w.kernels = &select_kernels(Isa::automatic);
    for (const auto& c : b.w.chunks) {
      narrow_chunk(b.w, *c);
      force_chunk(b.w, *c);  // sizes the force rows
    }
  }
  ~Touching() {
    for (const auto& c : b_.w.chunks) {
      b_.w.scratch.give(c->scratch);
      c->scratch = nullptr;
    }
  }
  Touching(const Touching&) = delete;
  Touching& operator=(const Touching&) = delete;
  /// fn(chunk, first contact) for every block.
  template <class F>
  void blocks(F fn) {
    for (const auto& c : b_.w.chunks)
      for (std::int64_t k0 = 0; k0 < c->contact_end[2]; k0 += k_block) fn(*c, k0);
  }

 private:
  Bed& b_;
};

int block_size(const Chunk& c, std::int64_t k0) {
  return static_cast<int>(std::min<std::int64_t>(k_block, c.contact_end[2] - k0));
}

GatherArgs gather_args(const World& w, const Chunk& c, std::int64_t k0, BlockBuffers& buffers) {
  GatherArgs g{};
  g.v = w.v.data();
  g.p = w.p.data();
  g.i = c.scratch->ci.data() + k0;
  g.j = c.scratch->cj.data() + k0;
  g.n = block_size(c, k0);
  g.x = buffers.x;
  g.r = buffers.r;
  g.g = buffers.g;
  for (double& half : g.half) half = 1e300;
  g.next_j = g.j + k_block;
  g.next_n = static_cast<int>(std::clamp<std::int64_t>(c.contact_end[2] - k0 - k_block, 0, g.n));
  return g;
}

void run_gather(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = Bed::get(large);
  Touching touching(b);
  BlockBuffers buffers;
  const double bytes = 8 + (k_row4 + k_row8) * b.particles / b.contacts;
  measure(state, t, {std::string("gather") + size_name(large), b.contacts, bytes}, [&](const KernelTable& k) {
    touching.blocks([&](const Chunk& c, std::int64_t k0) {
      GatherArgs args = gather_args(b.w, c, k0, buffers);
      k.gather[1](args);
    });
  });
}

void run_scatter(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = Bed::get(large);
  Touching touching(b);
  BlockBuffers buffers;
  std::memset(buffers.r, 0, sizeof buffers.r);
  const double bytes = 8 + 2 * k_row8 * b.particles / b.contacts;
  measure(state, t, {std::string("scatter") + size_name(large), b.contacts, bytes}, [&](const KernelTable& k) {
    touching.blocks([&](Chunk& c, std::int64_t k0) {
      const int n = block_size(c, k0);
      double* f = c.scratch->f.data() - 8L * c.lo;
      const auto within = [&](std::int64_t q) { return static_cast<int>(std::clamp<std::int64_t>(q - k0, 0, n)); };
      k.scatter[1](ScatterArgs{f, c.scratch->ci.data() + k0, c.scratch->cj.data() + k0, n, within(c.contact_end[0]),
                               within(c.contact_end[1]), buffers.r});
    });
  });
}

struct LawCase {
  ContactModel model;
  bool friction, multi, energy;
  std::string name() const {
    return std::string("law_") + law_info(model).name + (friction ? "" : "_frictionless") + (multi ? "_multi" : "") +
           (energy ? "_energy" : "");
  }
};

/// A law on one block of real contacts in L1, over and over. It works in place: its input is put back from a copy, the
/// copy is timed alone and taken off.
void run_law(benchmark::State& state, const KernelTable& t, const LawCase& law) {
  Bed& b = Bed::get(false);
  Touching touching(b);
  const LawInfo& info = law_info(law.model);
  BlockBuffers run, kept;
  const Chunk& c = *b.w.chunks[0];
  GatherArgs gather = gather_args(b.w, c, 0, kept);
  select_kernels(Isa::automatic).gather[1](gather);
  if (!law.friction)
    std::memcpy(kept.r[3], kept.r[7], sizeof kept.r[7]);  // without rotation 1/m_i + 1/m_j is in lane 3
  std::memcpy(run.x, kept.x, sizeof run.x);
  std::memcpy(run.g, kept.g, sizeof run.g);
  std::fill(run.reff, run.reff + k_block, 0.25);
  alignas(64) double history[k_max_history][k_block + k_pad] = {};
  for (int k = 0; k < std::min(k_max_history, b.w.has.history_columns); ++k)
    std::copy_n(c.h[k].data(), k_block, history[k]);
  Block block{};
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
  LawArgs args = b.w.law_args;
  if (info.wants_reff) args.one = {1e7, 1e7, 0.3, 0.2, 0.5};  // 4/3 E*, 8 G*, alpha: grains of reduced units
  const PairParameters table[1] = {args.one};
  args.table = table;
  const std::size_t bytes = sizeof run.r[0] * (law.friction ? 8 : 4);
  const auto restore = [&] {
    std::memcpy(run.r, kept.r, bytes);
    benchmark::ClobberMemory();
  };
  constexpr int repeats = 20000;
  const double begin = now_ns();
  for (int k = 0; k < repeats; ++k) restore();
  const double copy = (now_ns() - begin) / repeats / block.n;
  const int index = law_index(info, law.friction, law.multi, law.energy);
  // in: distance and what follows from it, motion, history; out: force rows, history, energies. All of it in L1
  const double lanes = 8 + (law.friction ? 8 + 7 : 4 + 4) +
                       2.0 * ((law.friction ? info.history : 0) + b.w.law_args.recall) + (info.wants_reff ? 1 : 0) +
                       (law.energy ? 3 : 0) + (law.multi ? 0.5 : 0);
  measure(
      state, t, {law.name(), static_cast<double>(block.n), 8 * lanes},
      [&](const KernelTable& k) {
        restore();
        k.law[index](block, args);
      },
      copy);
  state.SetLabel("copy taken off: " + std::to_string(copy) + " ns");
}

void run_damped(benchmark::State& state, const KernelTable& t, bool large) {
  World& w = Bed::get(large).w;
  w.scene.viscous_damping = 1e-9;
  run_part(state, t, large, Part::integrate, "integrate_damped");
  w.scene.viscous_damping = 0;
}

/// The check itself is fused into integrate; this is the node that reads the chunks' flags, per chunk.
void run_check(benchmark::State& state, const KernelTable& t, bool large) {
  World& w = Bed::get(large).w;
  step_once(w, t, Part::all);
  for (const auto& c : w.chunks) c->out_count = 0;  // of a step that did not happen
  measure(state, t, {"check", static_cast<double>(w.chunks.size()), 0, false},
          [&](const KernelTable&) { benchmark::DoNotOptimize(check_step(w, w.step + 1)); });
  state.SetLabel("per step and chunk");
}

}  // namespace

void register_contacts() {
  const auto part = [](Part p, const char* name) {
    add_kernel(name,
               [p, name](benchmark::State& s, const KernelTable& t, bool large) { run_part(s, t, large, p, name); });
  };
  part(Part::narrow, "narrow");
  add_kernel("gather", run_gather);
  for (const ContactModel model : {ContactModel::linear, ContactModel::hertz_mindlin})
    for (const bool energy : {false, true})
      for (const bool multi : {false, true})
        for (const bool friction : {true, false}) {
          const LawCase law{model, friction, multi, energy};
          for (const Isa isa : available_isas())
            add(law.name(), select_kernels(isa), false,
                [law](benchmark::State& s, const KernelTable& t, bool) { run_law(s, t, law); });
        }
  add_kernel("scatter", run_scatter);
  part(Part::force, "contact_force");
  part(Part::integrate, "integrate");
  add_kernel("integrate_damped", run_damped);
  part(Part::all, "step");
  add_core("displacement_check", run_check);
}

}  // namespace talus::perf
