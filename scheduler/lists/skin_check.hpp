// Validity of the pair lists between rebuilds, for every list policy (core/rules/skin.hpp). Who calls it:
// displacement_check and rebuild nodes (lists_expired), integrate_chunk (travel_chunk), finish_step (note_travel),
// rebuild_lists (prepare_skins), set_skins (SkinSpeeds). Invariants: I1, I2. Policies that the integration kernel's own
// check serves (SkinRule::own_check() false) pay for nothing here.
#pragma once

#include "core/base/types.hpp"
#include "core/rules/skin.hpp"
#include "core/walls/walls.hpp"

namespace talus {

struct World;
struct Chunk;

/// What the lists of the last rebuild rest on, beside x0.
struct ListFrame {
  std::int64_t built = 0;           ///< step of the rebuild
  Row rows = 0;                     ///< rows it has seen
  double life = 1e300;              ///< the lists hold no longer than this [s]
  double stretch = 1;               ///< velocity_profile: factor of reaches
  double rounding = 0;              ///< velocity_profile: what to add to them for drifts in single precision [m]
  double common_speed = 0;          ///< global_velocity: largest speed [m/s]
  double mean_skin = 0;             ///< of its diameter, over particles
  double travelled = 0;             ///< accumulated: sum of the largest travels [m]
  alignas(16) float drift[4] = {};  ///< mean_subtracted: the mean velocity [m/s]
  bool noted = false;               ///< displacement_history: World::next_skin is that of the rebuild to come
};

/// The speed that a particle's skin is made from; displacement_history: the length.
class SkinSpeeds {
 public:
  SkinSpeeds(const World& w, const Chunk& c) : w_(w), c_(c) {}
  double operator()(Row i, const double* v, double speed2);

 private:
  const World& w_;
  const Chunk& c_;
  Row block_end_ = -1;
  double block_ = 0;
};

/// The skin of each row of a chunk for lists that are made now.
class RowSkins {
 public:
  RowSkins(const World& w, const Chunk& c);
  /// [m]; negative: the row is not finite.
  double operator()(Row i);

 private:
  const World& w_;
  SkinRule rule_;
  SkinSpeeds speed_;
  bool acceleration_;
  double inverse_dt_;
};

/// Displacements of row i count from here, up to `skin` [m].
void set_reference(World& w, Row i, double skin);

/// displacement_history: what each row's skin should be, from what it has travelled since the last rebuild. Once per
/// rebuild, while x0 and the rows are still those of the last one: before a sort epoch.
void note_displacements(World& w);
void prepare_skins(World& w);           ///< before the skins of a rebuild are set
void travel_chunk(World& w, Chunk& c);  ///< after the drift of a chunk, for policies with an own check
void note_travel(World& w);             ///< once per step, after all chunks
bool lists_expired(const World& w);     ///< by displacements, not by anything that forces a rebuild
/// |x - x0 - drift t|^2 of a row by minimum image [m2]: what it has used of its skin since the rebuild.
double used2(const World& w, Row i);
/// |x - y|^2 by minimum image [m2].
double distance2(const World& w, const double* x, const double* y);
/// By how many periods a particle at x was wrapped since it was at y.
WallSet::Wraps wraps_of(const World& w, const double* x, const double* y);
/// How far a row may drift in the life of the lists [m], which walls have to allow for.
double drift_reach(const World& w, Row i);

}  // namespace talus
