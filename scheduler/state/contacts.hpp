// Contacts: the chunks that rows are cut into, each with its candidate pairs, its touching pairs and its wall contacts.
// Who writes them: rebuild and sort epochs (lists), narrow phase, contact force, wall contact, integration (each its
// own chunk). Invariants: I3, I5, I7 (a chunk node writes only its own chunk), I8.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/types.hpp"
#include "core/walls/walls.hpp"
#include "kernels/views.hpp"
#include "scheduler/state/extremes.hpp"
#include "scheduler/state/rows.hpp"
#include "scheduler/state/rules.hpp"
#include "scheduler/team/chunk_map.hpp"
#include "scheduler/team/pools.hpp"

namespace talus {

/// Parts of a rebuild; timed apart so that each can be measured from outside (a few clock reads per rebuild and chunk).
enum class RebuildPart : int { skin, keys, sort, fill, search, history, walls, count };
using RebuildSeconds = std::array<double, static_cast<std::size_t>(RebuildPart::count)>;

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

/// Key of a pair in list order.
inline std::uint64_t pair_key(Row i, Row j) noexcept {
  return static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) << 32 | static_cast<std::uint32_t>(j);
}

/// One undirected contact (a < b), as used by sort epochs, checkpoints and hashes; history oriented a - b.
struct ContactEntry {
  Row a = 0, b = 0;
  double h[k_max_columns] = {};
};

/// A grain has passed a flux plane in the present step; net > 0: along the normal.
struct Crossing {
  Row row = 0;
  std::int32_t plane = 0, net = 0;
};

/// Candidate pairs of a chunk: sections lower, interior, higher, each padded to a multiple of 8.
struct PairList {
  Column<std::int32_t> pi, pj;
  Column<std::uint8_t> mask;          ///< bit: touched in the last step
  std::int64_t end[3] = {0, 0, 0};    ///< slots
  std::int64_t pairs[3] = {0, 0, 0};  ///< without padding
};

/// The longer list that policy outer_inner cuts others out of, laid out as PairList.
struct OuterList {
  Column<std::int32_t> pi, pj;
  std::int64_t end[3] = {0, 0, 0};
};

/// Touching pairs of the last step and their history, in the order of the list.
struct PairContacts {
  Column<double> h[k_max_columns];
  std::int64_t end[3] = {0, 0, 0};
  std::int64_t apart[2] = {0, 0};  ///< of them, interior and others: their spheres meet, their surfaces do not
  /// Pairs of superquadrics in the last step: all, and those left to the safe method. Times two: both owners of a pair
  /// across chunks solve it.
  std::int64_t solved[2] = {0, 0};
  std::int32_t run_count = 0;  ///< between narrow phase and contact force: runs in scratch, 0 where none has moved
  /// Keys of the contacts that a sort epoch or a checkpoint has handed to this chunk, each section closed by a last
  /// key; empty where the present list holds them.
  Column<std::uint64_t> distributed;
};

/// Wall candidates of a chunk's rows, and its wall contacts with their history.
struct WallContacts {
  // candidates
  Column<std::int32_t> row;           ///< rows with candidates, ascending
  Column<std::int32_t> begin;         ///< [rows + 1] into element
  std::vector<double> radius;         ///< only with adhesion: R_C of each row towards a wall [m]
  std::vector<std::int32_t> element;  ///< candidates of WallSet, images included
  std::vector<float> distance;        ///< lower bound of each element's distance when the list was made [m]
  std::vector<float> nearest;         ///< least distance of each row [m]
  // contacts
  std::vector<WallState> state;  ///< of the last step, ascending (row, wall, element)
  std::vector<WallState> next;
  std::vector<double> moment, moment_next;  ///< rolling history: moment_columns per entry of state
  std::vector<Vec3> force;                  ///< on the particle, parallel to state
  std::vector<Vec3> point;                  ///< contact points, parallel to state
  std::vector<Vec3> torque;                 ///< moment on the particle; rolling and twisting only
  std::vector<double> power;                ///< work of moving walls in this step, parallel to state
  std::vector<Vec3> arm;                    ///< centre to contact point, parallel to state; superquadrics only [m]
};

/// What a chunk's nodes have found in the last step, for the check.
struct ChunkResults {
  Column<std::int32_t> out;  ///< rows that left; out_count of them
  std::int32_t out_count = 0;
  int expired = 0;
  double travel[2] = {0, 0};  ///< two largest travels, policies with an own check [m]
  std::int32_t unstable_row = -1;
  std::int64_t deep_slot = -1;
  Row deep_rows[2] = {0, 0};    ///< of deep_slot
  std::int64_t deep_wall = -1;  ///< wall contact deeper than allowed, or -1
  double body_row = 0;          ///< largest sum of contact stiffnesses over what answers them, of a body [1/s2]
  ParticleId body_row_of = -1;  ///< number of that body
  ChunkExtremes extremes;       ///< of a sampled step
};

/// Owner of rows [lo, hi).
struct Chunk {
  int index = 0;
  Row lo = 0, hi = 0;
  PairList list;
  OuterList outer;  ///< only with list policy outer_inner
  PairContacts contacts;
  WallContacts wall;
  ChunkResults result;
  Scratch* scratch = nullptr;       ///< from narrow phase to integration
  std::vector<Crossing> crossings;  ///< of the present step, ascending (plane, row); only with flux planes
  RebuildSeconds rebuild_seconds{};
};

struct Contacts {
  int chunk_size = 4096;  ///< of equal chunks; a sort epoch makes as many of equal cost (sort_epoch.cpp)
  ChunkMap chunk_of;
  std::vector<std::unique_ptr<Chunk>> chunks;
  /// Some chunk has something to say about the last step: leavers, a failure, samples of the monitor. Nearly always
  /// none has, and a check that visits every chunk fetches a cache line of each from the core that worked on it.
  std::atomic<bool> news{true};

  int count() const noexcept { return static_cast<int>(chunks.size()); }
  Chunk& operator[](int k) const { return *chunks[static_cast<std::size_t>(k)]; }
  Chunk& of(Row i) const { return (*this)[chunk_of(i)]; }
};

/// Rows per chunk: the scene's choice, else by their number and the threads (chunk_size.cpp).
int choose_chunk(const Rules& rules, const Rows& rows);
void need_chunks(Contacts& contacts, int count);               ///< adds empty ones where there are fewer
void keep_bodies_whole(Contacts& contacts, const Rows& rows);  ///< borders of chunks lie between bodies
void make_chunks(Contacts& contacts, const Rows& rows);  ///< cuts the rows into chunks; keeps existing ones in place
/// What a step of each chunk will cost by its present list and contacts; only ratios count.
std::vector<double> chunk_costs(const Contacts& contacts);
/// Contacts whose lower row is the chunk's, ascending (a, b): over all chunks each contact once, in ascending order.
/// `failed`: the step ended half way, masks and columns may differ.
std::vector<ContactEntry> contacts_of(const Rules& rules, const Chunk& c, bool failed);
std::vector<WallEntry> collect_wall_states(const Rules& rules, const Contacts& contacts);

}  // namespace talus
