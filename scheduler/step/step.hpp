// The step as a whole: its table, the graph that runs it, and what ends it. Who calls it: Simulation, view/, tests.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scheduler/state/step_failure.hpp"
#include "scheduler/step/node.hpp"

namespace talus {

struct World;

/// All nodes that a step can have, in order; those that this scene does not need are not `in` (table.cpp).
std::vector<NodeSpec> step_table(const World& w);
/// The nodes of this scene and their edges, as text.
std::string graph_picture(const World& w);

/// Runs up to step `target` (graph.cpp). Throws the first failure.
void run_graph(World& w, std::int64_t target);

void run_node(World& w, const NodeSpec& node, Chunk& c);         ///< timed; failures are kept
void check_step(World& w);                                       ///< failures, removals; decides about the present step
void finish_step(World& w, const std::vector<NodeSpec>& table);  ///< swaps buffers, Phase::finish, advances n

void cut_into_chunks(World& w);  ///< for the present number of rows

/// Takes the failed step back and throws the Error of the run.
[[noreturn]] void take_back(World& w, const StepFailure& failure);
template <class F>
void taking_back(World& w, F fn) {
  try {
    fn();
  } catch (const StepFailure& failure) {
    take_back(w, failure);
  }
}

}  // namespace talus
