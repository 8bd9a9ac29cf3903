// What a chunk node writes is what the step table says it writes, and only of its own chunk (I7): every array is looked
// at before and after every execution of every node. The steps taken so are those of a run.
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <set>

#include "scheduler/step/access.hpp"
#include "scheduler/step/step.hpp"
#include "tests/determinism/scenes.hpp"

namespace talus::determinism {
namespace {

/// FNV-1a of the bytes of each array, by its name in the table and chunk.
class Arrays {
 public:
  explicit Arrays(const World& w) : w_(w) {
    for (int k = 0; k < w.contacts.count(); ++k) {
      add_rows(k);
      add_chunk(k);
    }
  }
  /// Names and chunks of what differs.
  std::vector<std::pair<std::string, int>> changed_since(const Arrays& before) const {
    std::vector<std::pair<std::string, int>> found;
    for (const auto& [key, hash] : hash_) {
      const auto old = before.hash_.find(key);
      if (old == before.hash_.end() || old->second != hash) found.push_back(key);
    }
    return found;
  }

 private:
  void add(const std::string& name, int chunk, const void* data, std::size_t bytes) {
    std::uint64_t& h = hash_.try_emplace({name, chunk}, 0xcbf29ce484222325U).first->second;
    const auto* at = static_cast<const unsigned char*>(data);
    for (std::size_t k = 0; k < bytes; ++k) h = (h ^ at[k]) * 0x100000001b3U;
  }
  template <class T>
  void add_all(const std::string& name, int chunk, const T& column) {
    add(name, chunk, column.data(), column.size() * sizeof column[0]);
  }
  void add_rows(int k) {
    static const std::map<std::string, std::pair<std::string, std::string>> names{
        {"position", {"p", "p2"}},
        {"velocity", {"v", "v2"}},
        {"energy", {"energy rows", ""}},
        {"tracer", {"tracer", "next tracer"}}};
    const Chunk& c = w_.contacts[k];
    for (const Columns::Entry& e : w_.rows.columns.all()) {
      if (!e.info.in) continue;
      const auto known = names.find(e.info.name);
      const std::size_t from = e.bytes * static_cast<std::size_t>(c.lo),
                        n = e.bytes * static_cast<std::size_t>(c.hi - c.lo);
      add(known != names.end() ? known->second.first : e.info.name, k, e.data() + from, n);
      if (e.spare != nullptr) add(known->second.second, k, e.data_of(e.spare) + from, n);
    }
  }
  void add_chunk(int k) {
    const Chunk& c = w_.contacts[k];
    add("list", k, c.list.pi.data(), static_cast<std::size_t>(c.list.end[2]) * sizeof(Row));
    add("list", k, c.list.pj.data(), static_cast<std::size_t>(c.list.end[2]) * sizeof(Row));
    add("mask", k, c.list.mask.data(), static_cast<std::size_t>(c.list.end[2] / 8));
    add("contacts", k, c.contacts.end, sizeof c.contacts.end);
    for (int q = 0; q < w_.rules.has.history_columns; ++q) add_all("history", k, c.contacts.h[q]);
    add_all("wall candidates", k, c.wall.row);
    add_all("wall candidates", k, c.wall.element);
    for (const WallState& s : c.wall.state) {
      add("wall history", k, &s.row, sizeof s.row);
      add("wall history", k, s.h, sizeof s.h);
    }
    add_all("wall history", k, c.wall.moment);
    for (const Crossing& x : c.crossings) add("crossings", k, &x, sizeof x);
    add("results", k, &c.result.out_count, sizeof c.result.out_count);
    add("results", k, &c.result.expired, sizeof c.result.expired);
    if (c.scratch != nullptr)
      add("force rows", k, c.scratch->f.data(),
          std::min(c.scratch->f.size(),
                   static_cast<std::size_t>(w_.rows.stride) * static_cast<std::size_t>(c.hi - c.lo)) *
              sizeof(double));
    else
      add("force rows", k, nullptr, 0);
  }

  const World& w_;
  std::map<std::pair<std::string, int>, std::uint64_t> hash_;
};

bool declares(const NodeSpec& n, const std::string& array) {
  for (const Access& a : n.writes)
    if (a.array == array) return true;
  return false;
}

/// One step, node after node and chunk after chunk; what has been seen to be written is added to `seen`.
void looked_step(World& w, const std::vector<NodeSpec>& table, std::set<std::string>& seen) {
  const auto run = [&](Phase phase) {
    for (const NodeSpec& n : table)
      if (n.in && n.phase == phase && (n.id != Node::sort_epoch || w.clock.step % w.rules.scene.sort_every == 0))
        run_node(w, n, w.contacts[0]);
  };
  w.clock.target = w.clock.step + 1;
  w.team.shares.prepare(w.contacts.count(), 1);
  run(Phase::decide);
  if (w.clock.rebuild) {
    run(Phase::insert);
    run(Phase::lists);
  }
  for (int k = 0; k < w.contacts.count(); ++k)
    for (const NodeSpec& n : table) {
      if (!n.in || n.phase != Phase::chunk) continue;
      const Arrays before(w);
      const bool had_scratch = w.contacts[k].scratch != nullptr;
      run_node(w, n, w.contacts[k]);
      for (const auto& [array, chunk] : Arrays(w).changed_since(before)) {
        EXPECT_EQ(chunk, k) << n.name << " writes " << array << " of another chunk";
        const bool scratch_came_or_went = array == "force rows" && had_scratch != (w.contacts[k].scratch != nullptr);
        EXPECT_TRUE(declares(n, array) || scratch_came_or_went) << n.name << " writes " << array << " undeclared";
        seen.insert(n.name + ": " + array);
      }
    }
  finish_step(w, table);
}

TEST(StepTable, ChunkNodesWriteWhatTheyDeclareAndOnlyTheirOwnChunk) {
  std::set<std::string> seen;
  for (Scene (*build)() : {hopper, sticky_drum, pile_on_mesh}) {
    Scene s = build();
    s.tracer_rate = 0.001 / s.dt;
    for (std::size_t k = 0; k < s.sources.size(); ++k) s.sources[k].tracer = static_cast<double>(k);
    s.output.flux_planes = {{"middle", 0.5 * (s.domain.lower + s.domain.upper), {0, 0, 1}}};
    RunOptions o;
    o.threads = 1;
    o.chunk = 150;
    Simulation looked(s, o), plain(s, o);
    looked.run(1200);
    plain.run(1206);
    World& w = EngineAccess::world(looked);
    const std::vector<NodeSpec> table = step_table(w);
    for (int k = 0; k < 6; ++k) looked_step(w, table, seen);
    EXPECT_FALSE(w.team.failure.any());
    EXPECT_EQ(looked.state_hash(), plain.state_hash()) << s.title << ": these were the steps of a run";
  }
  for (const char* what : {"narrow_phase: mask", "contact_force: history", "contact_force: force rows",
                           "contact_force: energy rows", "wall_contact: wall history", "integrate: p2", "integrate: v2",
                           "tracer_mixing: next tracer", "tracer_rate: next tracer"})
    EXPECT_TRUE(seen.contains(what)) << "never seen: " << what;
}

}  // namespace
}  // namespace talus::determinism
