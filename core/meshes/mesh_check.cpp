// Topology and defects of a mesh. Who calls it: parse_mesh, boxes of core/walls/walls.cpp. Invariants: see
// mesh_file.hpp; every tolerance is what the file gives of the vertices concerned, never a share of the whole mesh.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/meshes/mesh_file.hpp"
#include "core/meshes/mesh_text.hpp"

namespace talus {
namespace {

using Facets = std::vector<std::array<std::int32_t, 3>>;
using mesh_io::fail;

constexpr double k_farthest = 1e12;       // [m]
constexpr double k_needle = 1e-12;        // height over length below which no normal can be known
constexpr double k_slim = 1e-3;           // height over length from which a facet stays, however coarse the file
constexpr double k_weld_edge = 1e-3;      // vertices this near, in shortest edges, may be one
constexpr std::size_t k_weld_tries = 64;  // neighbours looked at

void check_indices(const Mesh& mesh) {
  const std::string& file = mesh.report.file;
  if (mesh.facets.empty()) fail(file, 0, "the file holds no facets", "expected triangles or polygons");
  for (std::size_t f = 0; f < mesh.facets.size(); ++f)
    for (const std::int32_t v : mesh.facets[f]) {
      if (v < 0 || static_cast<std::size_t>(v) >= mesh.points.size())
        fail(file, 0, fmt::format("facet {} names vertex {}, there are {}", f + 1, v, mesh.points.size()));
      for (int k = 0; k < 3; ++k)
        if (const double x = mesh.points[v][k]; !(std::fabs(x) <= k_farthest))
          fail(file, 0,
               std::isfinite(x) ? fmt::format("facet {} has a vertex at {} = {:.4g} m", f + 1, "xyz"[k], x)
                                : fmt::format("facet {} has a vertex that is not finite", f + 1),
               "coordinates reach to 1e12 m after scale and shift");
    }
}

/// Numbers the vertices in the order in which the facets name them.
void drop_unused(Mesh& mesh) {
  std::vector<std::int32_t> index(mesh.points.size(), -1);
  std::vector<Vec3> kept;
  for (auto& f : mesh.facets)
    for (std::int32_t& v : f) {
      std::int32_t& to = index[v];
      if (to < 0) to = static_cast<std::int32_t>(kept.size()), kept.push_back(mesh.points[v]);
      v = to;
    }
  mesh.points = std::move(kept);
}

/// Gives every set of equal vertices the index of its first member (in file order); unused vertices vanish.
void join_equal(Mesh& mesh) {
  const auto& p = mesh.points;
  std::vector<std::int32_t> order(p.size());
  std::iota(order.begin(), order.end(), 0);
  auto less = [&](std::int32_t a, std::int32_t b) {
    if (p[a].x != p[b].x) return p[a].x < p[b].x;
    if (p[a].y != p[b].y) return p[a].y < p[b].y;
    if (p[a].z != p[b].z) return p[a].z < p[b].z;
    return a < b;
  };
  for (const Vec3& q : p)  // those of no facet, too, must be comparable
    if (std::isnan(q.x + q.y + q.z)) fail(mesh.report.file, 0, "a vertex is not finite");
  std::sort(order.begin(), order.end(), less);
  std::vector<std::int32_t> first(p.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && p[order[k]].x == p[order[k - 1]].x && p[order[k]].y == p[order[k - 1]].y &&
                      p[order[k]].z == p[order[k - 1]].z;
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  for (auto& f : mesh.facets)
    for (std::int32_t& v : f) v = first[v];
  drop_unused(mesh);
}

/// Ends of the groups of equal edges.
template <class Visit>
void each_edge(const std::vector<EdgeUse>& edges, Visit visit) {
  for (std::size_t k = 0, end = 0; k < edges.size(); k = end) {
    end = k + 1;
    while (end < edges.size() && edges[end].from == edges[k].from && edges[end].to == edges[k].to) ++end;
    visit(k, end - k);
  }
}

bool collapsed(const std::array<std::int32_t, 3>& f) { return f[0] == f[1] || f[1] == f[2] || f[2] == f[0]; }

/// Exporters that compute a vertex twice give it last digits that differ. Only vertices on open edges are joined,
/// within two units in the last place, and never over a noticeable part of the facets' own edges.
void weld_borders(Mesh& mesh) {
  Facets facets;
  for (const auto& f : mesh.facets)
    if (!collapsed(f)) facets.push_back(f);
  const auto edges = sorted_edges(facets);
  std::vector<double> within(mesh.points.size(), -1);  // -1: not on a border
  each_edge(edges, [&](std::size_t k, std::size_t uses) {
    if (uses == 1) within[edges[k].from] = within[edges[k].to] = HUGE_VAL;
  });
  for (const EdgeUse& e : edges) {
    const double length = std::sqrt(norm2(mesh.points[e.to] - mesh.points[e.from]));
    for (const std::int32_t v : {e.from, e.to})
      if (within[v] > 0) within[v] = fmin2(within[v], k_weld_edge * length);
  }
  // Sorted along an odd direction: what is near lies near in the order, and little else does.
  const Vec3 direction{0.5377, 0.6188, 0.5727};
  std::vector<std::pair<double, std::int32_t>> order;
  for (std::size_t v = 0; v < within.size(); ++v)
    if (within[v] > 0) {
      within[v] = fmin2(within[v], 2 * mesh.rounding_at(mesh.points[v]));
      order.emplace_back(dot(mesh.points[v], direction), static_cast<std::int32_t>(v));
    }
  std::sort(order.begin(), order.end());
  std::vector<std::int32_t> to(mesh.points.size());
  std::iota(to.begin(), to.end(), 0);
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i + 1; j < order.size() && j <= i + k_weld_tries; ++j) {
      const std::int32_t a = order[i].second, b = order[j].second;
      if (order[j].first - order[i].first > 1.01 * within[a] + 1e-15 * std::fabs(order[i].first)) break;
      const double tolerance = fmin2(within[a], within[b]);
      if (norm2(mesh.points[a] - mesh.points[b]) > tolerance * tolerance) continue;
      const std::int32_t low = std::min(to[a], to[b]), high = std::max(to[a], to[b]);
      if (low == high) continue;
      to[high] = low;
      ++mesh.report.welded;
    }
  if (mesh.report.welded == 0) return;
  const auto root = [&](std::int32_t v) {
    while (to[v] != v) v = to[v];
    return v;
  };
  for (auto& f : mesh.facets)
    for (std::int32_t& v : f) v = root(v);
  drop_unused(mesh);
}

/// Height over the longest side, or 0 [m].
double lowest_height(Vec3 a, Vec3 b, Vec3 c, double* longest) {
  const double ab = norm2(b - a), bc = norm2(c - b), ca = norm2(a - c);
  *longest = std::sqrt(fmax2(ab, fmax2(bc, ca)));
  const Vec3 n = ab >= bc && ab >= ca ? cross(a - c, b - c) : (bc >= ca ? cross(b - a, c - a) : cross(c - b, a - b));
  return *longest > 0 ? std::sqrt(norm2(n)) / *longest : 0;
}

bool degenerate(const Mesh& mesh, const std::array<std::int32_t, 3>& f) {
  const Vec3 a = mesh.points[f[0]], b = mesh.points[f[1]], c = mesh.points[f[2]];
  double longest = 0;
  const double height = lowest_height(a, b, c, &longest);
  const double rounding = fmax2(mesh.rounding_at(a), fmax2(mesh.rounding_at(b), mesh.rounding_at(c)));
  return !(height > fmax2(k_needle * longest, fmin2(0.5 * rounding, k_slim * longest)));
}

void drop_degenerate(Mesh& mesh) {
  MeshReport& r = mesh.report;
  std::int64_t first_bad = -1;
  std::size_t kept = 0;
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    if (!degenerate(mesh, mesh.facets[f]))
      mesh.facets[kept++] = mesh.facets[f];
    else if (first_bad < 0)
      first_bad = static_cast<std::int64_t>(f) + 1;
  }
  r.degenerate = static_cast<std::int64_t>(mesh.facets.size() - kept);
  if (2 * r.degenerate > static_cast<std::int64_t>(mesh.facets.size()))
    fail(r.file, 0,
         fmt::format("{} of {} facets have no area, the first is facet {}; the file gives its coordinates to {:.2g} m",
                     r.degenerate, mesh.facets.size(), first_bad, r.rounding),
         "at most half may be degenerate; export the mesh again, with more digits or nearer to the origin");
  mesh.facets.resize(kept);
}

void drop_duplicates(Mesh& mesh) {
  std::vector<std::pair<std::array<std::int32_t, 3>, std::int32_t>> keys;
  keys.reserve(mesh.facets.size());
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

/// Which facets touch along edges of exactly two, and whether their windings agree there.
struct Links {
  struct Link {
    std::int32_t from, to;
    bool turned;
  };
  std::vector<Link> links;
  std::vector<std::size_t> start;
  std::vector<std::pair<std::int32_t, std::int32_t>> border;  ///< open edges
  std::int64_t forked = 0;

  explicit Links(const Facets& facets) : start(facets.size() + 1, 0) {
    const auto edges = sorted_edges(facets);
    each_edge(edges, [&](std::size_t k, std::size_t uses) {
      if (uses == 1) border.emplace_back(edges[k].from, edges[k].to);
      if (uses > 2) ++forked;
      if (uses != 2) return;
      // Neighbours wound alike run through their common edge in opposite directions.
      const bool turned = edges[k].reversed == edges[k + 1].reversed;
      links.push_back({edges[k].facet, edges[k + 1].facet, turned});
      links.push_back({edges[k + 1].facet, edges[k].facet, turned});
    });
    std::sort(links.begin(), links.end(),
              [](const Link& a, const Link& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
    for (const Link& l : links) ++start[l.from + 1];
    for (std::size_t f = 0; f + 1 < start.size(); ++f) start[f + 1] += start[f];
  }
  bool closed() const noexcept { return border.empty() && forked == 0; }
};

/// Rings of three open edges.
std::int64_t three_rings(const std::vector<std::pair<std::int32_t, std::int32_t>>& border) {
  auto from = border;
  for (const auto& [a, b] : border) from.emplace_back(b, a);
  std::sort(from.begin(), from.end());
  std::vector<std::int32_t> other;
  const auto partners = [&](std::int32_t v) {
    other.clear();
    for (auto it = std::lower_bound(from.begin(), from.end(), std::pair(v, -1)); it != from.end() && it->first == v;
         ++it)
      other.push_back(it->second);
    return other.size() == 2;
  };
  std::int64_t rings = 0;
  for (const auto& [a, b] : border) {  // a < b; count at the edge whose third vertex is the highest
    if (!partners(a)) continue;
    const std::int32_t c = other[0] == b ? other[1] : other[0];
    if (c > b && partners(b) && (other[0] == c || other[1] == c) && partners(c)) ++rings;
  }
  return rings;
}

/// Windings and volume per connected part.
void examine_parts(Mesh& mesh, const Facets& facets, const Links& l) {
  MeshReport& r = mesh.report;
  const Vec3 centre = 0.5 * (r.lower + r.upper);
  std::vector<signed char> side(facets.size(), 0);
  std::vector<std::int32_t> part;
  double volume = 0;
  for (std::size_t seed = 0; seed < facets.size(); ++seed) {
    if (side[seed] != 0) continue;
    side[seed] = 1;
    part.assign(1, static_cast<std::int32_t>(seed));
    std::int64_t minus = 0;
    double enclosed = 0;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const std::int32_t f = part[k];
      if (side[f] < 0) ++minus;
      const auto& t = facets[f];
      enclosed +=
          side[f] * dot(mesh.points[t[0]] - centre, cross(mesh.points[t[1]] - centre, mesh.points[t[2]] - centre));
      for (std::size_t i = l.start[f]; i < l.start[f + 1]; ++i)
        if (side[l.links[i].to] == 0) {
          side[l.links[i].to] = static_cast<signed char>(l.links[i].turned ? -side[f] : side[f]);
          part.push_back(l.links[i].to);
        }
    }
    const auto plus = static_cast<std::int64_t>(part.size()) - minus;
    r.flipped += std::min(minus, plus);
    volume += minus > plus ? -enclosed : enclosed;
    ++r.parts;
  }
  r.volume = r.watertight ? std::fabs(volume) / 6 : 0;
}

void examine_topology(Mesh& mesh, const Facets& with_needles) {
  const Facets* facets = &mesh.facets;
  Links links(*facets);
  // A needle between three different vertices may be what closes the mesh: without it its edges stay open.
  if (!links.closed() && with_needles.size() > mesh.facets.size())
    if (Links whole(with_needles); whole.closed()) links = std::move(whole), facets = &with_needles;
  MeshReport& r = mesh.report;
  r.open_edges = static_cast<std::int64_t>(links.border.size());
  r.forked_edges = links.forked;
  r.watertight = links.closed();
  r.holes = mesh.facets.size() > 3 ? three_rings(links.border) : 0;
  examine_parts(mesh, *facets, links);
}

void set_bounds(Mesh& mesh) {
  MeshReport& r = mesh.report;
  r.lower = r.upper = mesh.points[mesh.facets[0][0]];
  for (const auto& f : mesh.facets)
    for (const std::int32_t v : f)
      for (int k = 0; k < 3; ++k) {
        r.lower[k] = fmin2(r.lower[k], mesh.points[v][k]);
        r.upper[k] = fmax2(r.upper[k], mesh.points[v][k]);
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
  r.facets_read = mesh.size();
  check_indices(mesh);
  join_equal(mesh);
  weld_borders(mesh);
  Facets with_needles;
  for (const auto& f : mesh.facets)
    if (!collapsed(f)) with_needles.push_back(f);
  drop_degenerate(mesh);
  drop_duplicates(mesh);
  set_bounds(mesh);
  const double across = std::sqrt(norm2(r.upper - r.lower));
  if (across < largest_diameter)
    fail(r.file, 0, fmt::format("the mesh is {:.4g} m across, the largest particle {:.4g} m", across, largest_diameter),
         "check wall.scale: a file in mm needs scale = 0.001");
  examine_topology(mesh, with_needles);
  drop_unused(mesh);
}

}  // namespace talus
