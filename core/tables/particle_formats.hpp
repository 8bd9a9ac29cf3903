// The formats of particle files. Who calls it: core/tables/particle_file.cpp only.
#pragma once

#include "core/tables/particle_file.hpp"

namespace talus {

/// A text with one particle per row and a row of column names; see read_particle_file().
ParticleFile parse_particle_table(std::string_view text, const std::string& name, std::span<const Material> materials,
                                  std::span<const ShapeSpec> shapes, int shape);

/// One of the first lines is "N atoms".
bool is_lammps_data(std::string_view text);
ParticleFile parse_lammps_data(std::string_view text, const std::string& name, std::span<const Material> materials);

}  // namespace talus
