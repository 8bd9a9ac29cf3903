// What a run says of itself: counters, profile, plan, warnings, the course of the list. Plain values; filled by the
// rooms that know them, handed out by Simulation.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace talus {

/// One rebuild, for the course of the list over a run.
struct ListRecord {
  std::int64_t step = 0;
  std::int64_t interval = 0;  ///< steps since the rebuild before
  double k = 0, floor = 0;    ///< of the new list; 0 where the policy has none
  double skin = 0;            ///< mean skin / diameter of the new list
  std::int64_t pairs = 0;     ///< candidates of the new list
  std::int64_t contacts = 0;  ///< touching pairs
};

/// Counters of a run: cumulative and not part of the trajectory unless noted.
struct Counters {
  std::int64_t steps = 0;              ///< executed by this object
  std::int64_t rebuilds = 0;           ///< all list rebuilds
  std::int64_t cuts = 0;               ///< policy outer_inner: inner lists cut out of outer ones, beside rebuilds
  std::int64_t rebuilds_skin = 0;      ///< by the displacement check
  std::int64_t rebuilds_forced = 0;    ///< by sort epochs, insertion, events, start
  std::int64_t shortest_interval = 0;  ///< steps between two skin rebuilds
  std::int64_t pairs = 0;              ///< candidate pairs in the present list (each once)
  std::int64_t contacts = 0;           ///< touching pairs at the last step (each once)
  std::int64_t wall_contacts = 0;
  std::int64_t sort_epochs = 0;
  std::int64_t inserted = 0, removed = 0;  ///< cumulative over the trajectory
  double removed_mass = 0;                 ///< [kg], cumulative over the trajectory
  std::int64_t missed_contacts = 0;        ///< audit only
  /// Pairs of superquadrics that the normal of the last step did not part, summed over the steps: all that were
  /// solved, and those that the batch solver left to the safe method. Depend on the trajectory alone.
  std::int64_t solved_pairs = 0, safe_pairs = 0;
  std::int64_t step_solved_pairs = 0, step_safe_pairs = 0;  ///< the same of the last step alone
  double border_contact_share = 0;                          ///< contacts across chunk borders / contacts
  std::vector<std::int64_t> interval_steps;  ///< step of each of the last rebuilds (up to 4096), for the report
};

/// One row of the profile.
struct NodeTime {
  std::string node;
  std::int64_t calls = 0;
  double seconds = 0;    ///< summed over threads, without nodes inside it and without waiting
  double imbalance = 1;  ///< largest / mean over the threads of their seconds in this node
};

/// Where the threads' time went since the start or the last restart_profile(). busy + waiting + idle = wall per thread.
struct Profile {
  struct Thread {
    double busy = 0;     ///< in nodes [s]
    double waiting = 0;  ///< in a serial node for the blocks of other threads [s]
    double idle = 0;     ///< no node to run, or in the scheduler [s]
  };
  std::vector<NodeTime> nodes;  ///< those that ran
  std::vector<Thread> threads;
  double wall = 0;  ///< of run() [s]
  std::int64_t steps = 0;
  std::int64_t tasks = 0;  ///< node executions on chunks
  double hop = 0;          ///< mean time from a chunk's node to its next one on the same thread [s]
  std::int64_t clock_reads = 0;
  double clock_read = 0;  ///< cost of one, measured now [s]
};

/// What the step consists of; printed by `talus explain`.
struct Plan {
  struct Node {
    std::string name, why, reads, writes;
    bool in = false;
  };
  struct Array {
    std::string name, why;
    double bytes_per_particle = 0;
    bool in = false;
  };
  std::vector<Node> nodes;
  std::vector<Array> arrays;
  double bytes_per_particle = 0;                     ///< arrays that are in, lists included (measured)
  std::string law, isa, isa_why, policy, guarantee;  ///< guarantee: of the list policy
  int threads = 0, chunk = 0, chunks = 0;
  std::string graph;  ///< text picture: nodes in order with edges
};

/// What a part's own step has found that the user should know.
struct PartConcern {
  std::string kind, text;  ///< a kind is said once, its count goes on; text: where, how much, what it means
  double value = 0, level = 0;
  std::int64_t count = 1;
};

/// Something that the run-time monitor has seen, one entry per kind (mesh: per wall), in order of appearance; before
/// them what was ignored in the particle files (kind particle_file).
struct Warning {
  /// overlap, travel, stiffness, energy, extent, mesh, particle_file, source, event, stream NAME, PART ...
  std::string kind;
  std::string text;  ///< what, who, when and the cure, of the first time
  std::int64_t first_step = 0;
  std::int64_t count = 0;  ///< pairs, particles or balances above the level, summed over the sampled steps
  double worst = 0, level = 0;
};

/// A number that an optional part gives of the present step, a column of the time series.
struct PartValue {
  std::string name, unit;
  double value = 0;
};

struct FrameRequest {
  bool contacts = false, coordination = false, stress = false, walls = false, wall_loads = false;
};

}  // namespace talus
