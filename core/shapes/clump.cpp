// Implementation of clump.hpp: closed forms, input, principal axes. The quadrature is in clump_quadrature.cpp.
#include "core/shapes/clump.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/shapes/clump_quadrature.hpp"
#include "core/tables/particle_file.hpp"

namespace talus::shapes {
namespace {

void check(std::span<const SubSphere> spheres, const std::string& where) {
  if (spheres.empty()) throw Error(ErrorCode::scene, "no sphere", where, "a clump has at least one");
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    const SubSphere& s = spheres[k];
    if (!(norm2(s.x) < 1e24) || !(s.r > 0) || !(s.r < 1e12))
      throw Error(ErrorCode::scene,
                  fmt::format("sphere {}: ({}, {}, {}) with radius {}", k + 1, s.x.x, s.x.y, s.x.z, s.r), where,
                  "coordinates are finite and radii positive");
  }
}

bool any_overlap(std::span<const SubSphere> s) {
  for (std::size_t i = 0; i < s.size(); ++i)
    for (std::size_t j = i + 1; j < s.size(); ++j)
      if (norm2(s[i].x - s[j].x) < (s[i].r + s[j].r) * (s[i].r + s[j].r)) return true;
  return false;
}

MassProperties apart(std::span<const SubSphere> spheres) {
  Moments m;
  for (const SubSphere& s : spheres) {
    const double v = 4.0 / 3 * det::k_pi * s.r * s.r * s.r, own = 0.2 * s.r * s.r;
    m.v = m.v + v;
    m.first = m.first + v * s.x;
    for (int k = 0; k < 3; ++k) m.second[k] = m.second[k] + v * (s.x[k] * s.x[k] + own);
    m.second[3] = m.second[3] + v * s.x.x * s.x.y;
    m.second[4] = m.second[4] + v * s.x.x * s.x.z;
    m.second[5] = m.second[5] + v * s.x.y * s.x.z;
  }
  return properties(m);
}

/// Integral of z^k over [a, b], k = 0 ... 4.
double power_integral(double a, double b, int k) {
  double pa = a, pb = b;
  for (int e = 0; e < k; ++e) pa = pa * a, pb = pb * b;
  return (pb - pa) / (k + 1);
}

/// All centres on the line p + z e: slices are discs, the largest sphere at z decides.
MassProperties turned(std::span<const SubSphere> spheres, Vec3 p, Vec3 e) {
  std::vector<double> z, cuts;
  for (const SubSphere& s : spheres) z.push_back(dot(s.x - p, e));
  for (std::size_t i = 0; i < z.size(); ++i) {
    cuts.push_back(z[i] - spheres[i].r);
    cuts.push_back(z[i] + spheres[i].r);
    for (std::size_t j = i + 1; j < z.size(); ++j) {  // where two spheres are equally wide
      const double d = z[j] - z[i], ri = spheres[i].r, rj = spheres[j].r;
      if (d != 0) cuts.push_back(z[i] + 0.5 * (d + (ri * ri - rj * rj) / d));
    }
  }
  std::sort(cuts.begin(), cuts.end());
  double v = 0, first = 0, along = 0, across = 0;  // integrals of 1, z, z^2, and of x^2 = rho^2 / 4 per area
  for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
    const double a = cuts[c], b = cuts[c + 1], middle = 0.5 * (a + b);
    double widest = 0;
    std::size_t who = 0;
    for (std::size_t k = 0; k < z.size(); ++k) {
      const double w = spheres[k].r * spheres[k].r - (middle - z[k]) * (middle - z[k]);
      if (w > widest) widest = w, who = k;
    }
    if (!(widest > 0)) continue;
    // rho^2 = r^2 - t^2 with t = z - centre
    const double r2 = spheres[who].r * spheres[who].r, s = z[who], ta = a - s, tb = b - s;
    double i[5];
    for (int k = 0; k < 5; ++k) i[k] = power_integral(ta, tb, k);
    const double m0 = r2 * i[0] - i[2], m1 = r2 * i[1] - i[3], m2 = r2 * i[2] - i[4];
    v = v + det::k_pi * m0;
    first = first + det::k_pi * (m1 + s * m0);
    along = along + det::k_pi * ((m2 + 2 * s * m1) + s * s * m0);
    across = across + 0.25 * det::k_pi * ((r2 * r2 * i[0] - 2 * r2 * i[2]) + i[4]);
  }
  MassProperties out;
  out.volume = v;
  const double centre = first / v, spread = along - centre * first;
  out.centre = p + centre * e;
  // axial moment 2 across, transverse spread + across
  const double transverse = spread + across, less = 2 * across - transverse;
  out.inertia = {transverse + less * e.x * e.x,
                 transverse + less * e.y * e.y,
                 transverse + less * e.z * e.z,
                 less * e.x * e.y,
                 less * e.x * e.z,
                 less * e.y * e.z};
  return out;
}

/// Direction of the line through all centres; false where they span more than rounding.
bool on_a_line(std::span<const SubSphere> spheres, Vec3& e) {
  double far = 0;
  e = {0, 0, 1};
  for (const SubSphere& s : spheres) {
    const Vec3 d = s.x - spheres[0].x;
    if (norm2(d) > far) far = norm2(d), e = (1 / norm(d)) * d;
  }
  for (const SubSphere& s : spheres)
    if (norm2(cross(s.x - spheres[0].x, e)) > 1e-28 * far) return false;
  return true;
}

}  // namespace

MassProperties union_properties(std::span<const SubSphere> spheres, const std::string& where) {
  check(spheres, where);
  Vec3 e;
  if (on_a_line(spheres, e)) return turned(spheres, spheres[0].x, e);
  if (!any_overlap(spheres)) return apart(spheres);
  return column_quadrature(spheres);
}

PrincipalAxes principal_axes(const std::array<double, 6>& inertia) noexcept {
  double a[3][3] = {
      {inertia[0], inertia[3], inertia[4]}, {inertia[3], inertia[1], inertia[5]}, {inertia[4], inertia[5], inertia[2]}};
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int sweep = 0; sweep < 30; ++sweep) {  // Jacobi's rotations converge quadratically
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        if (!(__builtin_fabs(a[p][q]) > 1e-300)) continue;
        const double theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
        const double t = (theta < 0 ? -1 : 1) / (__builtin_fabs(theta) + __builtin_sqrt(theta * theta + 1));
        const double c = 1 / __builtin_sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double x = a[k][p], y = a[k][q];
          a[k][p] = c * x - s * y, a[k][q] = s * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const double x = v[k][p], y = v[k][q];
          v[k][p] = c * x - s * y, v[k][q] = s * x + c * y;
        }
      }
  }
  int order[3] = {0, 1, 2};
  std::stable_sort(order, order + 3, [&](int x, int y) { return a[x][x] < a[y][y]; });
  PrincipalAxes out;
  Vec3 axis[3];
  for (int k = 0; k < 3; ++k) {
    out.moments[k] = a[order[k]][order[k]];
    axis[k] = {v[0][order[k]], v[1][order[k]], v[2][order[k]]};
  }
  axis[2] = cross(axis[0], axis[1]);
  out.turn = quaternion_of(
      {{{axis[0].x, axis[1].x, axis[2].x}, {axis[0].y, axis[1].y, axis[2].y}, {axis[0].z, axis[1].z, axis[2].z}}});
  return out;
}

double clump_radius(std::span<const SubSphere> spheres, Vec3 centre) noexcept {
  double r = 0;
  for (const SubSphere& s : spheres) r = fmax2(r, norm(s.x - centre) + s.r);
  return r;
}

std::vector<SubSphere> read_clump(const std::string& path) {
  const ParticleFile file = read_particle_file(path, {});
  std::vector<SubSphere> spheres;
  for (std::size_t k = 0; k < file.size(); ++k) spheres.push_back({file.x[k], file.r[k]});
  return spheres;
}

}  // namespace talus::shapes
