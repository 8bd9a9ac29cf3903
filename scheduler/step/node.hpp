// What is declared of a node of the step. Who declares them: step/table.cpp, optional parts. Who derives from it: the
// graph, `explain`, profile and trace, the test of I7.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "scheduler/team/profile.hpp"

namespace talus {

struct World;
struct Chunk;

/// An array that a node reads or writes, by name. `all`: beyond the rows of its own chunk; serial nodes always may.
struct Access {
  const char* array;
  bool all = false;
};

/// When a node runs. Nodes of a phase run in the order of the table; chunk nodes one after another for each chunk, all
/// chunks at once.
enum class Phase { decide, insert, lists, chunk, finish };

struct NodeSpec {
  Node id{};  ///< in profile and trace
  std::string name;
  Phase phase = Phase::chunk;
  std::vector<Access> reads, writes;
  bool in = true;
  std::string why;                          ///< it is in, or left out
  std::function<void(World&, Chunk&)> run;  ///< the chunk means nothing to serial nodes
  std::int64_t every = 1;                   ///< it runs in one of so many steps, the last of them
};

}  // namespace talus
