// Contacts with superquadrics among those of a block: what their true surfaces say in place of the spheres that hold
// them, before the law and after it. Who calls it: ContactBlocks, where the scene has superquadrics. Invariants: I3
// (forces are summed contact by contact in list order), I4, I5 (a pair that the spheres bring together has no history
// of the law until its surfaces touch), I8 (both owners of a pair across chunks find the same bits: a pair is always
// solved from its lower row).
//
// History columns behind those of the law: the normal of the last step, from i to j, where Newton's method starts; and,
// while the surfaces touch, the sum of both arms (from centre to contact point), whose difference is that of the
// centres. Their means with the present ones belong to n-1/2, as the velocities do. Pairs that do not touch keep a
// normal along which they are apart: while it parts them, one support function of each body says so, and no solver is
// asked. What is decided, and kept, is a function of the pair's state alone.
#pragma once

#include <cstdint>

#include "scheduler/nodes/contact_blocks.hpp"
#include "scheduler/nodes/surface.hpp"

namespace talus {

/// Columns that change sign with the order of the partners.
inline constexpr unsigned k_shaped_flips = 0b000111;

struct ShapedBatch;
struct ShapedLane;
struct ShapedLanes;

class ShapedContacts {
 public:
  ShapedContacts(const Rules& rules, const Clock& clock, const Rows& rows, Chunk& c);

  /// After the gather pass: solves the pairs from k0 on and gives the law their geometry.
  void prepare(std::int64_t k0, Block& b, BlockBuffers& buffers);
  /// After the law: pairs that do not touch leave nothing behind.
  void settle(const Block& b) const;
  /// Adds the block's force rows to those of the chunk.
  void scatter(const ScatterArgs& to, const Block& b) const;

  bool shaped(int k) const noexcept { return kind_[k] != Kind::spheres; }
  bool touches(int k) const noexcept { return kind_[k] != Kind::apart; }
  /// From the centre of i to the contact point, of a shaped contact [m].
  Vec3 arm(int k) const noexcept { return arm_i_[k]; }
  Vec3 other_arm(int k) const noexcept { return arm_j_[k]; }  ///< from that of j

 private:
  enum class Kind : std::uint8_t { spheres, apart, touch };
  struct Answer;

  /// Solved here alone, not by the owner of another chunk, too.
  bool interior(std::int64_t at) const noexcept { return at >= c_.contacts.end[0] && at < c_.contacts.end[1]; }
  void guess(int k, std::int64_t at, Row i, Row j, const Block& b, ShapedLanes& lanes);
  void part(std::int64_t k0, const Block& b, ShapedLanes& lanes, BlockBuffers& buffers);
  void solve_quick(std::int64_t k0, ShapedLanes& lanes, BlockBuffers& buffers);
  void solve_hard(std::int64_t k0, ShapedBatch& hard, BlockBuffers& buffers);
  void leave(int k, std::int64_t at, BlockBuffers& buffers);
  /// Of a row of contact k: of the chunk's from the scratch, of another as found once per contact.
  const Surface& surface(int k, Row i) const;
  void queue(int k, std::int64_t at, Row i, Row j, const Block& b, ShapedLanes& lanes) const;
  bool between_spheres(Row i, Row j) const;
  static Answer safe_answer(const ShapedLane& q, double share);
  Answer answer(int lane, std::int64_t at, const ShapedBatch& batch);
  void give(int lane, std::int64_t k0, const ShapedBatch& batch, BlockBuffers& buffers);
  void give_apart(int k, BlockBuffers& buffers) const;
  void judge_depth(std::int64_t slot, Row i, Row j, double overlap, double inner);

  const Rules& rules_;
  const Rows& rows_;
  Chunk& c_;
  bool relaxing_;
  Kind kind_[k_block];
  Vec3 arm_i_[k_block], arm_j_[k_block];          // [m]
  double weight_i_[k_block], weight_j_[k_block];  // of the contact's stiffness: its answer over 1/m
};

}  // namespace talus
