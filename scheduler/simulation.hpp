// Simulation: the engine's public face. Owns particles, lists, contacts, walls, sources and the step graph.
// Who calls it: cases/program/talus.cpp, tests, perf. Only scheduler/*.cpp sees TBB.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/frame/columns.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/plane_count.hpp"
#include "core/io/checkpoint.hpp"
#include "core/meshes/mesh_file.hpp"
#include "core/rules/timestep.hpp"
#include "core/scene/scene.hpp"
#include "scheduler/reports.hpp"

namespace talus {

class Simulation {
 public:
  /// Builds everything for step 0. Errors: Error{scene}, also for a time step above the packing limit that the scene
  /// does not allow, or in which a wall or grain goes too far (time_step_limits() in core/rules/timestep.hpp);
  /// Error{physics}.
  Simulation(const Scene& scene, const RunOptions& options);
  /// Continues from a checkpoint of the same scene (any threads, ISA, chunk, policy, K), or of one that differs where
  /// core/scene/scene_changes allows it. `walls`: as wall_numbers() there; empty: the same walls.
  Simulation(const Scene& scene, const RunOptions& options, const CheckpointReader& checkpoint,
             const std::vector<int>& walls = {});
  /// Error{io}: a state that would go on wrongly without a word (of a failed step, or of an older version). A
  /// Simulation of it can be looked at, but run() refuses.
  static void check_continuable(const CheckpointReader& checkpoint);
  /// Step of a checkpoint. Error{io}.
  static std::int64_t step_of(const CheckpointReader& checkpoint);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Advances exactly `steps` steps. Error{physics} names particle id and step; the state stays readable.
  void run(std::int64_t steps);

  const Scene& scene() const noexcept;
  std::int64_t step() const noexcept;
  double time() const noexcept;             ///< step * dt
  std::int64_t particles() const noexcept;  ///< alive
  std::uint64_t state_hash() const;         ///< order-free hash over id, x, v, w, history (DESIGN 6)
  Counters counters() const;
  const std::vector<ListRecord>& list_series() const noexcept;  ///< at most 512 rebuilds, evenly thinned
  Energies energies() const;      ///< of the last executed step; zeros where not asked for
  double kinetic_energy() const;  ///< translation, from v(n-1/2) [J]
  /// The present state; contacts, coordination and stress are those of its positions, evaluated on a copy. Nothing that
  /// a run computes or reports depends on whether and when frames are made.
  Frame frame(const FrameRequest& request = {}) const;
  /// Passages through the scene's flux planes, in its order, counted in every step since the start of the trajectory.
  const std::vector<PlaneTotal>& planes() const noexcept;
  /// What optional parts say of the present step; their number and names never change in a run.
  std::vector<PartValue> part_values() const;
  /// What `talus check` says of them, with the name of each part.
  std::vector<std::pair<std::string, std::string>> part_advice() const;
  /// Cells of optional parts, by name of the part.
  std::vector<std::pair<std::string, GridData>> part_grids() const;
  std::uint64_t planes_hash() const;  ///< over the planes and their totals; state_hash() has none of it
  Plan plan() const;
  const TimeStepReport& time_step() const noexcept;  ///< what the construction has judged the step by
  Softening softening(double speed) const;           ///< for impacts at `speed` [m/s] or the fastest that is stated
  std::vector<std::pair<std::string, MeshReport>> meshes() const;  ///< of every mesh wall: name, what was found
  const std::vector<Warning>& warnings() const noexcept;           ///< of this object's steps
  const std::vector<ParticleId>& culprits() const noexcept;        ///< particles that the failure of run() names
  Profile profile() const;                                         ///< always recorded
  void restart_profile();                                          ///< from now on (benchmarks: after their warm steps)
  void start_trace(std::int64_t first_step, std::int64_t steps);   ///< records the executions of nodes in these steps
  void write_trace(const std::string& path) const;                 ///< Chrome trace JSON. Error{io}
  void save(CheckpointWriter& out) const;
  std::size_t bytes() const;  ///< memory of all arrays

 private:
  friend struct EngineAccess;  ///< scheduler/step/access.hpp: what benchmarks and tests see behind this
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus
