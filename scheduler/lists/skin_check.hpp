// Validity of the pair lists between rebuilds, for every list policy (scheduler/lists/policies). Who calls it:
// displacement_check and rebuild nodes (lists_expired), integrate_chunk (travel_chunk), finish_step (note_travel),
// rebuild_lists (prepare_skins), set_skins (RowSkins). Invariants: I1, I2. Policies that the integration kernel's own
// check serves (SkinRule::own_check() false) pay for nothing here.
#pragma once

#include "core/base/types.hpp"
#include "core/walls/walls.hpp"
#include "scheduler/lists/lists.hpp"
#include "scheduler/lists/skin.hpp"
#include "scheduler/team/team.hpp"

namespace talus {

/// The skin of each row of a chunk for lists that are made now.
class RowSkins {
 public:
  RowSkins(const Rules& rules, const Rows& rows, const Lists& lists, const Chunk& c);
  /// [m]; negative: the row is not finite.
  double operator()(Row i);

 private:
  const Rules& rules_;
  const Rows& rows_;
  const Lists& lists_;
  SkinRule rule_;
  SpeedQuery query_;
  bool acceleration_;
  double inverse_dt_;
};

/// Displacements of row i count from here, up to `skin` [m].
void set_reference(const Rules& rules, const Rows& rows, Lists& lists, Row i, double skin);

/// Policy::note, where the policy has one.
void note_displacements(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts,
                        Lists& lists, Team& team);
void prepare_skins(const Rules& rules, const Clock& clock, const Rows& rows, const Contacts& contacts, Lists& lists,
                   Team& team);  ///< before the skins of a rebuild are set
void travel_chunk(const Rules& rules, const Rows& rows, const Lists& lists,
                  Chunk& c);  ///< after the drift of a chunk, for policies with an own check
void note_travel(const Contacts& contacts, Lists& lists);  ///< once per step, after all chunks
bool lists_expired(const Rules& rules, const Clock& clock, const Contacts& contacts, const Lists& lists,
                   const WallSet& walls);  ///< by displacements, not by anything that forces a rebuild
/// |x - x0 - drift t|^2 of a row by minimum image [m2]: what it has used of its skin since the rebuild.
double used2(const Rules& rules, const Clock& clock, const Rows& rows, const Lists& lists, Row i);
/// |x - y|^2 by minimum image [m2].
double distance2(const Rules& rules, const double* x, const double* y);
/// By how many periods a particle at x was wrapped since it was at y.
WallSet::Wraps wraps_of(const Rules& rules, const double* x, const double* y);
/// How far a row may drift in the life of the lists [m], which walls have to allow for.
double drift_reach(const Lists& lists, Row i);

}  // namespace talus
