// Mesh files: which reader, from file to frame, and what to say about the result. Who calls it: core/walls/walls.cpp.
// Invariants: see the header. The readers are our own: the library that suggests itself (assimp 5.2) keeps coordinates
// in single precision, opens further files that a mesh names, and crashes or hangs on damaged input.
#include "core/meshes/mesh_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "core/base/error.hpp"
#include "core/base/memory.hpp"
#include "core/base/input_file.hpp"
#include "core/meshes/mesh_text.hpp"

namespace talus {
namespace {

constexpr std::uint64_t k_most_bytes = std::uint64_t{1} << 30;
constexpr double k_noticeable = 1e-3;  // of the smallest radius: a common overlap

const InputKind k_kind{ErrorCode::scene, "mesh", k_most_bytes, "a path in a scene is relative to the scene file"};

std::string extension_of(const std::string& name) {
  std::string e = std::filesystem::path(name).extension().string();
  for (char& c : e)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return e.empty() ? e : e.substr(1);
}

using Parser = mesh_io::RawMesh (*)(std::string_view, const std::string&);

Parser parser_of(const std::string& name) {
  const std::string e = extension_of(name);
  if (e == "stl") return mesh_io::parse_stl;
  if (e == "obj") return mesh_io::parse_obj;
  if (e == "ply") return mesh_io::parse_ply;
  mesh_io::fail(name, 0, "unknown mesh format " + mesh_io::quoted(e), "allowed: stl, obj, ply");
}

/// a + b = sum + rest exactly (Knuth).
double two_sum(double a, double b, double& rest) noexcept {
  const double sum = a + b, part = sum - a;
  rest = (a - (sum - part)) + (b - part);
  return sum;
}

/// scale * x + shift - corner in twice the precision, rounded at the end.
double placed(double scale, double x, double shift, double corner) noexcept {
  double rest_shift = 0, rest_corner = 0;
  const double product = scale * x, rest = std::fma(scale, x, -product);
  const double shifted = two_sum(product, shift, rest_shift);
  const double there = two_sum(shifted, -corner, rest_corner);
  return there + (rest_corner + (rest_shift + rest));
}

}  // namespace

double Mesh::rounding_at(Vec3 p) const noexcept {
  double far = 0;
  for (int k = 0; k < 3; ++k) far = fmax2(far, std::fabs(p[k] - offset[k]));
  return unit * far;
}

Mesh parse_mesh(std::string_view bytes, const std::string& name, const MeshFrame& frame, double largest_diameter) {
  const Parser parse = parser_of(name);
  if (bytes.empty()) mesh_io::fail(name, 0, "the file is empty");
  mesh_io::RawMesh raw = parse(bytes, name);
  Mesh mesh;
  mesh.report.file = name;
  mesh.report.notes = std::move(raw.notes);
  mesh.unit = raw.unit;
  mesh.offset = frame.shift - frame.corner;
  mesh.points = std::move(raw.points);
  mesh.facets = std::move(raw.facets);
  double largest = 0;
  for (Vec3& p : mesh.points)
    for (int k = 0; k < 3; ++k) {
      largest = fmax2(largest, std::fabs(p[k]));
      p[k] = placed(frame.scale, p[k], frame.shift[k], frame.corner[k]);
    }
  mesh.report.rounding = raw.unit * largest * std::fabs(frame.scale);
  check_mesh(mesh, largest_diameter);
  return mesh;
}

Mesh read_mesh(const std::string& path, const MeshFrame& frame, double largest_diameter) {
  parser_of(path);
  const std::string bytes = read_input_text(path, k_kind);
  // corners, facets, edges while they are checked: up to ten times the most compact file
  require_memory(10 * static_cast<double>(bytes.size()), "reading this mesh", path, "a coarser mesh");
  return parse_mesh(bytes, path, frame, largest_diameter);
}

std::string describe(const MeshReport& r) {
  const Vec3 e = r.upper - r.lower;
  std::string text = fmt::format("{} facets", r.facets_read - r.dropped());
  if (r.parts > 1) text += fmt::format(" in {} parts", r.parts);
  text += r.watertight ? fmt::format(", watertight, {:.4g} m3", r.volume) : ", not watertight";
  text += fmt::format(", {:.4g} x {:.4g} x {:.4g} m", e.x, e.y, e.z);
  const auto count = [&](std::int64_t n, const char* one, const char* more) {
    if (n > 0) text += fmt::format(", {} {}", n, n == 1 ? one : more);
  };
  count(r.open_edges, "open edge", "open edges");
  count(r.forked_edges, "edge of more than two facets", "edges of more than two facets");
  count(r.flipped, "flipped facet", "flipped facets");
  count(r.degenerate, "facet without area dropped", "facets without area dropped");
  count(r.duplicate, "duplicate facet dropped", "duplicate facets dropped");
  count(r.welded, "vertex joined to a neighbour", "vertices joined to neighbours");
  return text;
}

std::string doubts(const MeshReport& r, double smallest_radius) {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : "; ") + what; };
  if (r.degenerate > 0) add(fmt::format("{} of {} facets have no area and were dropped", r.degenerate, r.facets_read));
  if (r.duplicate > 0) add(fmt::format("{} facets occur twice and were dropped", r.duplicate));
  if (r.forked_edges > 0) add(fmt::format("{} edges have more than two facets", r.forked_edges));
  if (r.holes > 0)
    add(fmt::format("{} where a facet is missing; {} open edges in all",
                    r.holes == 1 ? "a hole" : fmt::format("{} holes", r.holes), r.open_edges));
  for (const std::string& note : r.notes) add(note);
  if (smallest_radius > 0 && r.rounding > k_noticeable * smallest_radius)
    add(
        fmt::format("its coordinates are given to {:.2g} m only, {:.2g} of the smallest radius; write more digits, or "
                    "shift the mesh towards the origin before it is exported",
                    r.rounding, r.rounding / smallest_radius));
  return text;
}

}  // namespace talus
