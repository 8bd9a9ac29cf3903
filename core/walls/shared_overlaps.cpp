// See shared_overlaps.hpp.
#include "core/walls/shared_overlaps.hpp"

#include <array>
#include <cmath>

namespace talus {
namespace {

constexpr double k_parallel = 1e-15;  // a squared sine that is rounding

constexpr double k_slack = 1.5;  // a curvature is not the same all the way

/// Cosine of the angle between their normals; from the feet, where these are edges or corners or the grain no sphere.
double angle(const Touch& a, const Touch& b) {
  const Vec3 way = b.foot - a.foot;
  if (a.radius > 0 && b.radius > 0) return 1 - norm2(way) / (2 * a.radius * a.radius);
  if (b.radius > 0) return 1 - dot(way, a.normal) / b.radius;
  if (a.radius > 0) return 1 + dot(way, b.normal) / a.radius;
  return dot(a.normal, b.normal);
}

bool joined(const Touch& a, const Touch& b) {
  if (a.surface != b.surface || !(angle(a, b) > k_one_contact)) return false;
  const double curve = k_slack * fmin2(a.curve, b.curve);
  return !(norm2(b.foot - a.foot) > curve * curve * norm2(b.normal - a.normal));
}

/// Numbers sets of touches that are joined directly or through others: group = the first of the set.
void number(std::span<Touch> touches) {
  for (Touch& t : touches) t.group = -1;
  for (int first = 0; first < static_cast<int>(touches.size()); ++first) {
    if (touches[first].group >= 0) continue;
    touches[first].group = first;
    for (bool found = true; found;) {
      found = false;
      for (Touch& t : touches)
        for (const Touch& of : touches)
          if (t.group < 0 && of.group == first && joined(t, of)) t.group = first, found = true;
    }
  }
}

/// Pressed from opposite sides (more than a right angle), as a grain that fills a tube: each touch is a spring of its
/// own.
bool squeezed(std::span<const Touch> t, int group) {
  for (const Touch& a : t)
    for (const Touch& b : t)
      if (a.group == group && b.group == group && dot(a.normal, b.normal) < 0) return true;
  return false;
}

/// The shares of at most three touches that leave nothing of their overlaps, if all are positive.
struct Shares {
  std::array<int, 3> touch{};
  std::array<double, 3> share{};
  int count = 0;
  double value = 0;  ///< d.s

  /// False: some share is not positive, or the normals depend on each other.
  bool solve(std::span<const Touch> t) {
    double lower[3][3], y[3];
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = i == j ? 1 : dot(t[touch[i]].normal, t[touch[j]].normal);
        for (int k = 0; k < j; ++k) sum = sum - lower[i][k] * lower[j][k];
        if (i == j && !(sum > k_parallel)) return false;
        lower[i][j] = i == j ? std::sqrt(sum) : sum / lower[j][j];
      }
      y[i] = t[touch[i]].overlap;
      for (int k = 0; k < i; ++k) y[i] = y[i] - lower[i][k] * y[k];
      y[i] = y[i] / lower[i][i];
    }
    value = 0;
    for (int i = count; i-- > 0;) {
      value = value + y[i] * y[i];
      share[i] = y[i];
      for (int k = i + 1; k < count; ++k) share[i] = share[i] - lower[k][i] * share[k];
      share[i] = share[i] / lower[i][i];
      if (!(share[i] > 0)) return false;
    }
    return true;
  }
};

/// The best of all sets of at most three touches of a group. (Normals in space: three are enough.)
void share_group(std::span<Touch> t, int group) {
  Shares best;
  const auto attempt = [&](Shares s) {
    if (s.solve(t) && s.value > best.value) best = s;
  };
  const int n = static_cast<int>(t.size());
  for (int i = group; i < n; ++i) {
    if (t[i].group != group) continue;
    attempt({{i}, {}, 1});
    for (int j = i + 1; j < n; ++j) {
      if (t[j].group != group) continue;
      attempt({{i, j}, {}, 2});
      for (int k = j + 1; k < n; ++k)
        if (t[k].group == group) attempt({{i, j, k}, {}, 3});
    }
  }
  for (int k = 0; k < best.count; ++k) t[best.touch[k]].share = best.share[k];
}

}  // namespace

bool share_overlaps(std::span<Touch> touches) {
  bool any = false;
  for (std::size_t i = 0; i < touches.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) any = any || joined(touches[i], touches[j]);
  if (!any) return false;
  number(touches);
  for (Touch& t : touches) t.share = 0;
  for (int k = 0; k < static_cast<int>(touches.size()); ++k) {
    if (touches[k].group != k) continue;
    if (!squeezed(touches, k)) {
      share_group(touches, k);
      continue;
    }
    for (int i = k; i < static_cast<int>(touches.size()); ++i)
      if (touches[i].group == k || i == k) touches[i].group = i, touches[i].share = touches[i].overlap;
  }
  return true;
}

JointContact joint_contact(std::span<const Touch> touches, int group) {
  JointContact joint;
  joint.bearing = group;
  Vec3 push;
  for (int k = group; k < static_cast<int>(touches.size()); ++k) {
    const Touch& t = touches[k];
    if (t.group != group || !(t.share > 0)) continue;
    push = push + t.share * t.normal;
    if (t.share > touches[joint.bearing].share) joint.bearing = k;
    ++joint.members;
  }
  joint.normal = touches[joint.bearing].normal;
  joint.overlap = touches[joint.bearing].share;
  if (joint.members > 1) {
    joint.overlap = norm(push);
    joint.normal = (1 / joint.overlap) * push;
  }
  return joint;
}

}  // namespace talus
