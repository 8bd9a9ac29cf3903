// World: all arrays of a run and the chunks they are cut into. Shared by the nodes of the step graph; each node's
// reads and writes are listed in step_graph.cpp (I7). Position rows are relative to the domain's lower corner.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/types.hpp"
#include "core/frame/frame.hpp"
#include "core/frame/plane_count.hpp"
#include "core/grains/insertion.hpp"
#include "core/rules/skin.hpp"
#include "core/rules/timestep.hpp"
#include "core/scene/scene.hpp"
#include "core/walls/walls.hpp"
#include "kernels/kernel_table.hpp"
#include "scheduler/lists/skin_check.hpp"
#include "scheduler/lists/tuner.hpp"
#include "scheduler/nodes/monitor.hpp"
#include "scheduler/simulation.hpp"
#include "scheduler/team/chunk_map.hpp"
#include "scheduler/team/lane_choice.hpp"
#include "scheduler/team/profile.hpp"
#include "scheduler/team/shares.hpp"
#include "scheduler/team/step_gate.hpp"

namespace talus {

/// Makes room for n elements and some more; keeps the content (grow_discarding of parallel.hpp does not).
template <class T>
void grow(Column<T>& c, std::size_t n) {
  if (c.size() < n) c.resize(n + n / 8 + 64);
}

inline constexpr double k_gone = 1e150;  ///< coordinate of removed rows: touches nothing, stays finite
inline constexpr int k_energy_block = 1024;
/// Work of a step, or of a block of its rows [J]: place 1 damping, 2 friction, 3 background, 4 drive, 5 gravity.
using StepWork = std::array<double, 6>;

/// The last rebuilds, thinned: when full, every second entry goes and from then on only half as many are taken.
class ListSeries {
 public:
  void add(const ListRecord& r) {
    if (seen_++ % stride_ != 0) return;
    if (records.size() == k_room) {
      for (std::size_t k = 0; k < k_room / 2; ++k) records[k] = records[2 * k];
      records.resize(k_room / 2);
      stride_ *= 2;
    }
    records.push_back(r);
  }
  std::vector<ListRecord> records;

 private:
  static constexpr std::size_t k_room = 512;
  std::int64_t seen_ = 0, stride_ = 1;
};

/// Which optional parts a scene needs (DESIGN 4, "leaving out"). Decided once from the scene.
struct Features {
  bool rotation = false, history = false, materials = false, walls = false, moving_walls = false, fixed = false;
  bool groups = false, energies = false, insertion = false, events = false, removal = false, periodic = false;
  bool moments = false, cohesion = false, adhesion = false, planes = false;
  int history_columns = 0;  ///< of the law, then those of rolling and twisting
  int law_columns = 0, moment_columns = 0;
  bool reff = false;
};

/// Parts of a rebuild; timed apart so that each can be measured from outside (a few clock reads per rebuild and chunk).
enum class RebuildPart : int { skin, keys, sort, fill, search, history, walls, count };

/// Contact of a particle with a wall, with its history (I5).
struct WallState {
  Row row = 0;
  WallContact contact;
  double h[k_max_history] = {};
};

/// WallState with the history of rolling and twisting, as used by sort epochs, checkpoints and hashes.
struct WallEntry : WallState {
  double m[k_max_moment] = {0, 0, 0, 0, 0};
};

/// One undirected contact (a < b), as used by sort epochs, checkpoints and hashes; history oriented a - b.
struct ContactEntry {
  Row a = 0, b = 0;
  double h[k_max_columns] = {};
};

/// Per-execution buffers of one chunk between narrow phase and integration; pooled so that they stay in cache.
struct Scratch {
  Column<std::int32_t> ci, cj;
  Column<double> f;  ///< force rows of the chunk; all zero while `clean`
  bool clean = false;
  Column<HistoryRun> runs;          ///< where the contacts' history of the last step is; the chunk's run_count of them
  Column<double> h[k_max_columns];  ///< history of the present step, swapped with the chunk's where contacts have moved
  std::vector<std::int32_t> wall_near;  ///< elements that a row can touch
  Column<double> m;                     ///< moment rows {M, 0} of the chunk: rolling and twisting only
  Column<std::uint8_t> before;          ///< touch bits of the last step: where add_ons.cpp carries history
};

/// A grain has passed a flux plane in the present step; net > 0: along the normal.
struct Crossing {
  Row row = 0;
  std::int32_t plane = 0, net = 0;
};

/// Owner of rows [lo, hi).
struct Chunk {
  int index = 0;
  Row lo = 0, hi = 0;
  // pair list (sections lower, interior, higher, each padded to a multiple of 8)
  Column<std::int32_t> pi, pj;
  Column<std::uint8_t> mask;
  std::int64_t end[3] = {0, 0, 0};
  std::int64_t pairs[3] = {0, 0, 0};  ///< without padding
  // contacts of the last step
  Column<double> h[k_max_columns];
  std::int64_t contact_end[3] = {0, 0, 0};
  Column<std::int32_t> outer_i, outer_j;  ///< outer list, laid out as pi and pj; only with list policy outer_inner
  std::int64_t outer_end[3] = {0, 0, 0};
  std::int32_t run_count = 0;  ///< between narrow phase and contact force: runs in scratch, 0 where none has moved
  /// Keys of the contacts that a sort epoch or a checkpoint has handed to this chunk, each section closed by a last
  /// key; empty where the present list holds them.
  Column<std::uint64_t> distributed;
  // walls
  Column<std::int32_t> wall_row;           ///< rows with candidates, ascending
  Column<std::int32_t> wall_begin;         ///< [rows + 1] into wall_element
  std::vector<double> wall_radius;         ///< only with adhesion: R_C of each row towards a wall [m]
  std::vector<std::int32_t> wall_element;  ///< candidates of WallSet, images included
  std::vector<float> wall_distance;        ///< lower bound of each element's distance when the list was made [m]
  std::vector<float> wall_nearest;         ///< least wall_distance of each row [m]
  std::vector<WallState> wall_state;       ///< contacts of the last step, ascending (row, wall, element)
  std::vector<WallState> wall_next;
  std::vector<Vec3> wall_force;                       ///< on the particle, parallel to wall_state
  std::vector<Vec3> wall_point;                       ///< contact points, parallel to wall_state
  std::vector<double> wall_moment, wall_moment_next;  ///< rolling history: moment_columns per entry of wall_state
  std::vector<Vec3> wall_torque;                      ///< moment on the particle; rolling and twisting only
  // energies of the step, one row of {elastic, damping, friction, background} per particle of the chunk
  std::vector<double> wall_power;  ///< work of moving walls in this step, parallel to wall_state
  // results of integrate
  Column<std::int32_t> out;
  std::int32_t out_count = 0;
  int expired = 0;
  double travel[2] = {0, 0};  ///< two largest travels, policies with an own check [m]
  std::int32_t unstable_row = -1;
  std::int64_t deep_slot = -1;
  std::int64_t deep_wall = -1;  ///< wall contact deeper than allowed, or -1
  ChunkExtremes extremes;       ///< of a sampled step
  Scratch* scratch = nullptr;
  Column<std::int32_t> row_buffer;  ///< the two rows of deep_slot
  std::vector<Crossing> crossings;  ///< of the present step, ascending (plane, row); only with flux planes
  double rebuild_seconds[static_cast<int>(RebuildPart::count)] = {};
};

/// Pool of scratch buffers. Every thread gets back the one it gave, which lies in its caches; the rest is last in first
/// out.
class ScratchPool {
 public:
  void prepare(int threads) { home_ = std::vector<Home>(static_cast<std::size_t>(threads)); }
  Scratch* take(int slot);  ///< slot: of the calling thread, or -1
  void give(Scratch* s, int slot = -1);
  std::size_t bytes() const;

 private:
  struct alignas(128) Home {
    Scratch* scratch = nullptr;
  };
  std::vector<Home> home_;  ///< by slot; only its thread looks
  std::mutex mutex_;
  std::vector<std::unique_ptr<Scratch>> all_;
  std::vector<Scratch*> free_;
};

/// Buffers of one running list build; pooled, so that there are as many as threads.
struct ListScratch {
  Column<float> x, y, z, r;  ///< candidates of a group of rows
  Column<std::int32_t> tag, hits;
  Column<std::int32_t> build[6];   ///< sections before they are laid end to end: own row, partner row
  Column<std::uint64_t> keys;      ///< touching pairs of the old list
  std::vector<std::int64_t> lost;  ///< contacts that the new list lacks
  Column<std::uint8_t> mask;       ///< of outer slots; outer_inner only
};

class ListScratchPool {
 public:
  ListScratch* take();
  void give(ListScratch* s);
  std::size_t bytes() const;

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<ListScratch>> all_;
  std::vector<ListScratch*> free_;
};

/// Key of a pair in list order.
inline std::uint64_t pair_key(Row i, Row j) noexcept {
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) << 32 | static_cast<std::uint32_t>(j);
}

/// What the scene decides once and no step changes. A copy points to the tables of its original.
struct Setup {
  Scene scene;
  RunOptions options;
  Features has;
  const KernelTable* kernels = nullptr;
  std::string isa_why;
  const LawInfo* law = nullptr;
  int law_variant = 0;
  bool trial = false;                      ///< the Coulomb limit is applied by the scatter (KernelTable::trial)
  std::vector<PairParameters> parameters;  ///< particle pairs, and walls (same table: walls are materials)
  LawArgs law_args{};
  std::vector<AddOnParameters> add_ons;  ///< like parameters; empty without rolling, twisting and cohesion
  std::vector<double> cohesion;          ///< energy densities; empty without cohesion
  std::vector<double> adhesive_range;    ///< AdhesiveArgs::range; empty without adhesion
  MomentArgs moment_args{};
  unsigned moment_flips = 0;
  int stride = 4;   ///< doubles per velocity and force row (8 with rotation)
  int threads = 1;  ///< asked for; lane_choice says how many work at present
  double r_min = 0, r_max = 0;
  Vec3 size;  ///< domain extent [m]

  int pair_index(int a, int b) const { return a * static_cast<int>(scene.materials.size()) + b; }
  /// History column q changes sign when the partners of a contact are swapped.
  bool flips(int q) const {
    // the tangential spring, and the second part of partial slip; scalars are the same for both
    if (q < has.law_columns) return has.rotation && (q < 3 || (scene.contact.partial_slip && q > 3 && q < 7));
    return ((moment_flips >> (q - has.law_columns)) & 1U) != 0;
  }
};

/// Work since the start [J]: sums over all steps.
struct WorkTotals {
  double damping = 0, friction = 0, background = 0;  ///< dissipated
  double wall = 0;                                   ///< of moving walls and driven grains on the others
  double drive = 0;                                  ///< the part of the last step alone, times dt
  double gravity = 0;                                ///< along periodic axes, where a height means nothing
};

struct World : Setup {
  // particles, [n] rows (+ one dead row n, padded)
  Row n = 0;
  Row alive = 0;
  Column<double> p, p2;  ///< {x, y, z, r}
  Column<double> v, v2;  ///< {v, 0 | r w, 1/m} or {v, 1/m}
  Column<double> x0;     ///< {x, y, z at the rebuild, skin^2}
  Column<ParticleId> id;
  Column<std::uint8_t> material;  ///< only with several materials
  Column<std::uint8_t> fixed;     ///< only where something can be fixed
  Column<std::int16_t> group;     ///< only with groups
  Column<double> energy;          ///< [4 n] only with energies: elastic, damping, friction, work of a driven row or
                                  ///< what local damping takes
  Column<float> drift;            ///< [4 n] only with list policy velocity_profile: {u, 0}, the profile's at x0 [m/s]
  Column<double> outer;           ///< [4 n] only with list policy outer_inner: {x, y, z at the outer list, its skin}
  Column<double> near;            ///< [4 n] the same: {x, y, z, reach in the inner list}
  Column<double> next_skin;       ///< only with list policy displacement_history [m]; -1: no past
  ParticleId next_id = 0;
  bool velocity_at_old_step = false;  ///< v2 holds v(n-3/2) of the same rows (for |a| in the skin)

  std::int64_t step = 0;
  Vec3 gravity;
  int chunk_size = 4096;  ///< of equal chunks; a sort epoch makes as many of equal cost (sort_epoch.cpp)
  ChunkMap chunk_of;
  std::vector<std::unique_ptr<Chunk>> chunks;
  Chunk serial;  ///< stands for all rows in the timers of serial nodes
  NodeTimes times;
  int graph_lanes = 0;  ///< loops over chunks that the step graph was built with
  ScratchPool scratch;
  ChunkShares shares;
  StepGate gate;
  LaneChoice lane_choice;
  /// Some chunk has something to say about the last step: leavers, a failure, samples of the monitor. Nearly always
  /// none has, and a check that visits every chunk fetches a cache line of each from the core that worked on it.
  std::atomic<bool> news{true};
  std::atomic<bool> any_expired{true};  ///< some row has used up its skin since the lists were made

  // broad phase
  SkinRule skin;
  ListFrame frame;
  SkinTuner tuner;
  ListSeries list_series;
  Column<float> reach;                              ///< by row: inflated reach [m]
  Column<std::int32_t> cell_of_row, place_in_cell;  ///< by row
  Column<float> sx, sy, sz, sr;                     ///< sorted by cell
  Column<std::int32_t> sorted_row, cell_start;
  GridLevel level[k_max_levels] = {};
  int levels = 0;
  ListScratchPool list_scratch;

  WallSet walls;  ///< positions relative to the domain's lower corner, like p
  std::unique_ptr<Insertion> insertion;
  std::size_t next_event = 0;
  double unstable_limit = 0;  ///< bound on row sum / mass [1/s2]
  TimeStepReport time_step;   ///< judged at construction
  double wall_step = 0;       ///< how far a wall may go in one step [m]
  double warn_row = 0;        ///< row sum / mass, times dt^2, from which on the monitor warns
  bool sampled = false;       ///< the monitor looks at the present step
  MonitorState monitor;
  std::vector<ParticleId> culprits;  ///< named by the failure

  // cumulative
  Counters counters;
  std::int64_t last_rebuild_step = 0;
  WorkTotals work, work_before;  ///< with energies only; before: what a step that fails goes back to
  double inserted_energy = 0;
  std::vector<StepWork> step_work;  ///< by block of k_energy_block rows; with energies only
  PlaneCounts planes;
  Energies resumed;  ///< of the step before the checkpoint that this run goes on from
  double start_energy = 0;
  bool start_energy_known = false;
  std::atomic<bool> failed{false};
  std::mutex error_mutex;
  int error_chunk = 0;
  std::exception_ptr error;  ///< the failure of the lowest chunk
  bool structure = false;    ///< an epoch, an insertion or an event acts in the present step
  bool lists_valid = false;  ///< false: the next check must rebuild whatever the skins say

  double mass(Row i) const;                 ///< [kg] from material and radius
  Vec3 gravity_along(bool periodic) const;  ///< its components along the periodic axes, or along the others
  double row_energy(Row i) const;           ///< at n: kinetic, and potential where the row is free [J]
  Vec3 position(Row i) const;               ///< absolute [m]
  /// Drift velocity of a row for the policies that have one (SkinRule::drifts()) [m/s].
  Vec3 drift_of(Row i) const {
    const float* u = drift.empty() ? frame.drift : drift.data() + 4L * i;
    return {u[0], u[1], u[2]};
  }
  bool is_alive(Row i) const { return p[4L * i] < 1e100; }
};

/// One copy of all rows takes at most 6 MiB: they stay in nearer caches, where prefetching own rows, history and the
/// next chunk costs 7 % (32k grains, AMD Zen 5) and chunks may be larger.
inline bool rows_stay_near(const World& w) {
  return static_cast<std::size_t>(w.n) * static_cast<std::size_t>(w.stride + 4) * sizeof(double) <= std::size_t{6}
                                                                                                        << 20;
}

/// Adds the time since construction or the last lap to a part of the rebuild.
class PartClock {
 public:
  explicit PartClock(Chunk& c) : c_(c), last_(std::chrono::steady_clock::now()) {}
  void lap(RebuildPart part) {
    const auto now = std::chrono::steady_clock::now();
    c_.rebuild_seconds[static_cast<int>(part)] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  Chunk& c_;
  std::chrono::steady_clock::time_point last_;
};

// --- state.cpp: storage -------------------------------------------------------------------------------------------
void set_particle_capacity(World& w, Row n);  ///< resizes columns to n rows (+ dead row), keeps content
void append_particles(World& w, const NewParticles& a, bool initial);  ///< initial: no energy counts as inserted
void need_chunks(World& w, int count);                                 ///< adds empty ones where there are fewer
void make_chunks(World& w);        ///< cuts rows into chunks; keeps existing ones in place
void remove_row(World& w, Row i);  ///< marks a row dead (I2), counts it
/// Contacts whose lower row is the chunk's, ascending (a, b): over all chunks each contact once, in ascending order.
std::vector<ContactEntry> contacts_of(const World& w, const Chunk& c);
std::vector<WallEntry> collect_wall_states(const World& w);
std::uint64_t state_hash(const World& w);

// --- restored_state.cpp ---------------------------------------------------------------------------------------------
/// Rows of a checkpoint, once `next_id` and the rules of the scene are known. Error{io}.
void check_restored_rows(const World& w, const std::string& path);
void check_restored_contacts(const World& w, const std::vector<ContactEntry>& contacts,
                             const std::vector<WallEntry>& walls, const std::string& path);

// --- rebuild.cpp, cell_grid.cpp, sort_epoch.cpp, hand_over.cpp ------------------------------------------------------
/// Gives the contacts of a checkpoint to their chunks, for the rebuild that has to follow.
void distribute_contacts(World& w, const std::vector<ContactEntry>& contacts, const std::vector<WallEntry>& walls);
void sort_epoch(World& w);     ///< compacts and permutes rows into Morton order
void fill_cells(World& w);     ///< skins and cell grid
void rebuild_lists(World& w);  ///< fill_cells, lists, history
/// The same between the two calls of the tuner; may_cut: or inner lists out of the outer ones, where these allow it.
/// Returns whether it did the latter.
bool rebuild_tuned(World& w, bool may_cut);
/// Candidates of one chunk before they are laid into its list: sections lower, interior, higher.
struct Sections {
  const std::int32_t *i[3], *j[3];
  std::int64_t n[3];
};
/// Lays the sections into the chunk's list and merges the contacts of its old one into mask and history.
void replace_list(World& w, Chunk& c, ListScratch& t, const Sections& s);
void count_pairs(World& w);

// --- inner_list.cpp: list policy outer_inner ------------------------------------------------------------------------
/// Row i of the inner list: at x, skin `skin` [m] (removed rows: at infinity, without reach).
void set_near(World& w, Row i, double skin);
/// Keeps the sections as the chunk's outer list, and returns those of the inner one; both live in the scratch.
Sections cut_sections(World& w, Chunk& c, ListScratch& t, const Sections* fresh);
bool cut_lists(World& w);  ///< false: the outer lists do not allow it, nothing but x0 and near is changed

// --- chunk_work.cpp -----------------------------------------------------------------------------------------------
void narrow_chunk(World& w, Chunk& c);
/// L1 buffers of one block of contacts; padding lanes must hold finite values.
struct BlockBuffers {
  alignas(64) double x[4][k_block + k_pad], g[4][k_block + k_pad], r[8][k_block + k_pad], e[3][k_block + k_pad],
      reff[k_block + k_pad];
  alignas(64) double slid[k_block + k_pad];              ///< see Block::slid; rolling and twisting only
  alignas(64) double t[3][k_block + k_pad];              ///< see Block::t
  alignas(64) double s[4][k_block + k_pad];              ///< spins, then moments; rolling and twisting only
  alignas(64) double h[k_max_history][k_block + k_pad];  ///< history of a block whose contacts have moved
  alignas(64) std::int32_t pair[k_block + k_pad];
  BlockBuffers() noexcept {
    for (int k = 0; k < k_block + k_pad; ++k) {
      reff[k] = 1;
      pair[k] = 0;
    }
  }
};
void force_chunk(World& w, Chunk& c);
void wall_chunk(World& w, Chunk& c);
void integrate_chunk(World& w, Chunk& c);

// --- plane_count.cpp: only with flux planes -----------------------------------------------------------------------
void plane_chunk(World& w, Chunk& c);  ///< which rows have passed a plane in the drift p -> p2
void add_crossings(World& w);          ///< adds them to the totals, in storage order (I3)

// --- add_ons.cpp: what laws add to the plain step -----------------------------------------------------------------
void configure_add_ons(World& w);  ///< features, coefficients; refuses impossible attraction
void narrow_add_ons(World& w, Chunk& c, NarrowArgs& a, std::size_t room);  ///< narrow phase with extra history or necks
void evaluate_add_ons(const World& w, Chunk& c, std::int64_t k0, Block& b, BlockBuffers& buffers);
/// Drops wall contacts that neither touch nor hang on a neck; returns how many of the n stay.
int keep_wall_contacts(const World& w, Row i, WallContact* found, std::int32_t* from, int n);
/// Moments and cohesion of wall contacts k0 .. k0 + b.n of wall_next, whose law has just run.
void wall_add_ons(World& w, Chunk& c, std::size_t k0, Block& b);
void clear_moments(const World& w, Chunk& c);
void fold_moments(const World& w, Chunk& c);  ///< moment rows into the torque lanes of the force rows

// --- step_graph.cpp -----------------------------------------------------------------------------------------------
/// What has to happen at the start of the present step.
struct Decision {
  bool stop = false, structure = false, rebuild = false;
};
Decision check_step(World& w, std::int64_t target);  ///< failures, removals, displacement check
void insert_step(World& w);                          ///< events and batches of the present step
void sort_step(World& w);                            ///< sort epoch if the present step is one
/// Rebuilds the lists. forced: not because of a displacement.
void rebuild_step(World& w, bool forced);
void finish_step(World& w);                     ///< swaps buffers, reduces energies, advances n
void run_graph(World& w, std::int64_t target);  ///< throws the first failure
std::string graph_picture(const World& w);

// --- observe.cpp --------------------------------------------------------------------------------------------------
Energies energies_of(const World& w);
/// Energy rows of the contacts of the present positions, as World::energy; only with energies (frame.cpp).
Column<double> energy_rows(const World& w);
double kinetic_energy_of(const World& w);
Frame frame_of(const World& w, const FrameRequest& request);  ///< frame.cpp
Plan plan_of(const World& w);
std::size_t bytes_of(const World& w);
std::int64_t audit_lists(const World& w);  ///< what touches and is in no list (audit.cpp)

/// Runs fn(chunk) over all chunks in parallel, each on the thread of its share, isolated from the graph (a waiting
/// thread may steal no graph node).
void for_chunks(World& w, void (*fn)(World&, Chunk&));

}  // namespace talus
