// Implementation of clump_mesh.hpp.
#include "core/shapes/clump_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <queue>

#include "core/base/error.hpp"
#include "core/shapes/clump_quadrature.hpp"
#include "core/walls/closed_surface.hpp"

namespace talus::shapes {
namespace {

constexpr double k_smallest = 1e-10;  // [m]

/// Points of a grid that lie inside, with their distance to the surface.
struct InnerGrid {
  Vec3 origin;
  double step = 0;
  int n[3] = {0, 0, 0};
  std::vector<double> depth;  ///< 0 outside [m]
  std::size_t index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(n[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(n[0]) +
           static_cast<std::size_t>(i);
  }
  Vec3 point(int i, int j, int k) const { return origin + step * Vec3{i + 0.5, j + 0.5, k + 0.5}; }
  Vec3 point(std::size_t at) const {
    const auto nx = static_cast<std::size_t>(n[0]), ny = static_cast<std::size_t>(n[1]);
    return point(static_cast<int>(at % nx), static_cast<int>(at / nx % ny), static_cast<int>(at / nx / ny));
  }
};

InnerGrid inner_grid(const ClosedSurface& surface, int points) {
  InnerGrid g;
  const Vec3 size = surface.upper() - surface.lower();
  const double longest = fmax2(size.x, fmax2(size.y, size.z));
  g.step = longest / points;
  for (int k = 0; k < 3; ++k) g.n[k] = std::max(1, static_cast<int>(size[k] / g.step + 0.5));
  const Vec3 covered = g.step * Vec3{double(g.n[0]), double(g.n[1]), double(g.n[2])};
  g.origin = surface.lower() + 0.5 * (size - covered);
  g.depth.resize(static_cast<std::size_t>(g.n[0]) * static_cast<std::size_t>(g.n[1]) *
                 static_cast<std::size_t>(g.n[2]));
  for (int k = 0; k < g.n[2]; ++k)
    for (int j = 0; j < g.n[1]; ++j)
      for (int i = 0; i < g.n[0]; ++i) {
        const Vec3 x = g.point(i, j, k);
        g.depth[g.index(i, j, k)] = surface.inside(x) ? surface.distance(x, longest) : 0;
      }
  return g;
}

/// Calls f(index) for the inner points of the ball about point `at` that reaches to the surface.
template <class F>
void for_ball(const InnerGrid& g, std::size_t at, F f) {
  const Vec3 c = g.point(at);
  const double r = g.depth[at];
  int low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = std::max(0, static_cast<int>((c[a] - r - g.origin[a]) / g.step));
    high[a] = std::min(g.n[a] - 1, static_cast<int>((c[a] + r - g.origin[a]) / g.step));
  }
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i)
        if (norm2(g.point(i, j, k) - c) <= r * r && g.depth[g.index(i, j, k)] > 0) f(g.index(i, j, k));
}

std::vector<SubSphere> greedy_cover(const InnerGrid& g, int count) {
  std::vector<std::uint8_t> covered(g.depth.size(), 0);
  const auto gain = [&](std::size_t at) {
    std::int64_t n = 0;
    for_ball(g, at, [&](std::size_t k) { n += covered[k] == 0; });
    return n;
  };
  // What a ball adds only falls as others are chosen: an old value that is still the largest after renewal is the
  // largest of all. Ties go to the lower index.
  struct Candidate {
    std::int64_t gain;
    std::size_t at;
    bool operator<(const Candidate& o) const { return gain != o.gain ? gain < o.gain : at > o.at; }
  };
  std::priority_queue<Candidate> queue;
  for (std::size_t k = 0; k < g.depth.size(); ++k)
    if (g.depth[k] > 0) queue.push({INT64_MAX, k});
  std::vector<SubSphere> chosen;
  std::vector<std::size_t> renewed(g.depth.size(), SIZE_MAX);
  while (static_cast<int>(chosen.size()) < count && !queue.empty()) {
    const Candidate c = queue.top();
    queue.pop();
    if (renewed[c.at] != chosen.size()) {
      renewed[c.at] = chosen.size();
      const std::int64_t now = gain(c.at);
      if (now > 0) queue.push({now, c.at});
      continue;
    }
    chosen.push_back({g.point(c.at), g.depth[c.at]});
    for_ball(g, c.at, [&](std::size_t k) { covered[k] = 1; });
  }
  return chosen;
}

double growth_to(const std::vector<SubSphere>& spheres, double volume, const std::string& where) {
  const auto grown = [&](double by) {
    std::vector<SubSphere> s = spheres;
    for (SubSphere& one : s) one.r = one.r + by;
    return union_properties(s, where).volume;
  };
  double low = 0, high = 0.01 * spheres[0].r;
  while (grown(high) < volume) high = 2 * high;
  for (int k = 0; k < 24; ++k) {
    const double middle = 0.5 * (low + high);
    (grown(middle) < volume ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

MassProperties mesh_properties(const Mesh& mesh) {
  const Vec3 middle = 0.5 * (mesh.report.lower + mesh.report.upper);
  Moments m;
  for (const auto& f : mesh.facets) {
    const Vec3 a = mesh.points[static_cast<std::size_t>(f[0])] - middle,
               b = mesh.points[static_cast<std::size_t>(f[1])] - middle,
               c = mesh.points[static_cast<std::size_t>(f[2])] - middle;
    const double six = dot(a, cross(b, c));  // six times the tetrahedron with its tip at the middle
    m.v = m.v + six / 6;
    const Vec3 sum = (a + b) + c;
    m.first = m.first + (six / 24) * sum;
    const auto product = [&](int p, int q) {
      return six / 120 * (((a[p] * a[q] + b[p] * b[q]) + c[p] * c[q]) + sum[p] * sum[q]);
    };
    const int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};
    for (std::size_t k = 0; k < 6; ++k) m.second[k] = m.second[k] + product(pairs[k][0], pairs[k][1]);
  }
  if (m.v < 0) {
    m.v = -m.v;
    m.first = -m.first;
    for (double& s : m.second) s = -s;
  }
  if (!(__builtin_fabs(m.v - mesh.report.volume) <= 1e-6 * mesh.report.volume))
    throw Error(ErrorCode::scene, fmt::format("{} facets are wound against their neighbours", mesh.report.flipped),
                mesh.report.file, "turn them (or all of a part), so that every facet has its outside on the same side");
  MassProperties p = properties(m);
  p.centre = p.centre + middle;
  return p;
}

MeshClump clump_of_mesh(const Mesh& mesh, const MeshClumpSettings& settings) {
  if (!mesh.report.watertight)
    throw Error(ErrorCode::scene,
                fmt::format("the mesh is not watertight: {} open and {} forked edges", mesh.report.open_edges,
                            mesh.report.forked_edges),
                mesh.report.file, "close it: a clump fills the inside");
  const Vec3 size = mesh.report.upper - mesh.report.lower;
  if (const double longest = fmax2(size.x, fmax2(size.y, size.z)); !(longest >= k_smallest))
    throw Error(ErrorCode::scene, fmt::format("the mesh is {:.3g} m long, less than an atom", longest),
                mesh.report.file, "--scale gives the metres per unit of the file");
  MeshClump out;
  out.mesh = mesh_properties(mesh);
  const ClosedSurface surface(mesh);
  const InnerGrid grid = inner_grid(surface, settings.grid);
  out.spheres = greedy_cover(grid, settings.spheres);
  if (out.spheres.empty())
    throw Error(ErrorCode::scene,
                fmt::format("no point of a grid of {} along the longest side lies inside", settings.grid),
                mesh.report.file, "the mesh is thin: give a finer --grid");
  if (settings.grow) {
    out.growth = growth_to(out.spheres, out.mesh.volume, mesh.report.file);
    for (SubSphere& s : out.spheres) s.r = s.r + out.growth;
  }
  out.clump = union_properties(out.spheres, mesh.report.file);
  out.volume_error = out.clump.volume / out.mesh.volume - 1;
  out.centre_error = norm(out.clump.centre - out.mesh.centre);
  const double largest = fmax2(out.mesh.inertia[0], fmax2(out.mesh.inertia[1], out.mesh.inertia[2]));
  for (std::size_t k = 0; k < 6; ++k)
    out.inertia_error = fmax2(out.inertia_error, __builtin_fabs(out.clump.inertia[k] - out.mesh.inertia[k]) / largest);
  return out;
}

}  // namespace talus::shapes
