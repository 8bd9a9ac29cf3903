// Profile and trace tell what ran: no time twice, none of the warm steps, every node of every traced step on the row of
// its thread. Times themselves are not judged: the machine may be busy.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "tests/determinism/scenes.hpp"

namespace talus::determinism {
namespace {

RunOptions cut(int threads) {
  RunOptions o;
  o.threads = threads;
  o.chunk = 128;
  return o;
}

std::map<std::string, NodeTime> by_name(const Profile& p) {
  std::map<std::string, NodeTime> m;
  for (const NodeTime& n : p.nodes) m[n.node] = n;
  return m;
}

TEST(Profile, CoversTheStepsSinceItsRestartOnly) {
  Simulation sim(sheared_bed(), cut(1));
  sim.run(50);
  sim.restart_profile();
  sim.run(20);
  const Profile p = sim.profile();
  const auto nodes = by_name(p);
  const std::int64_t chunks = sim.plan().chunks;
  EXPECT_EQ(p.steps, 20);
  EXPECT_EQ(p.tasks, (nodes.contains("wall_contact") ? 4 : 3) * 20 * chunks);
  for (const char* name : {"narrow_phase", "contact_force", "integrate"})
    EXPECT_EQ(nodes.at(name).calls, 20 * chunks) << name;
}

TEST(Profile, ThreadTimesAddUpToTheWallAndNodesToTheThreads) {
  Scene scene = sheared_bed();
  scene.sort_every = 2;  // an epoch contains a rebuild: counted twice, the sum would exceed the wall
  for (const int threads : {1, 2, 3}) {
    Simulation sim(scene, cut(threads));
    sim.run(100);
    const Profile p = sim.profile();
    ASSERT_EQ(p.threads.size(), static_cast<std::size_t>(threads));
    double busy = 0, nodes = 0;
    for (const Profile::Thread& t : p.threads) {
      // no thread does more than the wall; 1 us: the two ends of the wall are read on one thread
      EXPECT_GE(t.idle, -1e-6) << threads;
      EXPECT_NEAR(t.busy + t.waiting + t.idle, p.wall, 1e-9);
      busy += t.busy;
    }
    for (const NodeTime& n : p.nodes) {
      nodes += n.seconds;
      EXPECT_GE(n.imbalance, 1 - 1e-12) << n.node;
      EXPECT_LE(n.imbalance, threads + 1e-12) << n.node;
    }
    EXPECT_NEAR(nodes, busy, 1e-9 * p.wall);
    EXPECT_GT(busy, 0);
    EXPECT_EQ(by_name(p).at("sort_epoch").calls, 50);
  }
}

/// Number behind "key": in a line of the trace, or -1.
long number(const std::string& line, const std::string& key) {
  const std::size_t at = line.find("\"" + key + "\":");
  return at == std::string::npos ? -1 : std::atol(line.c_str() + at + key.size() + 3);
}

TEST(Trace, ShowsEveryNodeOfTheChosenStepsOnNamedRows) {
  const std::string path = (std::filesystem::temp_directory_path() / "talus-trace-test.json").string();
  Simulation sim(sheared_bed(), cut(2));
  sim.start_trace(30, 10);
  sim.run(60);
  sim.write_trace(path);
  std::ifstream in(path);
  std::string line;
  std::set<long> rows;
  std::map<long, std::map<std::string, std::set<long>>> ran;  // step, node, chunks
  while (std::getline(in, line)) {
    if (line.find("thread_name") != std::string::npos) rows.insert(number(line, "tid"));
    if (line.find("\"ph\":\"X\"") == std::string::npos) continue;
    EXPECT_TRUE(rows.contains(number(line, "tid"))) << line;
    const std::size_t name = line.find("\"name\":\"") + 8;
    const long chunk = number(line, "chunk");
    if (chunk >= 0) ran[number(line, "step")][line.substr(name, line.find('"', name) - name)].insert(chunk);
  }
  std::filesystem::remove(path);
  EXPECT_EQ(rows, (std::set<long>{0, 1}));
  ASSERT_EQ(ran.size(), 10U);
  EXPECT_EQ(ran.begin()->first, 30);
  EXPECT_EQ(ran.rbegin()->first, 39);
  const auto chunks = static_cast<std::size_t>(sim.plan().chunks);
  for (const auto& [step, nodes] : ran)
    for (const char* name : {"narrow_phase", "contact_force", "integrate"}) {
      ASSERT_TRUE(nodes.contains(name)) << step;
      EXPECT_EQ(nodes.at(name).size(), chunks) << step << " " << name;
    }
}

}  // namespace
}  // namespace talus::determinism
