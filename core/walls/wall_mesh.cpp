// Coplanar patches of mesh facets, and the box as a mesh. Who calls it: core/walls/walls.cpp. Invariants: see the
// header.
#include "core/walls/wall_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace talus {

namespace {

double farthest(Vec3 v) { return fmax2(std::fabs(v.x), fmax2(std::fabs(v.y), std::fabs(v.z))); }

/// True if the facet lies in the plane as far as the file tells where its vertices are; never by more than a thousandth
/// of the facet's length, however coarse the file.
bool lies_in_plane(const Mesh& mesh, const TriangleElement& plane, const TriangleElement& facet) {
  double known = 0, length2 = 0;
  for (const Vec3 v : plane.v) known = fmax2(known, mesh.rounding_at(v));
  for (int k = 0; k < 3; ++k) {
    known = fmax2(known, mesh.rounding_at(facet.v[k]));
    length2 = fmax2(length2, norm2(facet.v[k] - facet.v[(k + 1) % 3]));
  }
  const double tolerance = fmin2(2 * known, 1e-3 * std::sqrt(length2));
  for (const Vec3 v : facet.v)
    if (!(std::fabs(plane_distance(plane, v)) <= tolerance + 0x1p-50 * farthest(v))) return false;
  return true;
}

}  // namespace

double flatness(std::span<const TriangleElement> facets) {
  double off = 0, size = 0;
  for (const TriangleElement& t : facets)
    for (const Vec3 v : t.v) {
      off = fmax2(off, std::fabs(plane_distance(t, v)));
      size = fmax2(size, farthest(v));
    }
  return off + 0x1p-50 * size;
}

std::vector<TriangleElement> make_facets(const Mesh& mesh) {
  const std::size_t n = mesh.facets.size();
  std::vector<TriangleElement> out(n);
  std::vector<double> area(n);
  for (std::size_t f = 0; f < n; ++f) {
    const auto& t = mesh.facets[f];
    const Vec3 a = mesh.points[t[0]], b = mesh.points[t[1]], c = mesh.points[t[2]];
    out[f] = make_triangle(a, b, c);
    area[f] = norm2(cross(b - a, c - a));
  }

  std::vector<std::size_t> start(n + 1, 0);
  std::vector<std::pair<std::int32_t, std::int32_t>> links;
  const auto edges = sorted_edges(mesh.facets);
  for (std::size_t k = 0; k + 1 < edges.size(); ++k)
    if (edges[k].from == edges[k + 1].from && edges[k].to == edges[k + 1].to) {
      links.emplace_back(edges[k].facet, edges[k + 1].facet);
      links.emplace_back(edges[k + 1].facet, edges[k].facet);
    }
  std::sort(links.begin(), links.end());
  for (const auto& l : links) ++start[l.first + 1];
  for (std::size_t f = 0; f < n; ++f) start[f + 1] += start[f];

  std::vector<std::int32_t> seeds(n), patch;
  std::iota(seeds.begin(), seeds.end(), 0);
  std::stable_sort(seeds.begin(), seeds.end(), [&](std::int32_t a, std::int32_t b) { return area[a] > area[b]; });
  std::vector<char> assigned(n, 0);
  for (const std::int32_t seed : seeds) {
    if (assigned[seed]) continue;
    assigned[seed] = 1;
    patch.assign(1, seed);
    for (std::size_t k = 0; k < patch.size(); ++k)
      for (std::size_t l = start[patch[k]]; l < start[patch[k] + 1]; ++l) {
        TriangleElement& t = out[links[l].second];
        if (assigned[links[l].second]) continue;
        if (!lies_in_plane(mesh, out[seed], t)) continue;
        assigned[links[l].second] = 1;
        t.point = out[seed].point;
        if (dot(t.normal, out[seed].normal) < 0) std::swap(t.v[1], t.v[2]);
        t.normal = out[seed].normal;
        patch.push_back(links[l].second);
      }
  }
  return out;
}

Mesh box_mesh(Vec3 lo, Vec3 hi) {
  Mesh m;
  m.report.file = "box";
  for (int k = 0; k < 8; ++k) m.points.push_back({k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z});
  m.facets = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
              {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

}  // namespace talus
