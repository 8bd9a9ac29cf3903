// Rules: what the scene decides once and no step changes. Who makes them: start_of(), before any row is there. Who
// reads them: every node. Invariant: nothing in here depends on the particles' present state.
#pragma once

#include <string>
#include <vector>

#include "core/rules/timestep.hpp"
#include "core/scene/scene.hpp"
#include "kernels/bodies/motion_batch.hpp"
#include "kernels/bodies/pair_batch.hpp"
#include "kernels/kernel_table.hpp"
#include "scheduler/state/hooks.hpp"

namespace talus {

/// Which optional parts a scene needs (DESIGN 4, "leaving out"). Decided once from the scene.
struct Features {
  bool rotation = false, history = false, materials = false, walls = false, moving_walls = false, fixed = false;
  bool groups = false, energies = false, insertion = false, events = false, removal = false, periodic = false;
  bool bodies = false;  ///< of several spheres, or superquadrics
  bool superquadrics = false;
  bool moments = false, cohesion = false, adhesion = false, planes = false;
  bool fixed_at_walls = false;  ///< contacts of fixed grains with walls count too: they conduct heat
  int history_columns = 0;      ///< of the law, then those of rolling and twisting, or of superquadrics
  int law_columns = 0, moment_columns = 0;
  bool reff = false;
};

/// The contact law with its coefficients, and what is added to it.
struct LawRules {
  const LawInfo* info = nullptr;
  int variant = 0;
  bool late = false;                       ///< contacts that begin or end act behind all others (Block::late)
  bool trial = false;                      ///< the Coulomb limit is applied by the scatter (KernelTable::trial)
  std::vector<PairParameters> parameters;  ///< particle pairs, and walls (same table: walls are materials)
  LawArgs args{};
  std::vector<AddOnParameters> add_ons;  ///< like parameters; empty without rolling, twisting and cohesion
  std::vector<double> cohesion;          ///< energy densities; empty without cohesion
  std::vector<double> adhesive_range;    ///< AdhesiveArgs::range; empty without adhesion
  MomentArgs moment_args{};
  unsigned moment_flips = 0;
  PairSolver solver = nullptr;  ///< superquadrics only, like the next
  PairGaps gaps = nullptr;
};

/// Bounds that the monitor holds the step to, judged at construction.
struct StepBounds {
  TimeStepReport time_step;
  double unstable = 0;   ///< on row sum / mass [1/s2]
  double wall_step = 0;  ///< how far a wall may go in one step [m]
  double warn_row = 0;   ///< row sum / mass, times dt^2, from which on the monitor warns
};

/// A copy points to the tables of its original.
struct Rules {
  Scene scene;
  RunOptions options;
  Hooks hooks;
  Features has;
  const KernelTable* kernels = nullptr;
  BodyMover mover = nullptr;  ///< scenes with bodies only
  std::string isa_why;
  LawRules law;
  StepBounds bounds;
  int stride = 4;   ///< doubles per velocity and force row (8 with rotation)
  int threads = 1;  ///< asked for; lane_choice says how many work at present
  double r_min = 0, r_max = 0;
  Vec3 size;  ///< domain extent [m]

  int pair_index(int a, int b) const { return a * static_cast<int>(scene.materials.size()) + b; }
  /// History column q changes sign when the partners of a contact are swapped.
  bool flips(int q) const {
    if (q >= has.law_columns) return ((law.moment_flips >> (q - has.law_columns)) & 1U) != 0;
    return has.rotation && ((law.info->flips >> q) & 1U) != 0;
  }
  /// The arguments of the laws in step n.
  LawArgs law_args(std::int64_t n) const {
    LawArgs a = law.args;
    a.start = n == 0 ? 1 : 0;
    return a;
  }
};

void configure_add_ons(Rules& rules);  ///< features, coefficients; refuses impossible attraction (add_ons.cpp)

}  // namespace talus
