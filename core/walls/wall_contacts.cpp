// Candidates, reduced contacts and history hand-over of a WallSet.
// Who calls it: scheduler/ (rebuild and wall_contact nodes). Invariants: I1 (candidate distances are inflated by more
// than their rounding), I3 (element order), I4; elements stay in the wall's body frame: a centre is carried into it and
// the normal back.
//
// Reduction of the elements within reach of one sphere to contacts. A surface is touched where its distance to the
// centre has a local minimum. So a feature is no contact of its own if
//   (1) it lies at or behind the tangent plane of an accepted face, or of a nearer accepted edge or vertex: coplanar
//       neighbours, the far side of a convex body, and copies of an edge or vertex seen from each of its facets;
//   (2) it is an edge or vertex that lies in another facet which comes nearer to the centre elsewhere: facets are
//       convex, so the distance falls on the way there (the foot of a ramp, the diagonal of a box face near a corner).
// Faces are decided first, and only a face removes a face; then edges and vertices together, nearest first, because on
// a finely meshed corner an edge farther away than the corner itself belongs to the same convex surface. Those that are
// left share what they overlap with (shared_overlaps.hpp), and neighbours in a shallow fold become one contact.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/base/error.hpp"
#include "core/walls/shared_overlaps.hpp"
#include "core/walls/wall_motion.hpp"
#include "core/walls/wall_set.hpp"

namespace talus {
namespace {

constexpr double k_tangent_tolerance = 1e-9;    // of the radius
constexpr double k_candidate_inflation = 1e-9;  // of the reach: far above the rounding of a distance
constexpr double k_shift_rounding = 0x1p-48;    // of the shift of an image
constexpr double k_same_normal = 1e-18;         // squared difference
constexpr double k_bound_deflation = 1e-6;      // of a distance that is stored in single precision

struct Hit {
  Vec3 normal;
  double distance = 0;
  std::int32_t wall = 0, element = 0;
  Feature feature = Feature::face;
  Vec3 shift;  ///< of the image [m]
};

/// The wall itself before its images, those near it before those far away; an order for any two.
bool image_before(Vec3 a, Vec3 b) {
  const double a2 = norm2(a), b2 = norm2(b);
  return std::tie(a2, a.x, a.y, a.z) < std::tie(b2, b.x, b.y, b.z);
}

}  // namespace

/// Candidates among the elements of one image.
void WallSet::Impl::list(const Wall& w, Vec3 c, double reach, std::int32_t slot, Vec3 shift,
                         std::vector<std::int32_t>& out, std::vector<float>* distance) const {
  const Vec3 b = to_body(w.pose, c - shift);
  double coordinates = std::sqrt(norm2(c)) + std::sqrt(norm2(b)) + w.extent;
  if (w.images.any()) coordinates += std::sqrt(norm2(shift));
  const double rounding = 0x1p-48 * coordinates + w.slack;
  const double within = (reach + w.skin) * (1 + k_candidate_inflation) + rounding;
  const std::int32_t first = w.first_code + slot * w.count;
  const auto add = [&](std::int32_t element, double d) {
    if (!(d <= within)) return;
    out.push_back(element);
    if (distance != nullptr) distance->push_back(static_cast<float>((d - rounding) * (1 - k_bound_deflation)));
  };
  static thread_local std::vector<NearElement> near;
  near.clear();
  w.shape->near(b, within * (1 + k_candidate_inflation), within, near);
  for (const NearElement& e : near) add(first + e.element, e.distance);
}

/// More than the distance within which an image of the wall has candidates, whatever rounds [m].
double WallSet::Impl::generous(const Wall& w, Vec3 c, double reach) const {
  const double coordinates = std::sqrt(norm2(c)) + std::sqrt(norm2(w.pose.translation)) + w.extent;
  return (reach + w.skin) * (1 + 1e-6) + w.slack + 1e-12 * coordinates;
}

void WallSet::candidates(Vec3 c, double reach, std::vector<std::int32_t>& out, std::vector<float>* distance) const {
  for (int i = 0; i < size(); ++i) {
    const Wall& w = impl_->walls[i];
    if (!w.pose.active) continue;
    if (!w.images.any()) {
      impl_->list(w, c, reach, 0, {}, out, distance);
      continue;
    }
    w.images.for_near(c, impl_->generous(w, c, reach), [&](std::int32_t slot, const Periods& image) {
      impl_->list(w, c, reach, slot, w.images.shift(image), out, distance);
    });
  }
}

void WallSet::audit_candidates(Vec3 c, double reach, std::vector<std::int32_t>& out) const {
  for (int i = 0; i < size(); ++i) {
    const Wall& w = impl_->walls[i];
    if (!w.pose.active) continue;
    const double generous = impl_->generous(w, c, reach);
    w.images.for_all([&](std::int32_t slot, const Periods& image) {
      const Vec3 shift = w.images.shift(image);
      if (w.images.away(c - shift) <= generous) impl_->list(w, c, reach, slot, shift, out, nullptr);
    });
  }
}

namespace {

/// Decodes candidates one after the other; those of one wall and image follow each other mostly.
class CandidateReader {
 public:
  CandidateReader(const std::vector<Wall>& walls, Vec3 c, const WallSet::Wraps& wraps)
      : walls_(walls), c_(c), wraps_(wraps) {}

  /// Wall and image of the candidate; false where the wall does not act now.
  bool read(std::int32_t code) {
    while (code >= walls_[wall].end_code) ++wall, first_ = -1;
    const Wall& w = walls_[wall];
    if (first_ < 0 || code < first_ || code >= first_ + w.count) place(w, code);
    facet = code - first_;
    return w.pose.active;
  }

  std::size_t wall = 0;
  std::int32_t facet = 0;  ///< element of the wall
  Vec3 shift;              ///< of the image [m]
  Vec3 body;               ///< the centre in the body frame of the image

 private:
  void place(const Wall& w, std::int32_t code) {
    std::int32_t slot = 0;
    if (w.images.any()) {
      slot = (code - w.first_code) / w.count;
      Periods image = w.images.image(slot);
      for (int k = 0; k < 3; ++k) image[k] += wraps_[k];
      shift = w.images.shift(image);
    } else {
      shift = {};
    }
    first_ = w.first_code + slot * w.count;
    body = to_body(w.pose, c_ - shift);
  }

  const std::vector<Wall>& walls_;
  Vec3 c_;
  const WallSet::Wraps& wraps_;
  std::int32_t first_ = -1;  ///< code of the first element of this image
};

/// Closest points nearer than the radius, normals in the world frame.
void collect_hits(const std::vector<Wall>& walls, Vec3 c, double radius, std::span<const std::int32_t> candidates,
                  const WallSet::Wraps& wraps, std::vector<Hit>& hits) {
  CandidateReader at(walls, c, wraps);
  for (const std::int32_t code : candidates) {
    if (!at.read(code)) continue;
    const Wall& w = walls[at.wall];
    ElementHit hit;
    if (!w.shape->closest(at.facet, at.body, radius + w.slack, hit)) continue;
    if (hit.distance < radius)
      hits.push_back({direction_to_world(w.pose, hit.normal), hit.distance, static_cast<std::int32_t>(at.wall),
                      w.first + at.facet, hit.feature, at.shift});
  }
}

/// True if the closest point of `b` lies in the facet of `a`, which comes nearer to the centre elsewhere.
bool leads_nearer(const Wall& wall, const Hit& a, const Hit& b, Vec3 c, double tolerance) {
  if (!wall.shape->facets || !(a.distance < b.distance)) return false;
  const Vec3 point = to_body(wall.pose, (c - a.shift) - b.distance * b.normal);
  ElementHit hit;
  wall.shape->closest(a.element - wall.first, point, k_never, hit);
  return hit.distance <= tolerance;
}

/// Where images overlap, a surface is there more than once and rounding alone decides which copy comes first: takes
/// the copy that is nearest to the wall itself, whatever the list held.
void settle_image(Hit& a, const std::vector<Hit>& hits, double tolerance) {
  for (const Hit& h : hits) {
    const double d = h.distance - a.distance;
    if (h.wall == a.wall && h.feature == a.feature && d <= tolerance && -d <= tolerance &&
        norm2(h.normal - a.normal) <= k_same_normal && image_before(h.shift, a.shift))
      a = h;
  }
}

/// Faces first, each group nearest first; an edge wins against a vertex at the same distance.
void sort_by_rank(std::vector<Hit>& hits) {
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    const bool fa = a.feature == Feature::face, fb = b.feature == Feature::face;
    if (fa != fb) return fa;
    if (a.distance != b.distance) return a.distance < b.distance;
    if (a.feature != b.feature) return a.feature < b.feature;
    if (image_before(a.shift, b.shift) || image_before(b.shift, a.shift)) return image_before(a.shift, b.shift);
    return a.element < b.element;
  });
}

/// Hits with what they overlap with as their own; one of a contact of several facets is the facet that bears most.
/// Returns how many are left.
int share(const std::vector<Wall>& walls, std::span<Hit> hits, double radius) {
  static thread_local std::vector<Touch> touches;
  touches.clear();
  for (const Hit& h : hits)
    touches.push_back({h.normal, radius - h.distance, walls[h.wall].surface, -h.distance * h.normal,
                       h.feature == Feature::face ? 0 : radius});
  const int n = static_cast<int>(hits.size());
  if (!share_overlaps(touches)) return n;
  std::array<Hit, WallSet::k_max_touches> left;
  int count = 0;
  for (int k = 0; k < n; ++k) {
    if (touches[k].group != k) continue;
    const JointContact joint = joint_contact(touches, k);
    if (!(joint.overlap > 0)) continue;
    left[count] = hits[joint.bearing];
    left[count].normal = joint.normal;
    left[count++].distance = radius - joint.overlap;
  }
  std::copy_n(left.begin(), count, hits.begin());
  return count;
}

}  // namespace

int WallSet::contacts(Vec3 c, double radius, std::span<const std::int32_t> candidates, WallContact* out,
                      const Wraps& wraps) const {
  if (candidates.empty()) return 0;
  const std::vector<Wall>& walls = impl_->walls;
  static thread_local std::vector<Hit> hits;
  hits.clear();
  collect_hits(walls, c, radius, candidates, wraps, hits);

  const auto contact = [&](const Hit& h) {
    const Vec3 centre = c - h.shift, point = centre - h.distance * h.normal;
    return WallContact{h.wall, h.element, h.normal, h.distance, velocity_at(walls[h.wall].pose, point, impl_->dt),
                       centre};
  };
  if (hits.empty()) return 0;
  if (hits.size() == 1) {
    out[0] = contact(hits[0]);
    return 1;
  }
  static thread_local std::array<Hit, k_max_touches> accepted;  // not cleared at every call
  int count = 0;
  auto accept = [&](const Hit& h) {
    if (count == k_max_touches) refuse_touches(radius, c, k_max_touches);
    accepted[count++] = h;
  };
  auto tolerance = [&](const Hit& a, const Hit& b) {
    // shifting the centre rounds at the size of the shift
    const double rounding = k_shift_rounding * fmax2(norm(a.shift), norm(b.shift));
    return fmax2(k_tangent_tolerance * radius, fmax2(rounding, fmax2(walls[a.wall].slack, walls[b.wall].slack)));
  };
  auto behind_accepted = [&](const Hit& h) {
    for (int k = 0; k < count; ++k) {
      const Hit& a = accepted[k];
      if (a.distance - h.distance * dot(a.normal, h.normal) <= tolerance(a, h)) return true;
    }
    return false;
  };
  sort_by_rank(hits);
  for (const Hit& h : hits) {
    if (behind_accepted(h)) continue;
    bool separate = true;
    if (h.feature != Feature::face)
      for (const Hit& a : hits)
        if (separate && leads_nearer(walls[a.wall], a, h, c, tolerance(a, h))) separate = false;
    if (separate) accept(h);
  }
  for (int k = 0; k < count; ++k)
    if (norm2(accepted[k].shift) > 0) settle_image(accepted[k], hits, tolerance(accepted[k], accepted[k]));
  if (count > 1) count = share(walls, {accepted.data(), static_cast<std::size_t>(count)}, radius);
  if (count > k_max_contacts) refuse_touches(radius, c, k_max_contacts);
  std::sort(accepted.begin(), accepted.begin() + count, [](const Hit& a, const Hit& b) {
    return a.element != b.element ? a.element < b.element : image_before(a.shift, b.shift);
  });
  for (int k = 0; k < count; ++k) out[k] = contact(accepted[k]);
  return count;
}

void WallSet::refuse_touches(double radius, Vec3 c, int most) const {
  const Vec3 x = impl_ ? c + impl_->walls.front().spec.corner : c;
  throw Error(ErrorCode::physics,
              fmt::format("a particle of radius {:.4g} m touches more than {} places of walls at once", radius, most),
              fmt::format("position ({:.6g}, {:.6g}, {:.6g})", x.x, x.y, x.z),
              "a mesh with fewer facets, edges and corners within the reach of one particle");
}

void WallSet::pieces(Vec3 c, std::span<const std::int32_t> candidates, std::vector<WallPiece>& out,
                     const Wraps& wraps) const {
  out.clear();
  CandidateReader at(impl_->walls, c, wraps);
  for (const std::int32_t code : candidates) {
    if (!at.read(code)) continue;
    const Wall& w = impl_->walls[at.wall];
    WallPiece p = w.shape->piece(at.facet);
    if (p.kind == WallPiece::Kind::none) continue;
    p.wall = static_cast<std::int32_t>(at.wall);
    p.element = w.first + at.facet;
    p.shift = at.shift;
    p.slack = w.slack + k_shift_rounding * norm(at.shift);
    for (Vec3& x : p.corner) x = to_world(w.pose, x) + at.shift;
    if (p.kind != WallPiece::Kind::triangle) p.normal = direction_to_world(w.pose, p.normal);
    out.push_back(p);
  }
}

Vec3 WallSet::velocity(int wall, Vec3 point) const {
  return velocity_at(impl_->walls[static_cast<std::size_t>(wall)].pose, point, impl_->dt);
}

void WallSet::match(std::span<const WallContact> before, std::span<const WallContact> now, std::int32_t* from) const {
  // An image is known by where the wall has the centre: it is a period away from where another image has it.
  const auto same = [&](const WallContact& a, const WallContact& b) {
    if (a.element != b.element) return false;
    if (size() == 0) return true;
    const Vec3 period = impl_->walls[b.wall].images.period();
    for (int k = 0; k < 3; ++k) {
      const double d = a.centre[k] - b.centre[k];
      if (period[k] > 0 && (d > 0.5 * period[k] || -d > 0.5 * period[k])) return false;
    }
    return true;
  };
  const auto one_surface = [&](int a, int b) { return a == b || (size() > 0 && surface(a) == surface(b)); };
  std::array<bool, k_max_contacts> taken{};
  for (std::size_t i = 0; i < now.size(); ++i) {
    from[i] = -1;
    for (std::size_t j = 0; j < before.size(); ++j)
      if (same(before[j], now[i]) && !taken[j]) {
        from[i] = static_cast<std::int32_t>(j);
        taken[j] = true;
        break;
      }
  }
  // The best remaining pair first, so that the outcome does not depend on the order of the contacts.
  for (;;) {
    double best = 0.9;
    std::size_t bi = 0, bj = 0;
    bool found = false;
    for (std::size_t i = 0; i < now.size(); ++i)
      for (std::size_t j = 0; j < before.size() && from[i] < 0; ++j)
        if (!taken[j] && one_surface(before[j].wall, now[i].wall) && dot(before[j].normal, now[i].normal) > best) {
          best = dot(before[j].normal, now[i].normal);
          bi = i, bj = j;
          found = true;
        }
    if (!found) return;
    from[bi] = static_cast<std::int32_t>(bj);
    taken[bj] = true;
  }
}

}  // namespace talus
