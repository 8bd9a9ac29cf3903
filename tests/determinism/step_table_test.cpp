// The step table: two unordered nodes never share a written array (I7), and what derives from the table says the same.
#include <gtest/gtest.h>

#include <algorithm>
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
    s = heated(s);
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

/// A column whose values tell id and place.
template <class T>
struct Marked {
  Column<T> column;
  ColumnInfo info;
  Marked(World& w, const char* name, int width) {
    info.name = name;
    info.why = "test";
    info.width = width;
    w.rows.columns.add(info, column);
  }
  T value(ParticleId id, int k) const { return static_cast<T>(7 * id + k); }
  void set(const Rows& rows) {
    for (Row i = 0; i < rows.n; ++i)
      for (int k = 0; k < info.width; ++k) column[at(i, k)] = value(rows.id[static_cast<std::size_t>(i)], k);
  }
  int wrong(const Rows& rows) const {
    int n = 0;
    for (Row i = 0; i < rows.n; ++i)
      for (int k = 0; k < info.width && rows.is_alive(i); ++k)
        n += column[at(i, k)] == value(rows.id[static_cast<std::size_t>(i)], k) ? 0 : 1;
    return n;
  }
  std::size_t at(Row i, int k) const { return static_cast<std::size_t>(info.width) * static_cast<std::size_t>(i) + k; }
};

// As many columns as one likes, of any width, go with their rows: also those that do not fit into the buffer together.
TEST(ColumnRegistry, ColumnsOfAnyNumberAndWidthFollowTheirRowsThroughSortEpochs) {
  RunOptions o;
  o.threads = 2;
  o.chunk = 64;
  Simulation sim(sheared_bed(), o);
  World& w = EngineAccess::world(sim);
  Marked<std::int32_t> three(w, "three", 3);
  Marked<double> six(w, "six", 6), one(w, "one", 1), four(w, "four", 4);
  Marked<std::uint8_t> byte(w, "byte", 1), five(w, "five", 5);
  set_particle_capacity(w.rows, w.rows.n);
  three.set(w.rows), six.set(w.rows), one.set(w.rows), four.set(w.rows), byte.set(w.rows), five.set(w.rows);
  const std::vector<ParticleId> before(w.rows.id.begin(), w.rows.id.begin() + w.rows.n);
  sim.run(k_sort_every + 100);
  EXPECT_FALSE(std::equal(before.begin(), before.end(), w.rows.id.begin())) << "rows have changed places";
  EXPECT_EQ(three.wrong(w.rows), 0);
  EXPECT_EQ(six.wrong(w.rows), 0);
  EXPECT_EQ(one.wrong(w.rows), 0);
  EXPECT_EQ(four.wrong(w.rows), 0);
  EXPECT_EQ(byte.wrong(w.rows), 0);
  EXPECT_EQ(five.wrong(w.rows), 0);
}

}  // namespace
}  // namespace talus::determinism
