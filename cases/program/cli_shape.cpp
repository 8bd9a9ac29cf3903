// `talus shape MESH --spheres N`: a clump of spheres that fills a watertight mesh, as a table of x, y, z, radius.
// Invariant: an existing file is never replaced unless asked, and the table appears whole or not at all.
#include "cases/program/cli_shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cases/program/cli_console.hpp"
#include "core/base/error.hpp"
#include "core/base/text.hpp"
#include "core/io/atomic_file.hpp"
#include "core/shapes/clump_mesh.hpp"

namespace talus::cli {
namespace fs = std::filesystem;
namespace {

std::string table_text(const shapes::MeshClump& c, const std::string& mesh) {
  const auto& p = c.clump;
  std::string text = fmt::format(
      "# clump of {} spheres from {}\n# volume {:.17g}, centre {:.17g} {:.17g} {:.17g}\n# inertia about the centre for "
      "a "
      "density of 1: xx {:.17g} yy {:.17g} zz {:.17g} xy {:.17g} xz {:.17g} yz {:.17g}\nx,y,z,radius\n",
      c.spheres.size(), escaped_line(mesh), p.volume, p.centre.x, p.centre.y, p.centre.z, p.inertia[0], p.inertia[1],
      p.inertia[2], p.inertia[3], p.inertia[4], p.inertia[5]);
  for (const shapes::SubSphere& s : c.spheres)
    text += fmt::format("{:.17g},{:.17g},{:.17g},{:.17g}\n", s.x.x, s.x.y, s.x.z, s.r);
  return text;
}

void report(const shapes::MeshClump& c, const std::string& to, int asked) {
  put("{}: {} spheres{}, radii {:.4g} to {:.4g} m\n", shown_path(to), c.spheres.size(),
      static_cast<int>(c.spheres.size()) < asked ? " (they cover the grid: a finer --grid takes more)" : "",
      std::min_element(c.spheres.begin(), c.spheres.end(), [](auto& a, auto& b) { return a.r < b.r; })->r,
      std::max_element(c.spheres.begin(), c.spheres.end(), [](auto& a, auto& b) { return a.r < b.r; })->r);
  put("volume {:.6g} m3, of the mesh {:.6g} m3: {:+.2f} %\n", c.clump.volume, c.mesh.volume, 100 * c.volume_error);
  put("inertia: components within {:.2f} % of the largest moment of the mesh; centres {:.3g} m apart\n",
      100 * c.inertia_error, c.centre_error);
  if (c.growth > 0) put("spheres were grown by {:.4g} m and stick out of the mesh by at most that\n", c.growth);
  if (c.clump.volume_error > 0)
    put("the clump's own volume and inertia are known to {:.1e} and {:.1e}\n", c.clump.volume_error,
        c.clump.inertia_error);
}

}  // namespace

int shape(const ShapeOptions& options) {
  const std::string& mesh_file = options.mesh;
  const std::string to = options.out.empty() ? fs::path(mesh_file).stem().string() + ".csv" : options.out;
  std::error_code ignored;
  if (fs::equivalent(mesh_file, to, ignored))
    throw Error(ErrorCode::usage, "is the mesh itself", to, "give another --out");
  if (fs::exists(to) && (!options.overwrite || !fs::is_regular_file(to)))
    throw Error(ErrorCode::usage, "is there already", to, "--overwrite replaces a file, --out names another");
  const Mesh mesh = read_mesh(mesh_file, {options.scale, {}, {}}, 0);
  const shapes::MeshClump clump = shapes::clump_of_mesh(mesh, {options.spheres, options.grid, options.grow});
  write_file_atomic(to, table_text(clump, mesh_file));
  if (!options.quiet) report(clump, to, options.spheres);
  return 0;
}

}  // namespace talus::cli
