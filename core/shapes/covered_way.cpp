// See covered_way.hpp.
#include "core/shapes/covered_way.hpp"

#include <algorithm>
#include <utility>

namespace talus::shapes {
namespace {

/// A place of a wall above the way: how far along it, and how far behind the plane [m].
struct Place {
  double along = 0, behind = 0;
};

/// Between two places on a straight line: the part within [low, high] behind the plane; empty: first > second.
using Interval = std::pair<double, double>;
Interval part_within(Place a, Place b, double low, double high) {
  if (b.along < a.along) std::swap(a, b);
  const double rise = b.behind - a.behind, length = b.along - a.along;
  double from = a.along, to = b.along;
  for (const double limit : {low, high}) {
    const bool is_low = limit == low;
    const bool a_out = is_low ? a.behind < limit : a.behind > limit,
               b_out = is_low ? b.behind < limit : b.behind > limit;
    if (a_out && b_out) return {1, 0};
    const double at = a.along + length * ((limit - a.behind) / (rise != 0 ? rise : 1));
    if (a_out) from = fmax2(from, at);
    if (b_out) to = fmin2(to, at);
  }
  return {from, to};
}

/// The way, its plane, and how a point lies to both.
struct Way {
  Vec3 from, along, across, into;
  double length = 0, slack = 0;

  /// The part of a triangle above the way: first and last place. False: none.
  bool cross(const WallPiece& p, Place& first, Place& last) const {
    bool any = false;
    const auto add = [&](double along_it, double behind) {
      if (!any || along_it < first.along) first = {along_it, behind};
      if (!any || along_it > last.along) last = {along_it, behind};
      any = true;
    };
    double a[3], s[3], d[3];
    for (int k = 0; k < 3; ++k) {
      const Vec3 x = p.corner[k] - from;
      a[k] = dot(x, along), s[k] = dot(x, across), d[k] = dot(x, into);
      if (__builtin_fabs(s[k]) <= slack) add(a[k], d[k]);
    }
    for (int k = 0; k < 3; ++k) {
      const int o = (k + 1) % 3;
      if (!((s[k] < 0 && s[o] > 0) || (s[k] > 0 && s[o] < 0))) continue;
      const double t = s[k] / (s[k] - s[o]);
      add(a[k] + t * (a[o] - a[k]), d[k] + t * (d[o] - d[k]));
    }
    return any;
  }
  /// Of a plane, which has no end.
  bool cross_plane(const WallPiece& p, Place& first, Place& last) const {
    const double tilt = dot(p.normal, into);
    if (__builtin_fabs(tilt) < 1e-6) return false;
    const auto behind = [&](double t) { return dot(p.corner[0] - (from + t * along), p.normal) / tilt; };
    first = {0, behind(0)}, last = {length, behind(length)};
    return true;
  }
};

}  // namespace

bool covered_way(const std::vector<WallPiece>& pieces, Vec3 from, Vec3 into, Vec3 to, double depth, double slack) {
  const double end = dot(to - from, into);
  const Vec3 flat = (to - from) - end * into;
  Way way{from, {}, {}, into, norm(flat), slack};
  if (way.length <= slack) return true;
  way.along = (1 / way.length) * flat;
  way.across = cross(into, way.along);
  static thread_local std::vector<Interval> covered;
  covered.clear();
  for (const WallPiece& p : pieces) {
    Place first, last;
    if (p.kind == WallPiece::Kind::triangle ? !way.cross(p, first, last)
                                            : p.kind != WallPiece::Kind::plane || !way.cross_plane(p, first, last))
      continue;
    const Interval part = part_within(first, last, -slack, fmax2(depth, end) + slack);
    if (part.first <= part.second && part.second >= 0 && part.first <= way.length) covered.push_back(part);
  }
  std::sort(covered.begin(), covered.end());
  double reached = 0;
  for (const Interval& part : covered) {
    if (part.first > reached + slack) return false;
    reached = fmax2(reached, part.second);
  }
  return reached >= way.length - slack;
}

}  // namespace talus::shapes
