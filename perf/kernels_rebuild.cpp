// Rows of a rebuild: skins, cell keys, sort, sorted float columns, pair search, history carry-over; and the sort epoch.
// Who calls it: perf/kernels.cpp. Every row runs a whole rebuild of the unchanged bed and is charged one part of it, as
// the engine's own part clock sees it (wall time: measure on an idle core).
#include "perf/bed.hpp"
#include "perf/kernels_measure.hpp"

namespace talus::perf {

namespace {

double part_ns(const World& w, RebuildPart part) {
  const auto k = static_cast<std::size_t>(part);
  double seconds = w.lists.seconds[k];
  for (const auto& c : w.contacts.chunks) seconds += c->rebuild_seconds[k];
  return 1e9 * seconds;
}

struct PartCase {
  RebuildPart part;
  const char* name;
  double bytes;  ///< per grain, without lists
  bool kernel;   ///< depends on the instruction set
};
// skin: P, V, V2 in, X0 and reach out. keys: P, reach in, cell and place out, cell counts in and out. sort: cell counts
// in and out. fill: P, reach, cell, place in; four floats and a row out
constexpr PartCase k_parts[] = {{RebuildPart::skin, "rebuild_skin", 32 + 64 + 64 + 32 + 4, false},
                                {RebuildPart::keys, "rebuild_keys", 32 + 4 + 8 + 4, false},
                                {RebuildPart::sort, "rebuild_sort", 4, false},
                                {RebuildPart::fill, "rebuild_fill", 32 + 4 + 8 + 20, false},
                                {RebuildPart::search, "rebuild_search", 32 + 4 + 20, true},
                                {RebuildPart::history, "rebuild_history", 0, false}};

void run_part(benchmark::State& state, const KernelTable& t, bool large, const PartCase& p) {
  Bed& b = Bed::get(large);
  World& w = b.w;
  double bytes = p.bytes;
  if (p.part == RebuildPart::search) bytes += 8 * b.candidates / b.particles;  // pairs out
  if (p.part == RebuildPart::history)  // pairs copied, mask written, touching pairs and the history read and written
    bytes +=
        (16 + 0.125) * b.candidates / b.particles + (16 + 16 * w.rules.has.history_columns) * b.contacts / b.particles;
  const auto body = [&](const KernelTable& k) {
    b.nodes.rules.kernels = &k;
    const double before = part_ns(w, p.part);
    b.nodes.rebuild();
    return part_ns(w, p.part) - before;
  };
  measure(state, t, {std::string(p.name) + size_name(large), b.particles, bytes, p.kernel}, body);
  state.SetLabel("per grain, " + std::to_string(b.candidates / b.particles) + " pairs found");
}

void run_rebuild(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = Bed::get(large);
  const double bytes = 196 + 48 + 4 + 64 + 56 + 24 * b.candidates / b.particles +
                       (16 + 16 * b.w.rules.has.history_columns) * b.contacts / b.particles;
  measure(state, t, {std::string("rebuild") + size_name(large), b.particles, bytes}, [&](const KernelTable& k) {
    b.nodes.rules.kernels = &k;
    b.nodes.rebuild();
  });
  state.SetLabel("per grain, all parts");
}

/// The permutation into Morton order alone; the rebuild that follows it in a run is not charged here.
void run_sort_epoch(benchmark::State& state, const KernelTable& t, bool large) {
  Bed& b = Bed::get(large);
  measure(state, t, {"sort_epoch", b.particles, 4 * 96 + 2 * 8, false}, [&](const KernelTable& k) {
    b.nodes.rules.kernels = &k;
    World& w = b.w;
    const double begin = wall_ns();
    sort_epoch(w.rules, w.rows, w.contacts, w.lists, w.counters, w.team);
    const double ns = wall_ns() - begin;
    b.nodes.rebuild();
    return ns;
  });
  b.w.rows.velocity_at_old_step = true;
}

}  // namespace

void register_rebuild() {
  for (const PartCase& p : k_parts) {
    const auto run = [&p](benchmark::State& s, const KernelTable& t, bool large) { run_part(s, t, large, p); };
    p.kernel ? add_kernel(p.name, run) : add_core(p.name, run);
  }
  add_kernel("rebuild", run_rebuild);
  add_core("sort_epoch", run_sort_epoch);
}

}  // namespace talus::perf
