// Making the lists: skins and cells, search, history, wall candidates; and the sort epoch. Who calls it: the rebuild
// and sort_epoch nodes, set-up from a checkpoint, frames. Invariants: I1, I2, I3 (a rebuild never changes storage
// order), I5.
#pragma once

#include <chrono>
#include <vector>

#include "core/walls/walls.hpp"
#include "scheduler/lists/lists.hpp"
#include "scheduler/lists/skin_check.hpp"
#include "scheduler/reports.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

/// Adds the time since construction or the last lap to a part of the rebuild.
class PartClock {
 public:
  explicit PartClock(RebuildSeconds& seconds) : seconds_(seconds), last_(std::chrono::steady_clock::now()) {}
  void lap(RebuildPart part) {
    const auto now = std::chrono::steady_clock::now();
    seconds_[static_cast<std::size_t>(part)] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  RebuildSeconds& seconds_;
  std::chrono::steady_clock::time_point last_;
};

/// Candidates of one chunk before they are laid into its list: sections lower, interior, higher.
struct Sections {
  const std::int32_t *i[3], *j[3];
  std::int64_t n[3];
};

// rebuild.cpp
/// Cells, lists, history.
void rebuild_lists(const Rules& rules, const Clock& clock, const Rows& rows, Contacts& contacts, Lists& lists,
                   Counters& counters, WallSet& walls, Team& team);
/// The same between the two calls of the tuner; may_cut: or inner lists out of the outer ones, where these allow it.
/// Returns whether it did the latter.
bool rebuild_tuned(const Rules& rules, const Clock& clock, const Rows& rows, Contacts& contacts, Lists& lists,
                   Counters& counters, WallSet& walls, Team& team, bool may_cut);
/// Lays the sections into the chunk's list and merges the contacts of its old one into mask and history.
void replace_list(const Rules& rules, const Rows& rows, Chunk& c, ListScratch& t, const Sections& s);
void count_pairs(const Contacts& contacts, Counters& counters);

/// Counts a rebuild; forced: not because of a displacement.
void count_rebuild(const Clock& clock, const Lists& lists, Counters& counters, bool forced);

// cell_grid.cpp
/// Skins and cell grid.
void fill_cells(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists, const WallSet& walls,
                Team& team);

// sort_epoch.cpp
/// Compacts and permutes rows into Morton order; the lists have to be made anew.
void sort_epoch(const Rules& rules, Rows& rows, Contacts& contacts, Lists& lists, Counters& counters, Team& team);

// hand_over.cpp
/// Gives the contacts of a checkpoint to their chunks, for the rebuild that has to follow.
void distribute_contacts(const Rules& rules, const Rows& rows, Contacts& contacts, Team& team,
                         const std::vector<ContactEntry>& pairs, const std::vector<WallEntry>& walls);

// inner_list.cpp: list policy outer_inner
/// Row i of the inner list: at x, skin `skin` [m] (removed rows: at infinity, without reach).
void set_near(const Rules& rules, const Rows& rows, Lists& lists, Row i, double skin);
/// Keeps the sections as the chunk's outer list, and returns those of the inner one; both live in the scratch.
Sections cut_sections(const Rules& rules, const Rows& rows, const Lists& lists, Chunk& c, ListScratch& t,
                      const Sections* fresh);
/// False: the outer lists do not allow it, nothing but x0 and near is changed.
bool cut_lists(const Rules& rules, const Clock& clock, const Rows& rows, Contacts& contacts, Lists& lists,
               Counters& counters, const WallSet& walls, Team& team);

}  // namespace talus
