// Triangles of a file.
#include <fmt/format.h>

#include <filesystem>

#include "core/walls/shapes/faceted.hpp"

namespace talus {
namespace {

void check(const WallSpec& w) {
  require_of_wall(!w.file.empty(), w, "a mesh wall needs a file", "file = \"name.stl\"");
  require_of_wall(w.scale != 0, w, "scale is 0", "e.g. 0.001 for a file in mm");
}

std::string path_of(const Scene& scene, const WallSpec& w) {
  const std::filesystem::path file(w.file);
  return (file.is_absolute() ? file : std::filesystem::path(scene.directory) / file).string();
}

/// A wall that rests outside of the domain is a mistake of scale mostly.
void require_inside(const ShapeRequest& q, const MeshReport& r) {
  const Domain& domain = q.scene.domain;
  for (int k = 0; k < 3; ++k)
    require_of_wall(domain.periodic(k) || (r.lower[k] <= domain.upper[k] && r.upper[k] >= domain.lower[k]), q.spec,
                    fmt::format("mesh {} lies outside the domain: {} from {:.4g} to {:.4g} m", r.file, "xyz"[k],
                                r.lower[k] + q.spec.corner[k], r.upper[k] + q.spec.corner[k]),
                    "check wall.scale and wall.shift: a file in mm needs scale = 0.001");
}

std::unique_ptr<const Shape> make(const ShapeRequest& r) {
  const WallSpec& w = r.spec;
  const Mesh mesh = read_mesh(path_of(r.scene, w), {w.scale, w.shift, w.corner}, r.largest_diameter);
  if (!w.motion.any()) require_inside(r, mesh.report);
  auto shape = std::make_unique<Faceted>(mesh, r);
  shape->mesh = mesh.report;
  return shape;
}

std::optional<Mesh> enclosing(const Scene& scene, const WallSpec& w) {
  Mesh mesh = read_mesh(path_of(scene, w), {w.scale, w.shift, {}}, 0);
  if (mesh.report.open_edges > 0) return std::nullopt;
  return mesh;
}

}  // namespace

const ShapeKind k_mesh_shape{WallShape::mesh, check, make, enclosing};

}  // namespace talus
