// Rows of the per-step kernels: narrow phase, gather, scatter, integration, displacement check. Who calls it:
// perf/kernels.cpp. In-place rows (narrow, contact_force, integrate, step) run the three nodes of each chunk back to
// back as a step does, on the state after the last step, and charge each row its own node; gather and scatter are also
// run alone. Laws and what is added to them: kernels_laws.cpp.
#include <algorithm>
#include <cstring>

#include "perf/kernels_measure.hpp"
#include "perf/touching.hpp"
#include "scheduler/step/step.hpp"

namespace talus::perf {

namespace {

enum class Part { narrow, force, integrate, all };

/// One step of all chunks without advancing it; ns (and operations, where they count) of the parts asked for.
double step_once(Bed& b, const KernelTable& t, Part part) {
  b.nodes.rules.kernels = &t;
  double ns = 0;
  Operations kept;
  const auto timed = [&](Part one, void (Nodes::*node)(Chunk&), Chunk& c) {
    operations() = {};
    const double begin = wall_ns();
    (b.nodes.*node)(c);
    const double end = wall_ns();
    if (part != one && part != Part::all) return;
    ns += end - begin;
    kept.flops += operations().flops;
    kept.divisions += operations().divisions;
    kept.roots += operations().roots;
  };
  for (const auto& c : b.w.contacts.chunks) {
    timed(Part::narrow, &Nodes::narrow, *c);
    timed(Part::force, &Nodes::force, *c);
    timed(Part::integrate, &Nodes::integrate, *c);
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
        history(16.0 * b.w.rules.has.history_columns * b.contacts / b.particles) {}
};
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
  measure(state, t, work, [&](const KernelTable& k) { return step_once(b, k, part); });
  state.SetLabel("per " +
                 std::string(part == Part::narrow  ? "candidate, "
                             : part == Part::force ? "contact, "
                                                   : "grain, ") +
                 std::to_string(b.candidates / b.particles) + " candidates, " +
                 std::to_string(b.contacts / b.particles) + " contacts per grain");
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
      k.scatter[1](ScatterArgs{f, c.scratch->ci.data() + k0, c.scratch->cj.data() + k0, n, within(c.contacts.end[0]),
                               within(c.contacts.end[1]), buffers.r});
    });
  });
}

void run_damped(benchmark::State& state, const KernelTable& t, bool large) {
  Rules& rules = Bed::get(large).nodes.rules;
  rules.scene.viscous_damping = 1e-9;
  run_part(state, t, large, Part::integrate, "integrate_damped");
  rules.scene.viscous_damping = 0;
}

/// The check itself is fused into integrate; this is the node that reads the chunks' flags, per chunk.
void run_check(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = Bed::get(large);
  World& w = b.w;
  step_once(b, t, Part::all);
  w.clock.target = w.clock.step + 1;
  for (const auto& c : w.contacts.chunks) c->result.out_count = 0;  // of a step that did not happen
  measure(state, t, {"check", static_cast<double>(w.contacts.chunks.size()), 0, false},
          [&](const KernelTable&) { check_step(w); });
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
  add_kernel("scatter", run_scatter);
  part(Part::force, "contact_force");
  part(Part::integrate, "integrate");
  add_kernel("integrate_damped", run_damped);
  part(Part::all, "step");
  add_core("displacement_check", run_check);
}

}  // namespace talus::perf
