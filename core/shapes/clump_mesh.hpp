// A clump from a watertight mesh. Who calls it: `talus shape`. Invariants: a function of the mesh and the settings
// alone; without growth every sphere lies inside the mesh.
#pragma once

#include <string>
#include <vector>

#include "core/meshes/mesh_file.hpp"
#include "core/shapes/clump.hpp"

namespace talus::shapes {

struct MeshClumpSettings {
  int spheres = 0;
  int grid = 40;      ///< points along the longest side of the mesh's box
  bool grow = false;  ///< all radii by one length, until the union has the volume of the mesh
};

struct MeshClump {
  std::vector<SubSphere>
      spheres;  ///< in the order in which they were chosen; fewer than asked for where all is covered
  MassProperties mesh, clump;
  double growth = 0;         ///< [m]
  double volume_error = 0;   ///< of the clump against the mesh, relative, with its sign
  double inertia_error = 0;  ///< largest difference of a component, each about its own centre, over the largest moment
  double centre_error = 0;   ///< distance of the two centres [m]
};

/// Mass properties of the inside by the divergence theorem. Error{scene} naming the file where facets are wound against
/// each other.
MassProperties mesh_properties(const Mesh& mesh);

/// Balls about the points of a grid that reach to the surface; of these always the one that covers most of what is not
/// yet covered (greedy set cover of inner balls). Error{scene} naming
/// the file: not watertight, windings, no grid point inside.
MeshClump clump_of_mesh(const Mesh& mesh, const MeshClumpSettings& settings);

}  // namespace talus::shapes
