// The step table: two unordered nodes never share a written array (I7), and what derives from the table says the same.
#include <gtest/gtest.h>

#include <set>

#include "scheduler/step/access.hpp"
#include "scheduler/step/step.hpp"
#include "tests/determinism/scenes.hpp"

namespace talus::determinism {
namespace {

const Access* find(const std::vector<Access>& all, const std::string& array) {
  for (const Access& a : all)
    if (a.array == array) return &a;
  return nullptr;
}

/// Unordered are chunk nodes of different chunks: what one writes is its own rows', and no other reaches beyond them.
std::vector<std::string> conflicts(const std::vector<NodeSpec>& table) {
  std::vector<std::string> found;
  for (const NodeSpec& writer : table) {
    if (!writer.in || writer.phase != Phase::chunk) continue;
    for (const Access& w : writer.writes) {
      if (w.all) found.push_back(writer.name + " writes " + w.array + " of other chunks");
      for (const NodeSpec& other : table) {
        if (!other.in || other.phase != Phase::chunk) continue;
        for (const auto* accesses : {&other.reads, &other.writes})
          if (const Access* a = find(*accesses, w.array); a != nullptr && a->all)
            found.push_back(other.name + " reaches " + w.array + ", which " + writer.name + " writes");
      }
    }
  }
  return found;
}

TEST(StepTable, UnorderedNodesNeverShareAWrittenArray) {
  for (const NamedScene& named : scenes()) {
    Scene s = named.build();
    s.tracer_rate = 0;
    s.output.flux_planes = {{"middle", {0, 0, 0}, {0, 0, 1}}};
    Simulation sim(s, RunOptions{});
    const std::vector<std::string> found = conflicts(step_table(EngineAccess::world(sim)));
    EXPECT_TRUE(found.empty()) << named.name << ": " << (found.empty() ? "" : found.front());
  }
}

// The check can fail: with any one declaration turned into a forbidden one it does.
TEST(StepTable, CheckSeesAForbiddenAccess) {
  Simulation sim(hopper(), RunOptions{});
  const std::vector<NodeSpec> table = step_table(EngineAccess::world(sim));
  int tried = 0;
  for (std::size_t n = 0; n < table.size(); ++n) {
    if (!table[n].in || table[n].phase != Phase::chunk) continue;
    for (std::size_t k = 0; k < table[n].writes.size(); ++k, ++tried) {
      std::vector<NodeSpec> broken = table;
      broken[n].writes[k].all = true;
      EXPECT_FALSE(conflicts(broken).empty()) << table[n].name << " " << table[n].writes[k].array;
    }
  }
  EXPECT_GT(tried, 10);
}

TEST(StepTable, NamesAndNumbersAreUniqueAndProfileFollowsThem) {
  Scene s = hopper();
  s.tracer_rate = 0;
  Simulation sim(s, RunOptions{});
  sim.run(3);
  std::set<std::string> names;
  std::set<int> numbers;
  std::set<std::string> in;
  for (const NodeSpec& n : step_table(EngineAccess::world(sim))) {
    EXPECT_TRUE(names.insert(n.name).second) << n.name;
    EXPECT_TRUE(numbers.insert(static_cast<int>(n.id)).second) << n.name;
    EXPECT_LT(static_cast<int>(n.id), k_most_nodes);
    EXPECT_FALSE(n.why.empty()) << n.name;
    if (n.in) in.insert(n.name);
  }
  for (const NodeTime& t : sim.profile().nodes) EXPECT_TRUE(in.contains(t.node)) << t.node;
  for (const auto& n : sim.plan().nodes) EXPECT_TRUE(names.contains(n.name)) << n.name;
}

// The column registry: what a column is said to need is what it gets.
TEST(ColumnRegistry, NewRowsAreDeadAndSavedColumnsComeBack) {
  Simulation sim(hertz_drum(), RunOptions{});
  World& w = EngineAccess::world(sim);
  const Row n = w.rows.n;
  for (const Columns::Entry& e : w.rows.columns.all()) {
    if (!e.info.in) continue;
    EXPECT_GE(e.bytes_of(e.column), e.bytes * static_cast<std::size_t>(n + 1)) << e.info.name;
    EXPECT_FALSE(e.info.why.empty()) << e.info.name;
    EXPECT_TRUE(e.info.dead.size() == 1 || e.info.dead.size() == static_cast<std::size_t>(e.info.width)) << e.info.name;
  }
  EXPECT_GE(w.rows.p[4L * n], k_gone) << "the row behind the last one is dead";
  EXPECT_EQ(w.rows.id[static_cast<std::size_t>(n)], -1);
}

}  // namespace
}  // namespace talus::determinism
