// Options of `talus shape`, and the command. See cli.hpp for what commands throw and return.
#pragma once

#include <string>

namespace talus::cli {

struct ShapeOptions {
  std::string mesh;   ///< STL, OBJ or PLY file
  std::string out;    ///< table; empty: <mesh name>.csv
  int spheres = 0;    ///< how many
  int grid = 40;      ///< candidates along the longest side of the mesh
  double scale = 1;   ///< metres per unit of the mesh file
  bool grow = false;  ///< to the volume of the mesh
  bool quiet = false, overwrite = false;
};

/// Error{scene} for the mesh, Error{usage} for the table's name, Error{io}.
int shape(const ShapeOptions& options);

}  // namespace talus::cli
