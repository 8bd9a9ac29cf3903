// Particle frames as text for other programs: CSV tables, LAMMPS dumps, extended XYZ. Who calls it: cases/ (convert).
// Invariants: numbers are the shortest text that reads back to the same double; rows are in id order.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/frame/frame.hpp"
#include "core/scene/scene.hpp"

namespace talus {

/// Header row and one row per particle: id,x,y,z,radius,vx,vy,vz and, where the frame has them,
/// wx,wy,wz,material,fixed, coordination and what parts know of grains (temperature). A source of kind "file" reads it
/// (materials by their index from 0). A body that is no sphere has one row, with radius 0, its shape by name (`shapes`)
/// or index, scale,qw,qx,qy,qz; "-": a sphere.
std::string csv_text(const Frame& frame, std::span<const ShapeSpec> shapes = {});

/// One frame of a LAMMPS dump: id type x y z vx vy vz radius [omegax omegay omegaz]; type = material + 1. `domain`: the
/// box; without it the bounds of the particles.
std::string lammps_dump_text(const Frame& frame, const std::optional<Domain>& domain);

/// One frame of extended XYZ as OVITO and ASE read it: species, id, position, radius, velocity [, angular velocity].
/// `materials`: names for species; M0, M1, … where there are none.
std::string extended_xyz_text(const Frame& frame, const std::optional<Domain>& domain,
                              std::span<const Material> materials);

}  // namespace talus
