// See body_walls.hpp. The reduction is that of core/walls/wall_contacts.cpp with overlaps in place of distances.
#include "core/shapes/body_walls.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/shapes/covered_way.hpp"
#include "core/shapes/wall_contact.hpp"
#include "core/walls/shared_overlaps.hpp"

namespace talus::shapes {
namespace {

constexpr double k_tangent_tolerance = 1e-7;  // of the bound; feet on edges are known to a tenth of it

struct Hit {
  WallContact c;  ///< normal into the wall
  Vec3 foot;      ///< the wall's point [m]
  const WallPiece* piece = nullptr;
  bool face = false;
};

Vec3 foot_of(const WallContact& c) { return c.point - (0.5 * c.overlap) * c.normal; }

bool inside(const WallPiece& p, Vec3 normal, Vec3 x) {
  for (int k = 0; k < 3; ++k)
    if (dot(cross(p.corner[(k + 1) % 3] - p.corner[k], x - p.corner[k]), normal) < 0) return false;
  return true;
}

Vec3 normal_of(const WallPiece& p) {
  if (p.kind == WallPiece::Kind::plane) return p.normal;
  const Vec3 area = cross(p.corner[1] - p.corner[0], p.corner[2] - p.corner[0]);
  return (1 / norm(area)) * area;
}

Vec3 nearest_of_segment(Vec3 a, Vec3 b, Vec3 x) {
  const Vec3 e = b - a;
  const double t = dot(x - a, e) / norm2(e), at = fmin2(1, fmax2(0, t));
  return a + at * e;
}

double distance_to_segment(Vec3 a, Vec3 b, Vec3 x) { return norm(x - nearest_of_segment(a, b, x)); }

Vec3 nearest_of_triangle(const WallPiece& p, Vec3 x) {
  const Vec3 n = normal_of(p);
  if (inside(p, n, x)) return x - dot(x - p.corner[0], n) * n;
  Vec3 nearest = p.corner[0];
  for (int k = 0; k < 3; ++k) {
    const Vec3 y = nearest_of_segment(p.corner[k], p.corner[(k + 1) % 3], x);
    if (norm2(y - x) < norm2(nearest - x)) nearest = y;
  }
  return nearest;
}

double distance_to_triangle(const WallPiece& p, Vec3 x) { return norm(nearest_of_triangle(p, x) - x); }

/// The part of an edge that the body can reach: the shorter it is, the better its contact is resolved.
void clip(Vec3 centre, double reach, Vec3& a, Vec3& b) {
  const Vec3 e = b - a;
  const double length = norm(e), middle = dot(centre - a, e) / length, most = 1.01 * reach;
  const Vec3 unit = (1 / length) * e, from = a;
  if (middle - most > 0) a = from + (middle - most) * unit;
  if (middle + most < length) b = from + (middle + most) * unit;
}

bool before(Vec3 a, Vec3 b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }

/// Some direction is seen to part body and edge: looked for along the way to the edge, from the centre and then from
/// the body's farthest point. None found proves nothing.
bool parted(const Body& body, double bound, Vec3 a, Vec3 b) {
  const double tiny = 1e-9 * bound;
  Vec3 n = nearest_of_segment(a, b, body.centre) - body.centre;
  for (int k = 0; k < 6; ++k) {
    const double size = norm(n);
    if (!(size > tiny)) return false;
    n = (1 / size) * n;
    const Vec3 m = to_body(body.turn, n);
    const Support<Plain> s = support<Plain>(body.form, {m.x, m.y, m.z}, k_eta);
    if (s.h < fmin2(dot(n, a - body.centre), dot(n, b - body.centre)) - 1e-12 * bound) return true;
    const Vec3 point = body.centre + to_space(body.turn, {s.point.x, s.point.y, s.point.z});
    const Vec3 way = nearest_of_segment(a, b, point) - point;
    const double length = norm(way);
    if (!(length > tiny)) return false;
    n = n + (1 / length) * way;
  }
  return false;
}

/// Edges and corners of a triangle whose face is not met: the deepest of them.
bool edge_hit(const Body& body, double bound, const WallPiece& p, Hit& hit) {
  bool found = false;
  PairCount count;
  for (int k = 0; k < 3; ++k) {
    Vec3 a = p.corner[k], b = p.corner[(k + 1) % 3];
    if (!(distance_to_segment(a, b, body.centre) < bound) || parted(body, bound, a, b)) continue;
    if (before(b, a)) std::swap(a, b);
    clip(body.centre, bound, a, b);
    const WallContact e = edge_contact(body, a, b, count);
    if (!(e.overlap > 0) || (found && e.overlap <= hit.c.overlap)) continue;
    hit = {e, foot_of(e), &p, false};
    found = true;
  }
  return found;
}

/// The line from the centre to the deepest point behind a facet goes through it, no border of which is met: a thin body
/// has come through its middle.
bool pierced(const Body& body, const WallPiece& p, Hit& hit) {
  const Vec3 n = normal_of(p);
  const WallContact c = plane_contact(body, p.corner[0], (dot(body.centre - p.corner[0], n) < 0 ? -1 : 1) * n);
  const Vec3 way = (c.point + (0.5 * c.overlap) * c.normal) - body.centre;
  const double height = dot(way, c.normal);
  if (!(height > 0) || !inside(p, n, body.centre + ((height - c.overlap) / height) * way)) return false;
  hit = {c, foot_of(c), &p, true};
  return true;
}

/// From inside a long body meets a cylinder in two places.
void add_cylinder(const Body& body, const WallPiece& p, std::vector<Hit>& hits) {
  ConeWall wall;
  wall.apex = p.corner[0];
  wall.axis = p.normal;
  wall.reach = p.radius;
  const Vec3 d = body.centre - p.corner[0], across = d - dot(d, p.normal) * p.normal;
  if (norm2(across) < p.radius * p.radius) {
    WallContact c[2];
    const int n = cone_contacts_inside(body, wall, c);
    for (int k = 0; k < n; ++k) hits.push_back({c[k], foot_of(c[k]), &p, true});
    return;
  }
  const WallContact c = cylinder_contact_outside(body, wall);
  if (c.overlap > 0) hits.push_back({c, foot_of(c), &p, true});
}

/// Planes and faces that are met go to the hits, triangles that may be met at an edge to `edges`.
void add_face(const Body& body, const WallPiece& p, std::vector<Hit>& hits, std::vector<const WallPiece*>& edges) {
  const Vec3 n = normal_of(p);
  const double side = dot(body.centre - p.corner[0], n) < 0 ? -1 : 1;
  const WallContact c = plane_contact(body, p.corner[0], side * n);
  if (!(c.overlap > 0)) return;  // the plane parts them
  PairCount count;
  if (p.kind == WallPiece::Kind::plane || (inside(p, n, c.point) && freed_by_face(body, p.corner, c, count)))
    hits.push_back({c, foot_of(c), &p, true});
  else
    edges.push_back(&p);
}

bool hit_before(const Hit& a, const Hit& b) {
  if (a.face != b.face) return a.face;
  if (a.c.overlap != b.c.overlap) return a.c.overlap > b.c.overlap;
  const double a2 = norm2(a.piece->shift), b2 = norm2(b.piece->shift);
  return std::tie(a2, a.piece->element) < std::tie(b2, b.piece->element);
}

/// From the foot of a to this place of a wall there is no gap: a long body that spans one lies on both its sides.
bool joined(const Hit& a, Vec3 foot, const std::vector<WallPiece>& pieces, double slack) {
  if (a.piece->kind == WallPiece::Kind::triangle && distance_to_triangle(*a.piece, foot) <= slack) return true;
  return covered_way(pieces, a.foot, a.c.normal, foot, a.c.overlap, slack);
}

/// At or behind the tangent plane of an accepted one.
bool behind(const Hit& a, const Hit& h, double tolerance) { return dot(h.foot - a.foot, a.c.normal) >= -tolerance; }

/// All of a triangle lies at or behind the tangent plane of an accepted face, without a gap: so does every contact with
/// its edges.
bool hidden(const WallPiece& p, const std::vector<const Hit*>& accepted, const std::vector<WallPiece>& pieces,
            double slack) {
  return std::any_of(accepted.begin(), accepted.end(), [&](const Hit* a) {
    for (const Vec3& corner : p.corner)
      if (!(dot(corner - a->foot, a->c.normal) >= -1e-3 * slack)) return false;
    return joined(*a, nearest_of_triangle(p, a->foot), pieces, slack);
  });
}

/// The foot of h lies in the facet of a, which is met deeper elsewhere.
bool leads_deeper(const Hit& a, const Hit& h, double tolerance) {
  return a.piece->kind == WallPiece::Kind::triangle && a.c.overlap > h.c.overlap &&
         distance_to_triangle(*a.piece, h.foot) <= tolerance;
}

/// Of sorted hits those that lie behind no other one of the same surface; an edge must not lead to a deeper place of
/// the same wall.
void accept(const std::vector<Hit>& hits, const std::vector<WallPiece>& pieces, double slack,
            std::vector<const Hit*>& accepted) {
  accepted.clear();
  for (const Hit& h : hits) {
    const bool same = std::any_of(accepted.begin(), accepted.end(), [&](const Hit* a) {
      return behind(*a, h, slack) && (a->piece == h.piece || joined(*a, h.foot, pieces, slack));
    });
    const bool leads = !h.face && std::any_of(hits.begin(), hits.end(), [&](const Hit& a) {
      return a.piece->wall == h.piece->wall && leads_deeper(a, h, slack);
    });
    if (!same && !leads) accepted.push_back(&h);
  }
}

/// The place of one contact that turns the body as those of a group do together. What no force along its normal can do
/// (of second order in the angle between them) is left out.
Vec3 joint_foot(std::span<const Touch> touches, const std::vector<const Hit*>& hits, int group,
                const JointContact& joint, Vec3 centre) {
  Vec3 turn, middle;
  double sum = 0;
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (touches[k].group != group) continue;
    const Vec3 arm = hits[k]->foot - centre;
    turn = turn + touches[k].share * cross(arm, touches[k].normal);
    middle = middle + touches[k].share * arm;
    sum = sum + touches[k].share;
  }
  return centre + (1 / joint.overlap) * cross(joint.normal, turn) + (dot(middle, joint.normal) / sum) * joint.normal;
}

/// Largest radius of curvature where the body's normal is against n; at most that of an ellipsoid of its size.
double flattest(const Body& body, Vec3 n) {
  const Vec3 m = to_body(body.turn, -n);
  const Triple<Plain> normal{m.x, m.y, m.z};
  const Support<Plain> s = support<Plain>(body.form, normal, k_eta);
  const auto [u, v] = tangents<Plain>(normal);
  const double a = radii<Plain>(s, u, u), b = radii<Plain>(s, u, v), c = radii<Plain>(s, v, v), half = 0.5 * (a - c);
  const Triple<Plain>& axes2 = body.form.axes2;
  const double inner = std::sqrt(fmin2(axes2.x, fmin2(axes2.y, axes2.z)));
  return fmin2(0.5 * (a + c) + std::sqrt(half * half + b * b), body.size * body.size / inner);
}

/// Hits with what they overlap with as their own; one of a contact of several facets has the name of the one that bears
/// most.
void share(const WallSet& walls, const std::vector<const Hit*>& accepted, const Body& body, std::vector<Hit>& out) {
  static thread_local std::vector<Touch> touches;
  const Vec3 centre = body.centre;
  touches.clear();
  out.clear();
  int own = -1;  // an edge or a corner holds a body wherever it touches it
  for (const Hit* h : accepted)
    touches.push_back({-h->c.normal, h->c.overlap, h->face ? walls.surface(h->piece->wall) : own--, h->foot - centre});
  for (Touch& t : touches)
    if (touches.size() > 1) t.curve = flattest(body, t.normal);
  if (!share_overlaps(touches)) {
    for (const Hit* h : accepted) out.push_back(*h);
    return;
  }
  for (int k = 0; k < static_cast<int>(touches.size()); ++k) {
    if (touches[k].group != k) continue;
    const JointContact joint = joint_contact(touches, k);
    if (!(joint.overlap > 0)) continue;
    Hit h = *accepted[joint.bearing];
    h.c.normal = -joint.normal, h.c.overlap = joint.overlap;
    if (joint.members > 1) h.foot = joint_foot(touches, accepted, k, joint, centre);
    out.push_back(h);
  }
}

}  // namespace

void body_wall_contacts(const Body& body, double bound, const WallSet& walls, std::span<const std::int32_t> candidates,
                        const WallSet::Wraps& wraps, std::vector<BodyWallContact>& out) {
  static thread_local std::vector<WallPiece> pieces;
  static thread_local std::vector<Hit> hits, late;
  static thread_local std::vector<const Hit*> accepted;
  static thread_local std::vector<const WallPiece*> edges;
  out.clear();
  hits.clear();
  edges.clear();
  late.clear();
  walls.pieces(body.centre, candidates, pieces, wraps);
  double slack = k_tangent_tolerance * bound;
  for (const WallPiece& p : pieces) {
    if (p.kind == WallPiece::Kind::cylinder)
      add_cylinder(body, p, hits);
    else
      add_face(body, p, hits, edges);
    slack = fmax2(slack, p.slack);
  }
  std::stable_sort(hits.begin(), hits.end(), hit_before);
  accept(hits, pieces, slack, accepted);
  for (const WallPiece* p : edges) {
    Hit h;
    if (hidden(*p, accepted, pieces, slack)) continue;
    if (edge_hit(body, bound, *p, h) || pierced(body, *p, h)) late.push_back(h);
  }
  if (!late.empty()) {
    hits.insert(hits.end(), late.begin(), late.end());
    std::stable_sort(hits.begin(), hits.end(), hit_before);
    accept(hits, pieces, slack, accepted);
  }
  if (accepted.size() > static_cast<std::size_t>(WallSet::k_max_touches))
    walls.refuse_touches(bound, body.centre, WallSet::k_max_touches);
  static thread_local std::vector<Hit> contacts;
  share(walls, accepted, body, contacts);
  if (contacts.size() > static_cast<std::size_t>(WallSet::k_max_contacts))
    walls.refuse_touches(bound, body.centre, WallSet::k_max_contacts);
  std::stable_sort(contacts.begin(), contacts.end(), [](const Hit& a, const Hit& b) {
    const double a2 = norm2(a.piece->shift), b2 = norm2(b.piece->shift);
    return std::tie(a.piece->element, a2) < std::tie(b.piece->element, b2);
  });
  for (const Hit& h : contacts) {
    const WallPiece& p = *h.piece;
    out.push_back({{p.wall, p.element, -h.c.normal, bound - h.c.overlap, walls.velocity(p.wall, h.foot - p.shift),
                    body.centre - p.shift},
                   h.foot - body.centre});
  }
}

}  // namespace talus::shapes
