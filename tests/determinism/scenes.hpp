// Scenes whose trajectories must be the same bits under every way of running them, and one-call runs of them.
// Who calls it: tests/determinism/*. Invariants: 600 to 1100 particles, so that chunks of 64 give at least 8; sort
// epochs every 700 steps; all sizes in SI units with grains of about 2 mm.
#pragma once

#include <cstdint>
#include <ostream>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "scheduler/simulation.hpp"

namespace talus::determinism {

inline constexpr std::int64_t k_steps = 2000;      ///< of every trajectory that is compared
inline constexpr std::int64_t k_sort_every = 700;  ///< epochs at 0, 700, 1400: the last two within the run

Scene hopper();          ///< cylinder and cone, moving gate, stream of grains, open bottom; linear law with friction
Scene sheared_bed();     ///< periodic in x and y, frozen bottom, driven top; linear law with friction
Scene gas();             ///< periodic in all directions, frictionless, elastic
Scene pile_on_mesh();    ///< diameters 1:4 falling on a bumpy, rocking mesh, periodic in y; energies on
Scene hertz_drum();      ///< Hertz-Mindlin, two materials, rotating drum, vibrating plane
Scene sticky_drum();     ///< the same with JKR necks, rolling and twisting springs
Scene slipping_drum();   ///< the Hertz drum with partial slip, rolling and twisting springs; energies on
Scene cohesive_pile();   ///< the pile with attraction and constant rolling moments
Scene crossing_walls();  ///< periodic in all directions; walls that move, turn and shake across the sides; rolling

struct NamedScene {
  const char* name;
  Scene (*build)();
};
/// Names the scene in test listings; the default print would show addresses, which differ from build to build.
inline void PrintTo(const NamedScene& s, std::ostream* out) { *out << s.name; }
/// The scenes above.
const std::vector<NamedScene>& scenes();

/// The scene with everything that the part "heat" can do.
Scene heated(Scene s);

/// Writes `bytes` to a file in this process's own temporary folder (removed at exit) and returns its path.
std::string temporary_file(const std::string& name, const std::string& bytes = {});
std::string read_bytes(const std::string& path);

/// OBJ surface z = height(x, y) over [0, 1]^2 with n x n squares, as used by pile_on_mesh; returns the path.
std::string bumpy_mesh(int n, double bump);

/// Checkpoint bytes of the present state.
std::string checkpoint_bytes(const Simulation& sim);

}  // namespace talus::determinism
