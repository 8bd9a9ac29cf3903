// A list policy: what skins are made from, and what says that lists have expired. A policy is a header in this folder
// with one constant, its line in policies.cpp and its word in ListPolicy. Who asks: SkinRule, skin_check.cpp and what
// makes lists; nobody asks which policy it is. Invariants: I1, I2; why each is exact stands in
// scheduler/lists/README.md.
#pragma once

#include <span>
#include <string>

#include "core/base/types.hpp"
#include "core/scene/scene.hpp"

namespace talus {

struct Chunk;
struct Clock;
struct Contacts;
struct Lists;
struct Rows;
struct Rules;
struct Team;

/// Of what skins are made for the rows of a chunk, in order.
struct SpeedQuery {
  const Rows& rows;
  const Lists& lists;
  const Chunk& chunk;
  Row block_end = -1;  ///< rows below have `block`
  double block = 0;
};

struct Policy {
  /// none; one for all; grown: a speed times K dt.
  enum class Skin { none, common, grown };
  /// Where displacements are checked against skins: each by the integration kernel; the two largest of all by
  /// lists_expired(), since the list was made or in each step; nowhere.
  enum class Check { each, largest, largest_of_step, none };

  ListPolicy word;
  const char* guarantee;
  Skin skin = Skin::grown;
  Check check = Check::each;
  bool has_k = false;      ///< K counts, so the run may choose it
  bool floor = false;      ///< grown skins have a floor, and a cap in radii
  bool terms = false;      ///< with a floor: and a term of the acceleration
  bool drifts = false;     ///< displacements count from where a drift velocity would have taken the row
  bool row_drift = false;  ///< which each row has for itself (Lists::drift)
  bool cuts = false;       ///< lists are cut out of longer ones (inner_list.cpp)
  bool past = false;       ///< skins need what rows have travelled under the last lists (Lists::next_skin)
  bool one_bound = false;  ///< the check has one skin for all rows, so that all must have it
  bool ages = false;       ///< lists end with ListFrame::life as they do with a skin
  double stretch = 1;      ///< reaches may grow to this share of those of Policy local
  double skins_used = 1;   ///< so many skins may a row use up before the lists expire

  /// The speed that a row's skin is made from [m/s], without K the skin itself [m]; none: the row's own speed.
  double (*speed)(SpeedQuery&, Row i, const double* v, double speed2) = nullptr;
  /// Before the skins of a rebuild are set.
  void (*prepare)(const Rules&, const Rows&, const Contacts&, Lists&, Team&) = nullptr;
  /// Once per rebuild, while rows and references are still those of the last one: before a sort epoch.
  void (*note)(const Rules&, const Clock&, const Rows&, const Contacts&, Lists&, Team&) = nullptr;
  /// Whether lists have expired, whatever moves; none: displacements decide.
  bool (*by_step)(const Rules&, const Clock&) = nullptr;
  /// Whether the largest displacements [m] have used up the skin [m] of all.
  bool (*used_up)(const Lists&, double first, double second, double skin) = nullptr;

  std::string name() const { return std::string(enum_word(word)); }
};

std::span<const Policy* const> list_policies();
const Policy& policy_of(ListPolicy policy);

}  // namespace talus
