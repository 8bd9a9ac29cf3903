// Mesh files. Who calls it: core/walls.cpp. Invariants: see the header. assimp stores coordinates as float, whatever
// the file holds: `rounding` says how far a vertex may be off, and the users of a mesh take coplanarity to that
// tolerance.
#include "core/io/mesh_file.hpp"

#include <assimp/BaseImporter.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "core/error.hpp"

namespace talus {
namespace {

constexpr const char* k_formats = "stl, obj, ply";

[[noreturn]] void fail(const std::string& file, const std::string& what, const std::string& cure = {}) {
  throw Error(ErrorCode::scene, what, "mesh " + file, cure);
}

std::string lower_extension(const std::string& path) {
  std::string e = std::filesystem::path(path).extension().string();
  for (char& c : e)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return e.empty() ? e : e.substr(1);
}

/// Refuses what assimp would answer with a vague message or an endless allocation.
void check_bytes(const std::string& path, const std::string& extension) {
  std::error_code ec;
  if (!std::filesystem::is_regular_file(path, ec)) fail(path, "no such file", "the path is relative to the scene file");
  const auto bytes = std::filesystem::file_size(path, ec);
  if (ec) fail(path, "cannot be read: " + ec.message());
  if (bytes == 0) fail(path, "the file is empty");
  std::ifstream in(path, std::ios::binary);
  std::array<char, 84> head{};
  in.read(head.data(), head.size());
  const auto got = in.gcount();
  if (!in.is_open() || got == 0) fail(path, "cannot be read");
  if (extension != "stl" || std::memcmp(head.data(), "solid", 5) == 0) return;
  if (got < 84) fail(path, fmt::format("a binary STL has at least 84 bytes, this file has {}", bytes));
  std::uint32_t n = 0;
  for (int k = 3; k >= 0; --k) n = n << 8 | static_cast<unsigned char>(head[80 + k]);
  if (bytes != 84 + 50 * static_cast<std::uintmax_t>(n))
    fail(path,
         fmt::format("a binary STL of {} facets has {} bytes, this file has {}", n, 84 + std::uintmax_t{50} * n, bytes),
         "write the file again");
}

/// Only the importers of the promised formats stay: a file cannot select another parser by its content.
void keep_promised_importers(Assimp::Importer& importer) {
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    const aiImporterDesc* about = importer.GetImporterInfo(i);
    const std::string extensions = about != nullptr && about->mFileExtensions != nullptr ? about->mFileExtensions : "";
    if (extensions == "stl" || extensions == "obj" || extensions == "ply") continue;
    Assimp::BaseImporter* other = importer.GetImporter(i);
    importer.UnregisterLoader(other);
    delete other;  // unregistering hands over its ownership
  }
}

bool finite(Vec3 a) { return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z); }

/// Gives every set of equal vertices the index of its first member (in file order); unused vertices vanish.
void join_vertices(Mesh& mesh) {
  const auto& p = mesh.points;
  std::vector<std::int32_t> order(p.size());
  std::iota(order.begin(), order.end(), 0);
  auto less = [&](std::int32_t a, std::int32_t b) {
    if (p[a].x != p[b].x) return p[a].x < p[b].x;
    if (p[a].y != p[b].y) return p[a].y < p[b].y;
    if (p[a].z != p[b].z) return p[a].z < p[b].z;
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<std::int32_t> first(p.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && p[order[k]].x == p[order[k - 1]].x && p[order[k]].y == p[order[k - 1]].y &&
                      p[order[k]].z == p[order[k - 1]].z;
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  std::vector<std::int32_t> index(p.size(), -1);
  std::vector<Vec3> kept;
  for (auto& f : mesh.facets)
    for (std::int32_t& v : f) {
      std::int32_t& to = index[first[v]];
      if (to < 0) to = static_cast<std::int32_t>(kept.size()), kept.push_back(p[first[v]]);
      v = to;
    }
  mesh.points = std::move(kept);
}

/// Height over the longest side, or 0 [m].
double lowest_height(Vec3 a, Vec3 b, Vec3 c, double* longest) {
  const double ab = norm2(b - a), bc = norm2(c - b), ca = norm2(a - c);
  *longest = std::sqrt(fmax2(ab, fmax2(bc, ca)));
  const Vec3 n = ab >= bc && ab >= ca ? cross(a - c, b - c) : (bc >= ca ? cross(b - a, c - a) : cross(c - b, a - b));
  return *longest > 0 ? std::sqrt(norm2(n)) / *longest : 0;
}

void drop_degenerate(Mesh& mesh) {
  std::int64_t first_bad = -1;
  std::size_t kept = 0;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const auto& t = mesh.facets[f];
    double longest = 0;
    const double height = lowest_height(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], &longest);
    if (height > fmax2(1e-12 * longest, 0.5 * mesh.report.rounding)) {
      mesh.facets[kept++] = t;
    } else if (first_bad < 0) {
      first_bad = static_cast<std::int64_t>(f) + 1;
    }
  }
  mesh.report.degenerate = static_cast<std::int64_t>(mesh.facets.size() - kept);
  if (2 * mesh.report.degenerate > static_cast<std::int64_t>(mesh.facets.size()))
    fail(mesh.report.file,
         fmt::format("{} of {} facets have no area, the first is facet {}", mesh.report.degenerate, mesh.facets.size(),
                     first_bad),
         "at most half may be degenerate; export the mesh again");
  mesh.facets.resize(kept);
}

void drop_duplicates(Mesh& mesh) {
  std::vector<std::pair<std::array<std::int32_t, 3>, std::int32_t>> keys;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    auto k = mesh.facets[f];
    std::sort(k.begin(), k.end());
    keys.emplace_back(k, static_cast<std::int32_t>(f));
  }
  std::sort(keys.begin(), keys.end());
  std::vector<char> drop(mesh.facets.size(), 0);
  for (std::size_t k = 1; k < keys.size(); ++k)
    if (keys[k].first == keys[k - 1].first) drop[keys[k].second] = 1, ++mesh.report.duplicate;
  std::size_t kept = 0;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f)
    if (!drop[f]) mesh.facets[kept++] = mesh.facets[f];
  mesh.facets.resize(kept);
}

/// Counts open and forked edges, and the facets whose winding disagrees with the majority of their connected part.
void examine_topology(Mesh& mesh) {
  const auto edges = sorted_edges(mesh.facets);
  struct Link {
    std::int32_t from, to;
    bool turned;
  };
  std::vector<Link> links;
  for (std::size_t k = 0, end = 0; k < edges.size(); k = end) {
    end = k + 1;
    while (end < edges.size() && edges[end].from == edges[k].from && edges[end].to == edges[k].to) ++end;
    if (end - k == 1) ++mesh.report.open_edges;
    if (end - k > 2) ++mesh.report.forked_edges;
    if (end - k != 2) continue;
    // Neighbours wound alike run through their common edge in opposite directions.
    const bool turned = edges[k].reversed == edges[k + 1].reversed;
    links.push_back({edges[k].facet, edges[k + 1].facet, turned});
    links.push_back({edges[k + 1].facet, edges[k].facet, turned});
  }
  mesh.report.watertight = mesh.report.open_edges == 0 && mesh.report.forked_edges == 0;
  std::sort(links.begin(), links.end(),
            [](const Link& a, const Link& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
  const std::size_t n = mesh.facets.size();
  std::vector<std::size_t> start(n + 1, 0);
  for (const Link& l : links) ++start[l.from + 1];
  for (std::size_t f = 0; f < n; ++f) start[f + 1] += start[f];
  std::vector<signed char> side(n, 0);
  std::vector<std::int32_t> part;
  for (std::size_t seed = 0; seed < n; ++seed) {
    if (side[seed] != 0) continue;
    side[seed] = 1;
    part.assign(1, static_cast<std::int32_t>(seed));
    std::int64_t minus = 0;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const std::int32_t f = part[k];
      if (side[f] < 0) ++minus;
      for (std::size_t l = start[f]; l < start[f + 1]; ++l)
        if (side[links[l].to] == 0) {
          side[links[l].to] = static_cast<signed char>(links[l].turned ? -side[f] : side[f]);
          part.push_back(links[l].to);
        }
    }
    mesh.report.flipped += std::min(minus, static_cast<std::int64_t>(part.size()) - minus);
  }
}

}  // namespace

std::vector<EdgeUse> sorted_edges(std::span<const std::array<std::int32_t, 3>> facets) {
  std::vector<EdgeUse> edges;
  edges.reserve(3 * facets.size());
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = facets[f][k], b = facets[f][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(f), a > b});
    }
  std::sort(edges.begin(), edges.end(), [](const EdgeUse& a, const EdgeUse& b) {
    if (a.from != b.from) return a.from < b.from;
    return a.to != b.to ? a.to < b.to : a.facet < b.facet;
  });
  return edges;
}

void check_mesh(Mesh& mesh, double largest_diameter) {
  MeshReport& r = mesh.report;
  r.facets_read = static_cast<std::int64_t>(mesh.facets.size());
  if (mesh.facets.empty()) fail(r.file, "the file holds no facets", "expected triangles or polygons");
  for (std::size_t f = 0; f < mesh.facets.size(); ++f)
    for (const std::int32_t v : mesh.facets[f]) {
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.points.size())
        fail(r.file, fmt::format("facet {} names vertex {}, there are {}", f + 1, v, mesh.points.size()));
      if (!finite(mesh.points[v])) fail(r.file, fmt::format("facet {} has a vertex that is not finite", f + 1));
    }
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (!finite(mesh.points[v])) fail(r.file, fmt::format("vertex {} is not finite", v + 1));
  join_vertices(mesh);
  drop_degenerate(mesh);
  drop_duplicates(mesh);
  r.lower = r.upper = mesh.points[mesh.facets[0][0]];
  for (const auto& f : mesh.facets)
    for (const std::int32_t v : f)
      for (int k = 0; k < 3; ++k) {
        r.lower[k] = fmin2(r.lower[k], mesh.points[v][k]);
        r.upper[k] = fmax2(r.upper[k], mesh.points[v][k]);
      }
  const double across = std::sqrt(norm2(r.upper - r.lower));
  if (across < largest_diameter)
    fail(r.file, fmt::format("the mesh is {:.4g} m across, the largest particle {:.4g} m", across, largest_diameter),
         "check wall.scale: a file in mm needs scale = 0.001");
  examine_topology(mesh);
}

Mesh read_mesh(const std::string& path, double scale, Vec3 shift, double largest_diameter) {
  const std::string extension = lower_extension(path);
  if (extension != "stl" && extension != "obj" && extension != "ply")
    fail(path, "unknown mesh format \"" + extension + "\"", std::string("allowed: ") + k_formats);
  check_bytes(path, extension);

  Assimp::Importer importer;
  keep_promised_importers(importer);
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(path, aiProcess_Triangulate);
  } catch (const std::exception& e) {
    fail(path, std::string("cannot be read: ") + e.what());
  }
  if (scene == nullptr) fail(path, std::string("cannot be read: ") + importer.GetErrorString());

  Mesh mesh;
  mesh.report.file = path;
  double largest = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const auto base = static_cast<std::int32_t>(mesh.points.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const auto& p = part.mVertices[v];
      const Vec3 x{p.x, p.y, p.z};
      for (int k = 0; k < 3; ++k) largest = fmax2(largest, x[k] < 0 ? -x[k] : x[k]);
      mesh.points.push_back(scale * x + shift);
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines of a drawing bound nothing
      mesh.facets.push_back({base + static_cast<std::int32_t>(face.mIndices[0]),
                             base + static_cast<std::int32_t>(face.mIndices[1]),
                             base + static_cast<std::int32_t>(face.mIndices[2])});
    }
  }
  mesh.report.rounding = 0x1p-23 * largest * (scale < 0 ? -scale : scale);
  check_mesh(mesh, largest_diameter);
  return mesh;
}

}  // namespace talus
