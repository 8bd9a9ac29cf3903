// Ear clipping. Who calls it: the OBJ and PLY readers. Invariants: see the header. The signed areas of the triangles
// add up to the winding number of the polygon at every point: if all are positive and the polygon does not cross
// itself, they cover it exactly once. So an ear that was chosen badly cannot go unseen: the rest then has none.
#include "core/meshes/mesh_polygon.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/meshes/mesh_text.hpp"

namespace talus::mesh_io {
namespace {

constexpr double k_sliver = 1e-6;  // of the polygon's area: rounding of corners that lie on one line

class EarClipper {
 public:
  explicit EarClipper(std::span<const Vec3> corners) : p_(corners.size()), next_(p_.size()), previous_(p_.size()) {
    const auto n = static_cast<std::int32_t>(p_.size());
    for (std::int32_t i = 0; i < n; ++i) {
      p_[i] = corners[i] - corners[0];
      next_[i] = i + 1 == n ? 0 : i + 1;
      previous_[i] = i == 0 ? n - 1 : i - 1;
    }
    for (std::int32_t i = 1; i + 1 < n; ++i) normal_ = normal_ + cross(p_[i], p_[i + 1]);
    const double largest = fmax2(std::fabs(normal_.x), fmax2(std::fabs(normal_.y), std::fabs(normal_.z)));
    if (largest > 0) normal_ = {normal_.x / largest, normal_.y / largest, normal_.z / largest};
  }

  bool run(std::vector<std::array<std::int32_t, 3>>& out, std::int64_t& budget) {
    convex_.assign(p_.size(), 1);
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(p_.size()); ++i) update(i);
    std::size_t left = p_.size(), tried = 0;
    std::int32_t at = next_[0];
    while (left > 3) {
      const std::int32_t a = previous_[at], c = next_[at];
      if (budget < 0) return false;
      if (!is_ear(at, budget)) {
        at = c;
        if (++tried > left) return close(at, out);
        continue;
      }
      out.push_back({a, at, c});
      area_ += turn(a, at, c);
      next_[a] = c;
      previous_[c] = a;
      update(a);
      update(c);
      at = c == 0 ? next_[c] : c;
      --left;
      tried = 0;
    }
    return close(at, out);
  }

 private:
  /// Twice the area of a triangle seen along the normal, 0 within its rounding.
  double turn(std::int32_t a, std::int32_t b, std::int32_t c) const noexcept {
    const Vec3 u = p_[b] - p_[a], v = p_[c] - p_[a];
    const double area = dot(normal_, cross(u, v));
    return std::fabs(area) <= 1e-14 * std::sqrt(norm2(u) * norm2(v)) ? 0 : area;
  }
  void update(std::int32_t i) noexcept {
    const char convex = turn(previous_[i], i, next_[i]) > 0 ? 1 : 0;
    not_convex_ += convex_[i] - convex;
    convex_[i] = convex;
  }

  /// What is left has three corners, or no ear: fine if it is a triangle, or a line but for rounding.
  bool close(std::int32_t at, std::vector<std::array<std::int32_t, 3>>& out) const {
    double least = 0, most = 0;
    std::size_t count = 0;
    for (std::int32_t k = next_[at]; next_[k] != at; k = next_[k], ++count) {
      const double t = turn(at, k, next_[k]);
      least = fmin2(least, t), most = fmax2(most, t);
      out.push_back({at, k, next_[k]});
    }
    return (count == 1 && most > 0) || (area_ > 0 && fmax2(most, -least) <= k_sliver * area_);
  }

  static bool equal(Vec3 a, Vec3 b) noexcept { return a.x == b.x && a.y == b.y && a.z == b.z; }

  /// A convex corner whose triangle holds no corner that is not convex (others cannot be the first to enter it).
  bool is_ear(std::int32_t i, std::int64_t& budget) const noexcept {
    --budget;
    if (convex_[i] == 0) return false;
    if (not_convex_ == 0) return true;
    const std::int32_t a = previous_[i], c = next_[i];
    for (std::int32_t k = next_[c]; k != a; k = next_[k]) {
      --budget;
      if (convex_[k] != 0 || equal(p_[k], p_[a]) || equal(p_[k], p_[i]) || equal(p_[k], p_[c])) continue;
      if (turn(a, i, k) >= 0 && turn(i, c, k) >= 0 && turn(c, a, k) >= 0) return false;
    }
    return true;
  }

  std::vector<Vec3> p_;  ///< relative to the first corner
  std::vector<std::int32_t> next_, previous_;
  std::vector<char> convex_;
  std::int64_t not_convex_ = 0;
  double area_ = 0;  ///< twice what has been clipped
  Vec3 normal_;
};

bool has_area(Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 u = b - a, v = c - a;
  return norm2(cross(u, v)) > 1e-24 * (norm2(u) * norm2(v));
}

}  // namespace

bool triangulate(std::span<const Vec3> corners, std::vector<std::array<std::int32_t, 3>>& out, std::int64_t& budget) {
  const auto n = static_cast<std::int32_t>(corners.size());
  if (n < 3) return true;
  if (n == 3) {
    out.push_back({0, 1, 2});
    return true;
  }
  const std::size_t before = out.size();
  if (EarClipper(corners).run(out, budget)) return true;
  out.resize(before);
  bool flat = true;  // all corners on one line
  for (std::int32_t i = 1; i + 1 < n; ++i) {
    flat = flat && !has_area(corners[0], corners[i], corners[i + 1]);
    out.push_back({0, i, i + 1});
  }
  if (!flat) out.resize(before);
  return flat;
}

void add_polygons(RawMesh& mesh, const Polygons& polygons, int first, const std::string& name) {
  const auto vertices = static_cast<std::int64_t>(mesh.points.size());
  std::int64_t budget = k_budget;
  std::vector<Vec3> corners;
  std::vector<std::int32_t> index;
  std::vector<std::array<std::int32_t, 3>> cut;
  mesh.facets.reserve(mesh.facets.size() + polygons.end.size());
  for (std::size_t f = 0, begin = 0; f < polygons.end.size(); begin = polygons.end[f++]) {
    const auto wrong = [&](const std::string& what, const std::string& cure) {
      fail(name, polygons.line[f], fmt::format("face {}: {}", f + 1, what), cure);
    };
    corners.clear();
    index.clear();
    for (std::size_t k = begin; k < polygons.end[f]; ++k) {
      const std::int64_t v = polygons.corners[k];
      if (v < 0 || v >= vertices)
        wrong(fmt::format("names vertex {}", v + first),
              vertices == 0 ? "the file has no vertices"
                            : fmt::format("the vertices are {} to {}", first, vertices - 1 + first));
      if (!index.empty() && index.back() == v) continue;
      index.push_back(static_cast<std::int32_t>(v));
      corners.push_back(mesh.points[static_cast<std::size_t>(v)]);
    }
    while (index.size() > 1 && index.front() == index.back()) index.pop_back(), corners.pop_back();
    if (index.size() < 3) {  // collapsed: counted as degenerate with the others
      mesh.facets.push_back({index[0], index[0], index.back()});
      continue;
    }
    cut.clear();
    if (!triangulate(corners, cut, budget))
      wrong(budget < 0 ? fmt::format("the polygons are too large to be cut ({} corners)", index.size())
                       : "the polygon crosses itself",
            "export triangles");
    for (const auto& t : cut) mesh.facets.push_back({index[t[0]], index[t[1]], index[t[2]]});
  }
}

}  // namespace talus::mesh_io
