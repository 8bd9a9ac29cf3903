// Particle frames from the text files of other programs: LAMMPS dumps and extended XYZ. Who calls it: cases/ (convert).
// Invariants: every frame has all rows that it announces, in id order, ids unique; values are finite and radii
// positive; all frames of a file have the same columns. What is no set of spheres is refused.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/scene/scene.hpp"

namespace talus {

struct TextFrames {
  std::vector<Frame> frames;
  std::vector<std::optional<Domain>> domains;  ///< box of each frame, where the file states it
  std::vector<std::string> species;            ///< XYZ: name of every material index, "" where none is stated
  std::vector<std::string> notes;              ///< what was ignored or assumed, one line each, with the file's name
};

/// Text dumps: rows with x, y, z (or xs, ys, zs in shares of the box, or xu, yu, zu) and radius or diameter; id, type
/// (material = type - 1), vx, vy, vz, omegax, omegay, omegaz where they are there. Times [s] from ITEM: TIME; without
/// it the number of the step. Error{io} with "file:line".
TextFrames parse_lammps_dump(std::string_view text, const std::string& name);

/// Extended XYZ: Properties with pos:R:3 and radius:R:1 (or diameter); species, id, velo (or vel, velocity),
/// angular_velocity (or omega) where they are there; Lattice with Origin, pbc, Time [s], Step. Error{io} with
/// "file:line".
TextFrames parse_extended_xyz(std::string_view text, const std::string& name);

/// Of a plain or gzip-compressed file, by its content. Error{io}.
TextFrames read_text_frames(const std::string& path);

}  // namespace talus
