// Initial states from files. Who calls it: core/insertion.cpp. Invariants: rows keep their order (LAMMPS: ascending
// id); every value is finite and every radius positive on return; every error names file and row.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene.hpp"
#include "core/types.hpp"

namespace talus {

/// Columns of one file; `w` is zero where the file has none.
struct ParticleFile {
  std::vector<Vec3> x, v, w;               ///< [m], [m/s], [rad/s]
  std::vector<double> r;                   ///< [m]
  std::vector<std::uint8_t> material;      ///< empty where the file does not say
  std::vector<std::uint8_t> fixed;         ///< empty where the file does not say
  std::vector<std::int64_t> row;           ///< line in the file, from 1
  std::optional<std::array<Vec3, 2>> box;  ///< LAMMPS: bounds stated in the file [m]
  std::size_t size() const noexcept { return x.size(); }
};

/// Reads a CSV file (header row naming x,y,z,radius or r,vx,vy,vz and optionally wx,wy,wz, material, fixed, in any
/// order; material by name or by index from 0) or a LAMMPS data file (atom_style sphere: "id type diameter density x y
/// z [image flags]", type t is material t-1, whose density must agree to 1e-4), either of them plain or
/// gzip-compressed. The format is told from the content. Error{scene} with "file:row".
ParticleFile read_particle_file(const std::string& path, std::span<const Material> materials);

/// The same from text in memory; `name` stands for the file in messages.
ParticleFile parse_particles(std::string_view text, const std::string& name, std::span<const Material> materials);

}  // namespace talus
