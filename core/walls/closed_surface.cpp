// Closed surfaces. Who calls it: core/grains/region.cpp, core/grains/source_walls.cpp. Invariants: see the header.
#include "core/walls/closed_surface.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.hpp"

namespace talus {
namespace {

constexpr std::int32_t k_leaf = 4;  ///< facets
constexpr int k_deepest = 64;       ///< halving 2^31 facets takes fewer levels

/// a + b = sum + rest exactly (Knuth).
struct Pair {
  double sum, rest;
};
Pair two_sum(double a, double b) noexcept {
  const double s = a + b, bb = s - a;
  return {s, (a - (s - bb)) + (b - bb)};
}
Pair split_half(double a) noexcept {
  const double c = 134217729 * a, high = c - (c - a);
  return {high, a - high};
}
/// a * b = sum + rest exactly (Dekker).
Pair two_product(double a, double b) noexcept {
  const double p = a * b;
  const Pair x = split_half(a), y = split_half(b);
  const double e = ((x.sum * y.sum - p) + x.sum * y.rest) + x.rest * y.sum;
  return {p, e + x.rest * y.rest};
}

int sign(double a) noexcept { return a > 0 ? 1 : (a < 0 ? -1 : 0); }

/// Sign of a_x b_y - a_y b_x + b_x c_y - b_y c_x + c_x a_y - c_y a_x in exact arithmetic: the products are summed as an
/// expansion of terms that do not overlap, the last of which that is not 0 has the sign of all (Shewchuk 1997).
int exact_turn(Vec3 a, Vec3 b, Vec3 c) noexcept {
  const double factors[6][2] = {{a.x, b.y}, {-a.y, b.x}, {b.x, c.y}, {-b.y, c.x}, {c.x, a.y}, {-c.y, a.x}};
  std::array<double, 13> terms{};
  int count = 0;
  const auto add = [&](double value) {
    for (int k = 0; k < count; ++k) {
      const Pair s = two_sum(value, terms[static_cast<std::size_t>(k)]);
      terms[static_cast<std::size_t>(k)] = s.rest;
      value = s.sum;
    }
    terms[static_cast<std::size_t>(count++)] = value;
  };
  for (const auto& f : factors) {
    const Pair p = two_product(f[0], f[1]);
    add(p.rest);
    add(p.sum);
  }
  for (int k = count; k-- > 0;)
    if (terms[static_cast<std::size_t>(k)] != 0) return sign(terms[static_cast<std::size_t>(k)]);
  return 0;
}

/// +1 where c lies to the left of the line from a to b seen from above, -1 to the right, 0 on it.
int turn(Vec3 a, Vec3 b, Vec3 c) noexcept {
  const double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
  const double det = left - right;
  const double size = (left < 0 ? -left : left) + (right < 0 ? -right : right);
  const double bound = 4e-16 * size;  // (3 + 16 eps) eps of Shewchuk's filter, rounded up
  if (det > bound || -det > bound) return sign(det);
  return exact_turn(a, b, c);
}

/// The same for c moved by (epsilon, epsilon^2): 0 only where a and b lie above one another.
int turn_aside(Vec3 a, Vec3 b, Vec3 c) noexcept {
  const int s = turn(a, b, c);
  if (s != 0) return s;
  return a.y != b.y ? sign(a.y - b.y) : sign(b.x - a.x);
}

/// True if the vertical line beside x meets the facet above x. `x.z` counts against the facet's plane.
bool meets_above(const std::array<Vec3, 3>& v, Vec3 x) noexcept {
  if (x.z > fmax2(v[0].z, fmax2(v[1].z, v[2].z))) return false;
  const int side = turn_aside(v[0], v[1], x);
  if (side == 0 || turn_aside(v[1], v[2], x) != side || turn_aside(v[2], v[0], x) != side) return false;
  if (x.z < fmin2(v[0].z, fmin2(v[1].z, v[2].z))) return true;
  const Vec3 normal = cross(v[1] - v[0], v[2] - v[0]);
  const double height = dot(normal, x - v[0]);
  return side > 0 ? height < 0 : height > 0;  // the normal points up where the vertices turn left
}

void check_closed(const Mesh& mesh) {
  const std::vector<EdgeUse> edges = sorted_edges(mesh.facets);
  std::int64_t open = 0, odd = 0;
  Vec3 at;
  for (std::size_t k = 0, end = 0; k < edges.size(); k = end) {
    end = k + 1;
    while (end < edges.size() && edges[end].from == edges[k].from && edges[end].to == edges[k].to) ++end;
    if ((end - k) % 2 == 0) continue;
    if (open + odd == 0)
      at = 0.5 *
           (mesh.points[static_cast<std::size_t>(edges[k].from)] + mesh.points[static_cast<std::size_t>(edges[k].to)]);
    ++(end - k == 1 ? open : odd);
  }
  if (open + odd == 0) return;
  const MeshReport& r = mesh.report;
  std::string what = open > 0 ? fmt::format("{} open edges", open) : "";
  if (odd > 0) what += fmt::format("{}{} edges with an odd number of facets", open > 0 ? " and " : "", odd);
  if (r.degenerate > 0) what += fmt::format(" after {} facets without area were dropped", r.degenerate);
  throw Error(
      ErrorCode::scene,
      fmt::format("the mesh is not watertight: {}, the first about ({:.6g}, {:.6g}, {:.6g})", what, at.x, at.y, at.z),
      "mesh " + r.file, "only a closed surface has an inside: close the mesh, or give a box, cylinder or sphere");
}

Vec3 lower_of(const TriangleElement& t) noexcept {
  Vec3 c;
  for (int k = 0; k < 3; ++k) c[k] = fmin2(t.v[0][k], fmin2(t.v[1][k], t.v[2][k]));
  return c;
}
Vec3 upper_of(const TriangleElement& t) noexcept {
  Vec3 c;
  for (int k = 0; k < 3; ++k) c[k] = fmax2(t.v[0][k], fmax2(t.v[1][k], t.v[2][k]));
  return c;
}

double distance2_to_box(Vec3 x, Vec3 lower, Vec3 upper) noexcept {
  Vec3 d;
  for (int k = 0; k < 3; ++k) d[k] = fmax2(0, fmax2(lower[k] - x[k], x[k] - upper[k]));
  return norm2(d);
}

}  // namespace

ClosedSurface::ClosedSurface(const Mesh& mesh) {
  check_closed(mesh);
  facets_.reserve(mesh.facets.size());
  for (const auto& f : mesh.facets)
    facets_.push_back(make_triangle(mesh.points[static_cast<std::size_t>(f[0])],
                                    mesh.points[static_cast<std::size_t>(f[1])],
                                    mesh.points[static_cast<std::size_t>(f[2])]));
  build();
  volume_ = enclosed();
}

void ClosedSurface::build() {
  nodes_.reserve(facets_.size() + 1);
  nodes_.emplace_back();
  split(0, 0, static_cast<std::int32_t>(facets_.size()));
}

void ClosedSurface::split(std::int32_t node, std::int32_t first, std::int32_t last) {
  Vec3 lower = lower_of(facets_[static_cast<std::size_t>(first)]);
  Vec3 upper = upper_of(facets_[static_cast<std::size_t>(first)]);
  for (std::int32_t f = first; f < last; ++f) {
    const Vec3 lo = lower_of(facets_[static_cast<std::size_t>(f)]), hi = upper_of(facets_[static_cast<std::size_t>(f)]);
    for (int k = 0; k < 3; ++k) lower[k] = fmin2(lower[k], lo[k]), upper[k] = fmax2(upper[k], hi[k]);
  }
  if (last - first <= k_leaf) {
    nodes_[static_cast<std::size_t>(node)] = {lower, upper, first, last - first};
    return;
  }
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (upper[k] - lower[k] > upper[axis] - lower[axis]) axis = k;
  const std::int32_t middle = first + (last - first) / 2;
  std::nth_element(facets_.begin() + first, facets_.begin() + middle, facets_.begin() + last,
                   [axis](const TriangleElement& a, const TriangleElement& b) {
                     return lower_of(a)[axis] + upper_of(a)[axis] < lower_of(b)[axis] + upper_of(b)[axis];
                   });
  const auto child = static_cast<std::int32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[static_cast<std::size_t>(node)] = {lower, upper, child, 0};
  split(child, first, middle);
  split(child + 1, middle, last);
}

int ClosedSurface::crossings(Vec3 x, std::int32_t skip) const noexcept {
  std::array<std::int32_t, k_deepest> open;
  int depth = 0, count = 0;
  open[static_cast<std::size_t>(depth++)] = 0;
  while (depth > 0) {
    const Node& n = nodes_[static_cast<std::size_t>(open[static_cast<std::size_t>(--depth)])];
    if (!(x.x >= n.lower.x && x.x <= n.upper.x && x.y >= n.lower.y && x.y <= n.upper.y && x.z <= n.upper.z)) continue;
    if (n.count == 0) {
      open[static_cast<std::size_t>(depth++)] = n.first;
      open[static_cast<std::size_t>(depth++)] = n.first + 1;
      continue;
    }
    for (std::int32_t f = n.first; f < n.first + n.count; ++f)
      if (f != skip && meets_above(facets_[static_cast<std::size_t>(f)].v, x)) ++count;
  }
  return count;
}

double ClosedSurface::distance(Vec3 x, double within) const noexcept {
  std::array<std::int32_t, k_deepest> open;
  int depth = 0;
  open[static_cast<std::size_t>(depth++)] = 0;
  while (depth > 0) {
    const Node& n = nodes_[static_cast<std::size_t>(open[static_cast<std::size_t>(--depth)])];
    if (!(distance2_to_box(x, n.lower, n.upper) < within * within)) continue;
    for (std::int32_t f = n.first; f < n.first + n.count; ++f)
      within = fmin2(within, closest(facets_[static_cast<std::size_t>(f)], x).distance);
    if (n.count > 0) continue;
    const Node &a = nodes_[static_cast<std::size_t>(n.first)], &b = nodes_[static_cast<std::size_t>(n.first + 1)];
    const bool a_first = distance2_to_box(x, a.lower, a.upper) <= distance2_to_box(x, b.lower, b.upper);
    open[static_cast<std::size_t>(depth++)] = a_first ? n.first + 1 : n.first;
    open[static_cast<std::size_t>(depth++)] = a_first ? n.first : n.first + 1;
  }
  return within;
}

/// Sum over the facets of the prisms between them and the lowest point, added where the inside is below a facet and
/// taken off where it is above: that needs no consistent winding.
double ClosedSurface::enclosed() const noexcept {
  double sum = 0;
  const Vec3 base = lower();
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    const auto& v = facets_[f].v;
    const Vec3 a = v[0] - base, b = v[1] - base, c = v[2] - base;
    const double area = 0.5 * cross(b - a, c - a).z;
    const Vec3 middle = base + (1.0 / 3.0) * (a + b + c);
    const double prism = (area < 0 ? -area : area) * ((1.0 / 3.0) * (a.z + b.z + c.z));
    sum += crossings(middle, static_cast<std::int32_t>(f)) % 2 == 0 ? prism : -prism;
  }
  return sum;
}

}  // namespace talus
