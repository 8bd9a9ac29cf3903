// Ways of running a scene that may not change it (issue figure 2), and covers of all pairs of their levels.
// Who calls it: exact_trajectory_test, exact_lists_test, levels_test, resume_test, controls_test.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"

namespace talus::determinism {

inline constexpr double k_auto = -1;  ///< level of K: chosen by the run

/// One way of running a scene.
struct Variant {
  ListPolicy policy = ListPolicy::always;
  double k = 200;
  int threads = 1;
  int chunk = 0;  ///< 0: default
  Isa isa = Isa::automatic;

  std::string text() const;
  Scene apply(Scene scene) const;  ///< list settings; none of them belongs to the trajectory
  RunOptions options() const;
};

inline constexpr int k_factors = 5;
using Levels = std::array<int, k_factors>;  ///< index of the level per factor

/// All list policies but `fixed`.
const std::vector<ListPolicy>& exact_policies();

/// Number of levels of each factor on this machine (instruction sets that it has).
Levels level_counts();
Variant variant_of(const Levels& levels);

/// Fewest rows found greedily such that every pair of levels of two factors occurs in some row.
std::vector<Levels> pairwise_cover(const Levels& counts);
/// All combinations.
std::vector<Levels> full_product(const Levels& counts);
/// Pairs of levels that `rows` do not contain.
int uncovered_pairs(const Levels& counts, const std::vector<Levels>& rows);

/// TALUS_FULL=1 in the environment.
bool full_requested();

}  // namespace talus::determinism
