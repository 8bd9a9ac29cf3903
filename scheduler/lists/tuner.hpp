// Automatic K: chooses K and the floor of the skins while the run goes, at rebuilds only. Who calls it: rebuild_tuned()
// (interval_ends before the rows move, list_built after the lists are made), walls (wanted()).
// Invariant: it writes nothing but Lists::skin.k_dt, Lists::skin.floor and its own members: list parameters, so a run
// keeps its bits, though not its rebuild steps (they follow measured times). No checkpoint holds any of it.
//
// Model: a step costs C(N) = R / N + b P(N) + c W(N) beyond what lists cannot change: R a rebuild, b a candidate pair
// in the narrow phase, c a candidate of a wall (measured, as medians: only their ratios matter, and their square
// roots), N the interval, P and W the candidates. Nothing else is measured by clock; the rest is counted at every
// rebuild:
// - what each particle has used of its skin: all skins that would have lasted as long follow from the displacements of
//   the interval that ends. Of them the (K, floor) with the least total skin is taken;
// - dP / d ln(skin) and dW / d ln(skin), from a sample of a fresh list: candidates between 3/4 and 1 of their skins.
// Skins for N' steps are N'/N times those for N, so N* = sqrt(R N / (b dP + c dW)): no search, no exploration.
// The first K is guessed from the mean speed. Old intervals count through a moving average of a few rebuilds, so that a
// new regime is met at once.
#pragma once

#include <cstdint>

#include "core/base/types.hpp"

namespace talus {

struct Rules;
struct Clock;
struct Rows;
struct Contacts;
struct Lists;
struct SkinRule;
struct Team;
class WallSet;

/// Median of the last few values; the least of them while there are fewer than three (first ones are slow).
class RecentMedian {
 public:
  void add(double x) noexcept;
  double value() const noexcept;  ///< 0 before the first

 private:
  static constexpr int k_size = 5;
  double last_[k_size] = {};
  int count_ = 0;
};

class SkinTuner {
 public:
  void prepare(const Rules& rules, const SkinRule& skin);
  bool on() const noexcept { return on_; }
  double k() const noexcept { return k_; }
  double floor() const noexcept { return floor_; }
  /// Steps that the present lists are meant to last; 0: nothing is known yet.
  double wanted() const noexcept { return wanted_; }
  /// Learns from the interval that ends now and sets the skins of the next one. Before rows are permuted.
  void interval_ends(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts, Lists& lists,
                     Team& team);
  /// `ticks`: of the rebuild, all threads; `cut`: it was an inner list cut out of the outer one (outer_inner).
  void list_built(const Rules& rules, const Rows& rows, const Contacts& contacts, const Lists& lists,
                  const WallSet& walls, Team& team, double ticks, bool cut);

 private:
  struct Use;
  struct Ticks {
    std::uint64_t narrow = 0, walls = 0, step = 0;
  };
  void guess(const Rules& rules, const Clock& clock, const Rows& rows, Lists& lists);
  Ticks ticks(const Rules& rules, const Team& team) const;
  void sample_walls(const Rules& rules, const Rows& rows, const Contacts& contacts, const Lists& lists,
                    const WallSet& walls, Team& team);
  static double wall_contacts(const Contacts& contacts);
  double list_ticks() const noexcept;
  Use used_skins(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts, const Lists& lists,
                 Team& team) const;
  void choose(const Rules& rules, Lists& lists, const Use& use, double steps);

  bool on_ = false, has_floor_ = false, guessed_ = false, learned_ = false;
  bool sampled_ = false;  ///< the present list was looked at: slots_ and gain_ are its own
  int rest_ = 0;          ///< intervals to come that need no look
  double k_ = 0, floor_ = 0, wanted_ = 0;
  std::int64_t ended_ = -1;                     ///< step of the last call of interval_ends
  std::int64_t cut_ = 0;                        ///< last step whose rebuild came before a skin was used up
  double spacing_ = 0;                          ///< steps between such rebuilds: longer skins are wasted
  double slots_ = 0, contacts_ = 0, gain_ = 0;  ///< of the present list: slots, contacts, dP / d ln skin
  double wall_pairs_ = 0, wall_gain_ = 0;       ///< the same for walls
  Ticks begin_;                                 ///< when the present list was made
  RecentMedian rebuild_, cut_list_, pair_, wall_pair_, step_;  ///< [ticks]
  double cuts_ = 0, cuts_each_ = 0;  ///< cuts since the last rebuild; between two rebuilds, as an average
};

}  // namespace talus
