// summary.json: what was run, how fast, and with which result (DESIGN 6). Who calls it: cases/ (run, also after an
// error). Invariants: valid JSON for any text and number (non-finite numbers and absent values are null), one key per
// line, fixed order.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/meshes/mesh_file.hpp"

namespace talus {

struct Summary {
  struct Node {
    std::string name;
    std::int64_t calls = 0;
    double seconds = 0;  ///< summed over threads
  };
  /// What the run-time monitor has seen; one entry per kind.
  struct Alert {
    std::string kind, text;  ///< text: of the first time
    std::int64_t first_step = 0, count = 0;
    double worst = 0, level = 0;
  };
  std::string title, scene_file, version, status = "finished";  ///< status: finished, interrupted, failed: <message>
  std::int64_t particles = 0, steps = 0;                        ///< at the end; steps executed by this call
  std::int64_t first_step = 0, last_step = 0;
  double dt = 0, simulated_time = 0;  ///< [s]
  double wall_s = 0, particle_steps_per_s = 0;
  std::vector<Node> nodes;           ///< empty unless profiled
  std::optional<std::int64_t> cuts;  ///< list policy outer_inner: inner lists cut out of outer ones, beside rebuilds
  std::int64_t rebuilds = 0, rebuilds_skin = 0, rebuilds_forced = 0, shortest_interval = 0;
  double mean_interval = 0;                 ///< steps per rebuild
  std::vector<std::int64_t> rebuild_steps;  ///< steps of the last rebuilds
  std::int64_t sort_epochs = 0;
  std::int64_t candidate_pairs = 0, contacts = 0, wall_contacts = 0;
  /// With superquadrics: pairs solved over the steps of this call, and those of them that took the safe method.
  std::optional<std::int64_t> solved_pairs, safe_pairs;
  std::int64_t inserted = 0, removed = 0;
  double removed_mass = 0;  ///< [kg]
  /// Passages through a flux plane since the start of the trajectory.
  struct Plane {
    std::string name;
    std::int64_t particles = 0, forward = 0, backward = 0;  ///< particles: forward less backward
    double mass = 0;                                        ///< the same of masses [kg]
  };
  std::vector<Plane> planes;
  std::vector<std::pair<std::string, double>> parts;  ///< last values of optional parts, by their columns of the series
  std::optional<std::uint64_t> planes_hash;           ///< over the planes and their counts; only with planes
  std::optional<std::int64_t> late_detections;        ///< not counted: the list is checked at every step
  std::optional<std::int64_t> missed_contacts;        ///< only if audited
  double bytes_per_particle = 0;
  std::int64_t peak_rss_bytes = 0;
  /// A rebuild of the list; thinned.
  struct Rebuild {
    std::int64_t step = 0, interval = 0;
    double k = 0, floor = 0, skin = 0;
    std::int64_t pairs = 0, contacts = 0;
  };
  std::vector<Rebuild> list_series;
  double verlet_k = 0;  ///< of the scene, or the present one where the run chooses it
  bool verlet_k_automatic = false;
  std::string guarantee;  ///< of the policy
  std::string policy, law, isa;
  int threads = 0, chunk = 0;
  std::uint64_t seed = 0;
  std::optional<double> kinetic_energy, kinetic_rotation;  ///< of translation; of rotation [J]
  std::optional<double> potential_energy, elastic_energy, dissipated_energy;  ///< [J]
  std::vector<Alert> warnings;
  std::vector<std::pair<std::string, MeshReport>> meshes;  ///< of every mesh wall: its name, what was found
  std::uint64_t state_hash = 0;
};

/// The JSON text, ending with a newline; state_hash as 16 hex digits.
std::string summary_json(const Summary& summary);
/// Writes PATH atomically. Error{io}.
void write_summary(const std::string& path, const Summary& summary);
/// Text of a summary file. Error{io}: unreadable, truncated or damaged, or not the summary of a run.
std::string read_summary_text(const std::string& path);
/// A JSON string literal of any bytes: control characters escaped, invalid UTF-8 replaced by U+FFFD.
std::string json_string(const std::string& text);
/// Largest resident memory of this process so far [bytes].
std::int64_t peak_rss_bytes();

}  // namespace talus
