// Initial states from files. Who calls it: core/grains/insertion.cpp. Invariants: rows keep their order (LAMMPS:
// ascending id); every value is finite and every radius positive on return; every error names file and row.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// Columns of one file; `w` is zero where the file has none.
struct ParticleFile {
  std::vector<Vec3> x, v, w;                ///< [m], [m/s], [rad/s]
  std::vector<double> r;                    ///< [m]; of bodies that of the sphere of equal volume, or 0
  std::vector<std::uint8_t> material;       ///< empty where the file does not say
  std::vector<std::uint8_t> fixed;          ///< empty where the file does not say
  std::vector<std::int64_t> row;            ///< line in the file, from 1
  std::vector<std::int32_t> shape;          ///< index into the scene's shapes, -1: a sphere; empty: all are spheres
  std::vector<double> scale;                ///< of bodies, 0: their radius says it; empty where `shape` is
  std::vector<std::array<double, 4>> turn;  ///< of bodies: unit quaternion w, x, y, z; empty where `shape` is
  std::vector<std::int64_t> id;             ///< table: empty where the file has none, or none that are unique numbers
  std::optional<std::array<Vec3, 2>> box;   ///< LAMMPS: bounds stated in the file [m]
  std::vector<std::string> notes;           ///< what was ignored or assumed, one line each, with the file's name
  std::size_t size() const noexcept { return x.size(); }
};

/// Reads a table or a LAMMPS data file, either of them plain or gzip-compressed; the format is told from the content.
/// Error{scene} with "file:row" in one line; for a file of another kind (UTF-16, XML, a dump, a workbook) with its
/// kind.
///
/// Table: a header row that names x, y, z, radius (or diameter) and optionally vx, vy, vz (else 0), wx, wy, wz,
/// material (by name or by index from 0), fixed, in any order; then one row per particle. Names of other programs are
/// known (core/tables/particle_columns.hpp), other columns are ignored. Separated by comma, semicolon, tab, bar or
/// blanks; values may be quoted; decimal commas where the separator is none. Comment lines begin with #, % or //.
///
/// Bodies that are no spheres: column shape (name or index from 0; empty or "-": a sphere); then x, y, z is the centre
/// of mass, the size is `scale`, or radius or diameter of the sphere of equal volume, and qw, qx, qy, qz turns the axes
/// in which the shape is given into those of the domain. `shape`: of rows that name none.
///
/// LAMMPS: atom_style sphere, "id type diameter density x y z [image flags]"; type t is material t-1, whose density
/// must agree to 1e-4. Sections and counts without a meaning for spheres are ignored.
ParticleFile read_particle_file(const std::string& path, std::span<const Material> materials,
                                std::span<const ShapeSpec> shapes = {}, int shape = -1);

/// The text of a plain or gzip-compressed file. Error{scene}: it cannot be read, is empty or too large.
std::string read_particle_text(const std::string& path);

/// The same from text in memory; `name` stands for the file in messages.
ParticleFile parse_particles(std::string_view text, const std::string& name, std::span<const Material> materials,
                             std::span<const ShapeSpec> shapes = {}, int shape = -1);

/// What to say about the box of a LAMMPS file that is not the given one; "" where there is nothing to say.
std::string box_note(const ParticleFile& file, const std::string& name, Vec3 lower, Vec3 upper);

}  // namespace talus
