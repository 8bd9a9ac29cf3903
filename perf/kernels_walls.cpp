// Rows of the walls: candidates (part of a rebuild), exact contacts (geometry) and the whole wall_contact node, for a
// plane, a cylinder, a cone and a mesh, with up to 4096 grains that touch the wall. Who calls it: perf/kernels.cpp.
// Wall geometry is scalar code of core/ (no instruction-set variants); the node runs the contact law of each.
#include "perf/bed.hpp"
#include "perf/kernels_measure.hpp"

namespace talus::perf {

namespace {

World& wall_world(const WallCase& c) {
  static std::map<std::string, std::unique_ptr<Simulation>> worlds;
  auto& sim = worlds[c.name];
  if (!sim) sim = make_wall_world(c);
  return EngineAccess::world(*sim);
}

Vec3 centre(const World& w, Row i) { return {w.rows.p[4L * i], w.rows.p[4L * i + 1], w.rows.p[4L * i + 2]}; }

void run_candidates(benchmark::State& state, const KernelTable& t, const WallCase& c) {
  World& w = wall_world(c);
  std::vector<std::int32_t> found;
  measure(state, t, {"wall_candidates", static_cast<double>(w.rows.n), 0, false}, [&](const KernelTable&) {
    found.clear();
    for (Row i = 0; i < w.rows.n; ++i)
      w.walls.candidates(centre(w, i), w.rows.p[4L * i + 3] + __builtin_sqrt(w.lists.x0[4L * i + 3]), found);
    benchmark::DoNotOptimize(found.data());
  });
  state.SetLabel("per grain, " + std::to_string(static_cast<double>(found.size()) / w.rows.n) + " elements found");
}

/// Candidates of all chunks in the order of the node.
template <class F>
void for_rows(const World& w, F fn) {
  for (const auto& c : w.contacts.chunks)
    for (std::size_t q = 0; q + 1 < c->wall.begin.size(); ++q)
      fn(c->wall.row[q],
         std::span<const std::int32_t>(c->wall.element.data() + c->wall.begin[q],
                                       static_cast<std::size_t>(c->wall.begin[q + 1] - c->wall.begin[q])));
}

void run_contacts(benchmark::State& state, const KernelTable& t, const WallCase& c) {
  const World& w = wall_world(c);
  WallContact found[WallSet::k_max_contacts];
  double candidates = 0, touching = 0;
  for_rows(w, [&](Row i, auto elements) {
    candidates += static_cast<double>(elements.size());
    touching += w.walls.contacts(centre(w, i), w.rows.p[4L * i + 3], elements, found);
  });
  measure(state, t, {"wall_contacts", candidates, 0, false}, [&](const KernelTable&) {
    for_rows(w, [&](Row i, auto elements) {
      benchmark::DoNotOptimize(w.walls.contacts(centre(w, i), w.rows.p[4L * i + 3], elements, found));
    });
  });
  state.SetLabel("per candidate, touching: " + std::to_string(touching / candidates));
}

void run_node(benchmark::State& state, const KernelTable& t, const WallCase& c) {
  World& w = wall_world(c);
  Nodes nodes(w);
  double contacts = 0;
  for (const auto& chunk : w.contacts.chunks) {
    nodes.narrow(*chunk);
    nodes.force(*chunk);
    contacts += static_cast<double>(chunk->wall.state.size());
  }
  measure(state, t, {std::string("wall_contact") + c.name, contacts, 0}, [&](const KernelTable& k) {
    nodes.rules.kernels = &k;
    for (const auto& chunk : w.contacts.chunks) nodes.walls(*chunk);
  });
  for (const auto& chunk : w.contacts.chunks) nodes.give_back(*chunk);
  state.SetLabel("per wall contact; flops of the law alone");
}

}  // namespace

void register_walls() {
  for (const WallCase& c : k_wall_cases) {
    const std::string name = c.name;
    const auto row = [&c, &name](const char* what, auto run) {
      benchmark::RegisterBenchmark((what + ("_" + name) + "/core/4k").c_str(),
                                   [run, &c](benchmark::State& s) { run(s, select_kernels(Isa::automatic), c); });
    };
    row("wall_candidates", run_candidates);
    if (c.offset > 1) continue;  // far from the wall: no candidates
    row("wall_contacts", run_contacts);
    for (const Isa isa : available_isas())
      add("wall_contact_" + name, select_kernels(isa), false,
          [&c](benchmark::State& s, const KernelTable& t, bool) { run_node(s, t, c); });
  }
}

}  // namespace talus::perf
