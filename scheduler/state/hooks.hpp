// Hooks: what tests break in a run on purpose, to see that what should notice it does. The faults themselves live in
// tests/faults.hpp; a run that no test has prepared has none. Who asks: the nodes, through Rules.
#pragma once

#include <cstdint>

namespace talus {

struct Chunk;

struct Hooks {
  double skin = 1;      ///< the check believes in skins so many times as large as those the lists were made for
  bool stretch = true;  ///< lists are made with the stretch of a velocity profile
  /// May change the force rows of a chunk before they are integrated.
  void (*spoil)(std::int64_t step, const Chunk&, double* f) = nullptr;
  /// May sum the contacts of a chunk in another order; `columns`: of their history. [from, to): those that act on both
  /// ends. back: afterwards, the contacts go back to where they were.
  void (*reorder)(int columns, Chunk&, std::int64_t& from, std::int64_t& to, bool back) = nullptr;
};

/// Those of the simulations that are made from now on. Tests alone write it.
inline Hooks hooks_of_tests;

}  // namespace talus
