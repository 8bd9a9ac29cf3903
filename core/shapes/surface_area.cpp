// See surface_area.hpp.
#include "core/shapes/surface_area.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/det_math.hpp"

namespace talus::shapes {
namespace {

constexpr int k_slices = 4096;

/// Angle of the direction (x, y) in (-pi, pi].
double angle_of(double x, double y) {
  if (__builtin_fabs(y) > __builtin_fabs(x)) return (y > 0 ? 0.5 : -0.5) * det::k_pi - det::atan(x / y);
  const double a = x == 0 ? 0.0 : det::atan(y / x);
  return x >= 0 ? a : (y >= 0 ? a + det::k_pi : a - det::k_pi);
}

using Arc = std::pair<double, double>;

/// Share of the circle that the arcs leave; they begin in [-pi, pi] and may end beyond.
double open_share(std::vector<Arc>& arcs) {
  const double pi = det::k_pi;
  const std::size_t n = arcs.size();
  for (std::size_t k = 0; k < n; ++k) {
    if (arcs[k].first < -pi) {
      arcs.push_back({arcs[k].first + 2 * pi, pi});
      arcs[k].first = -pi;
    }
    if (arcs[k].second > pi) {
      arcs.push_back({-pi, arcs[k].second - 2 * pi});
      arcs[k].second = pi;
    }
  }
  std::sort(arcs.begin(), arcs.end());
  double covered = 0, end = -pi;
  for (const Arc& a : arcs) {
    const double from = fmax2(a.first, end);
    if (a.second > from) covered += a.second - from;
    end = fmax2(end, a.second);
  }
  return fmax2(0, 1 - covered / (2 * pi));
}

/// Share of the slice of sphere i at height z that no other sphere holds.
double shown(std::span<const SubSphere> all, std::span<const std::size_t> near, std::size_t i, double z,
             std::vector<Arc>& arcs) {
  const SubSphere& s = all[i];
  const double rho = __builtin_sqrt(fmax2(0, s.r * s.r - z * z));
  arcs.clear();
  for (const std::size_t j : near) {
    const Vec3 d = all[j].x - s.x;
    const double h = __builtin_sqrt(d.x * d.x + d.y * d.y), r = all[j].r;
    // inside sphere j: rho h cos(phi - phi_j) > b
    const double b = 0.5 * ((s.r * s.r + norm2(d)) - r * r) - z * d.z, reach = rho * h;
    if (b >= reach) {
      const bool same = norm2(d) == 0 && r == s.r;
      if (same && j < i) return 0;
      continue;
    }
    if (b <= -reach) return 0;
    const double c = b / reach, half = 2 * det::atan(__builtin_sqrt((1 - c) / (1 + c))), phi = angle_of(d.x, d.y);
    arcs.push_back({phi - half, phi + half});
  }
  return open_share(arcs);
}

// Gauss-Legendre, eight points on [0, 1].
constexpr double k_node[] = {0.019855071751231884, 0.10166676129318664, 0.2372337950418355, 0.40828267875217510,
                             0.5917173212478249,   0.7627662049581645,  0.8983332387068134, 0.9801449282487681};
constexpr double k_weight[] = {0.05061426814518813, 0.11119051722668724, 0.15685332293894363, 0.18134189168918100,
                               0.18134189168918100, 0.15685332293894363, 0.11119051722668724, 0.05061426814518813};
// Panels: narrow towards 1, where a body with large exponents has its edges.
constexpr double k_edge[] = {0, 0.25, 0.5, 0.75, 0.875, 0.9375, 0.96875, 1};

template <class F>
double integral(F f) {
  double sum = 0;
  for (int p = 0; p + 1 < static_cast<int>(std::size(k_edge)); ++p)
    for (int k = 0; k < 8; ++k) {
      const double width = k_edge[p + 1] - k_edge[p];
      sum += width * k_weight[k] * f(k_edge[p] + width * k_node[k]);
    }
  return sum;
}

struct Gauge {
  double g = 0;
  Vec3 slope;
};

/// Of a point of the positive octant in units of the semi-axes: homogeneous of degree 1, and 1 on the surface.
Gauge gauge_at(const Superquadric& s, Vec3 y) {
  const auto power = [](double x, double p) { return x > 0 ? det::pow(x, p) : 0.0; };
  const double u = power(y.x, s.n2) + power(y.y, s.n2), v = power(u, s.n1 / s.n2), sum = v + power(y.z, s.n1);
  const double outer = det::pow(sum, 1 / s.n1 - 1), inner = u > 0 ? outer * v / u : 0.0;
  return {outer * sum, {inner * power(y.x, s.n2 - 1), inner * power(y.y, s.n2 - 1), outer * power(y.z, s.n1 - 1)}};
}

/// Area per ds dt of the surface seen from the centre through the face y_k = 1 of a cube; a, b: the other axes.
double patch(const Superquadric& s, int k, double at_a, double at_b) {
  const int a = (k + 1) % 3, b = (k + 2) % 3;
  Vec3 y, ea, eb;
  y[k] = 1, y[a] = at_a, y[b] = at_b;
  ea[a] = s.axes[a], eb[b] = s.axes[b];
  const Vec3 p{s.axes.x * y.x, s.axes.y * y.y, s.axes.z * y.z};
  const Gauge g = gauge_at(s, y);
  const Vec3 xa = (1 / g.g) * ea - (g.slope[a] / (g.g * g.g)) * p, xb = (1 / g.g) * eb - (g.slope[b] / (g.g * g.g)) * p;
  return norm(cross(xa, xb));
}

}  // namespace

double surface_area(std::span<const SubSphere> spheres) {
  double area = 0;
  std::vector<std::size_t> near;
  std::vector<Arc> arcs;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const SubSphere& s = spheres[i];
    near.clear();
    for (std::size_t j = 0; j < spheres.size(); ++j)
      if (j != i && norm(spheres[j].x - s.x) < s.r + spheres[j].r) near.push_back(j);
    double open = 0;  // slices of equal height have equal areas
    for (int k = 0; k < k_slices; ++k) open += shown(spheres, near, i, s.r * (2 * (k + 0.5) / k_slices - 1), arcs);
    area += 4 * det::k_pi * (s.r * s.r) * (near.empty() ? 1.0 : open / k_slices);
  }
  return area;
}

double surface_area(const Superquadric& s) {
  double octant = 0;
  for (int k = 0; k < 2; ++k)
    octant += integral([&](double a) { return integral([&](double b) { return patch(s, k, a, b); }); });
  // the face across z in two triangles: its edge between x and y runs along the diagonal
  octant += integral(
      [&](double a) { return a * integral([&](double t) { return patch(s, 2, a, a * t) + patch(s, 2, a * t, a); }); });
  return 8 * octant;
}

}  // namespace talus::shapes
