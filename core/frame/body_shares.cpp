// See body_shares.hpp.
#include "core/frame/body_shares.hpp"

#include <algorithm>

#include "core/base/count.hpp"
#include "core/base/det_math.hpp"
#include "core/gas/overlap.hpp"
#include "core/grains/body.hpp"
#include "core/grains/body_shape.hpp"
#include "core/grains/region.hpp"
#include "core/walls/closed_surface.hpp"

namespace talus {

namespace {

// Of a body. A side that passes the centre of a piece makes a jump, which such a lattice meets with an error of some
// N^(-3/4), 1e-3; other sides make kinks, with N^(-5/4). Errors of pieces are at random: n pieces need N / n^(2/3) rays
// each for the same.
constexpr int k_rays = 8192, k_fewest = 512;
constexpr double k_golden = 0.6180339887498949, k_plastic = 0.7548776662466927;

int rays_of(std::size_t pieces) {
  const double n = k_rays / det::pow(static_cast<double>(pieces), 2.0 / 3);
  return 2 * static_cast<int>(count_nearest(n / 2, k_fewest / 2, k_rays / 2));
}

double part(double x) { return x - static_cast<double>(static_cast<int>(x)); }

double cube(double t) { return t * t * t; }

/// Direction k of n: a lattice of golden turns and its mirror image, of equal weights; so what is cut through its
/// centre is cut in halves.
Vec3 direction(int k, int n) {
  const int half = k / 2;
  const double z = 1 - (2 * half + 1.0) / (n / 2), rho = __builtin_sqrt(1 - z * z);
  const auto a = det::sincos_turns(part(k_golden * half));
  const Vec3 u{rho * a.cos, rho * a.sin, z};
  return k % 2 == 0 ? u : -u;
}

/// Part [from, to] of a line.
struct Interval {
  double from, to;
  void cut(double a, double b) { from = fmax2(from, a), to = fmin2(to, b); }
  /// Where low <= x + t w <= high.
  void between(double low, double high, double x, double w) {
    if (w == 0) {
      if (!(x >= low && x <= high)) to = from;
      return;
    }
    const double a = (low - x) / w, b = (high - x) / w;
    cut(fmin2(a, b), fmax2(a, b));
  }
  /// Where |x + t w| <= r, of the vectors whose products these are.
  void within(double xx, double xw, double ww, double r) {
    const double c = xx - r * r, root = xw * xw - ww * c;
    if (!(ww > 0) || !(root > 0)) {
      if (!(c <= 0 && !(ww > 0))) to = from;
      return;
    }
    const double s = __builtin_sqrt(root);
    cut((-xw - s) / ww, (-xw + s) / ww);
  }
  double cubes() const { return to > from ? cube(to) - cube(from) : 0; }
};

/// Difference of t^3 along the part of x + t w, t in [from, 1], within the region.
double within(const Region& g, Vec3 x, Vec3 w, double from) {
  Interval t{from, 1};
  switch (g.shape) {
    case Region::Shape::box:
      for (int k = 0; k < 3; ++k) t.between(g.lower[k], g.upper[k], x[k], w[k]);
      if (g.radius > 0) {
        const double dx = x.x - 0.5 * (g.lower.x + g.upper.x), dy = x.y - 0.5 * (g.lower.y + g.upper.y);
        t.within(dx * dx + dy * dy, dx * w.x + dy * w.y, w.x * w.x + w.y * w.y, g.radius);
      }
      break;
    case Region::Shape::cylinder: {
      const Vec3 d = x - g.point;
      const double along = dot(d, g.axis), way = dot(w, g.axis);
      const Vec3 off = d - along * g.axis, side = w - way * g.axis;
      t.between(0, g.length, along, way);
      t.within(norm2(off), dot(off, side), norm2(side), g.radius);
      break;
    }
    case Region::Shape::sphere: {
      const Vec3 d = x - g.point;
      t.within(norm2(d), dot(d, w), norm2(w), g.radius);
      break;
    }
    case Region::Shape::mesh:
      return 0;
  }
  return t.cubes();
}

/// visit(shift) for the images of a sphere that touch the bounds of a region.
template <class Visit>
void each_image(const Domain& d, const Region& g, Vec3 x, double r, Visit visit) {
  int least[3], most[3];
  const Vec3 size = d.upper - d.lower;
  for (int k = 0; k < 3; ++k) least[k] = d.periodic(k) ? -1 : 0, most[k] = -least[k];
  for (int a = least[0]; a <= most[0]; ++a)
    for (int b = least[1]; b <= most[1]; ++b)
      for (int c = least[2]; c <= most[2]; ++c) {
        const Vec3 shift{a * size.x, b * size.y, c * size.z}, y = x + shift;
        bool meets = true;
        for (int k = 0; k < 3; ++k) meets = meets && y[k] + r > g.lower[k] && y[k] - r < g.upper[k];
        if (meets) visit(shift);
      }
}

/// First and last cells that a sphere reaches.
struct Reach {
  std::array<int, 3> first, count;
  bool one() const { return count[0] == 1 && count[1] == 1 && count[2] == 1; }
};
Reach reach_of(const ShareGrid& g, Vec3 x, double r) {
  Reach c;
  for (int k = 0; k < 3; ++k) {
    const auto a = static_cast<std::size_t>(k);
    c.first[a] = static_cast<int>(count_floor((x[k] - r - g.lower[k]) / g.spacing[k], g.least[a], g.most[a]));
    const int last = static_cast<int>(count_floor((x[k] + r - g.lower[k]) / g.spacing[k], g.least[a], g.most[a]));
    c.count[a] = last - c.first[a] + 1;
  }
  return c;
}

/// fn(cell, its lower corner) over all cells of a reach, x fastest.
template <class F>
void each_cell(const ShareGrid& g, const Reach& c, F fn) {
  for (int z = c.first[2]; z < c.first[2] + c.count[2]; ++z)
    for (int y = c.first[1]; y < c.first[1] + c.count[1]; ++y)
      for (int x = c.first[0]; x < c.first[0] + c.count[0]; ++x)
        fn(std::array<int, 3>{x, y, z},
           Vec3{g.lower.x + x * g.spacing.x, g.lower.y + y * g.spacing.y, g.lower.z + z * g.spacing.z});
}

}  // namespace

/// A piece of a body where it is now.
struct BodyShares::Placed {
  const Piece& piece;
  Vec3 centre;    // [m]
  double radius;  // [m]
  double scale;
  const shapes::Rotation& turn;
  Vec3 way(const Ray& r) const { return shapes::to_space(turn, scale * r.way); }
};

BodyShares::BodyShares(const Scene& scene) : scene_(&scene) {
  if (!makes_bodies(scene)) return;
  for (const ShapeSpec& s : scene.shapes) kinds_.push_back(pieces_of(*s.body));
}

BodyShares::Piece BodyShares::superquadric(const BodyShape& shape) {
  const shapes::Superquadric& s = shape.quadric->surface;
  Piece p{{}, shape.bound, 1, {}};
  double all = 0;
  for (int k = 0; k < k_rays; ++k) {  // evenly over the sphere that the axes make an ellipsoid of
    const Vec3 u = direction(k, k_rays), a{s.axes.x * u.x, s.axes.y * u.y, s.axes.z * u.z};
    const double rho = 1 / det::pow(shapes::inside_outside(s, a) + 1, 1 / s.n1);
    p.rays.push_back({rho * a, 0, cube(rho)});
    all += cube(rho);
  }
  for (Ray& r : p.rays) r.share /= all;
  return p;
}

/// Points that lie deeper in sphere k than in any other, by |x - c|^2 - r^2: convex, its sides are planes.
BodyShares::Piece BodyShares::part_of_clump(const BodyShape& shape, std::size_t k) {
  const shapes::SubSphere& s = shape.spheres[k];
  struct Side {
    Vec3 way;
    double most;
  };
  std::vector<Side> sides;
  for (std::size_t j = 0; j < shape.spheres.size(); ++j) {
    const shapes::SubSphere& o = shape.spheres[j];
    const Vec3 d = o.x - s.x;
    if (j == k || norm2(d) >= (s.r + o.r) * (s.r + o.r)) continue;
    sides.push_back({d, 0.5 * (norm2(d) + (s.r * s.r - o.r * o.r))});
  }
  Piece p{s.x, s.r, 4 * det::k_pi / 3 * cube(s.r) / shape.volume, {}, sides.empty()};
  if (p.ball) return p;
  const int rays = rays_of(shape.spheres.size());
  const double each = p.share / rays;
  p.share = 0;
  for (int q = 0; q < rays; ++q) {
    const Vec3 u = s.r * direction(q, rays);
    Interval t{0, 1};
    for (const Side& side : sides) {
      const double along = dot(u, side.way);
      if (along > 0) t.cut(0, side.most / along);
      if (along < 0) t.cut(side.most / along, 1);
      if (along == 0 && side.most < 0) t.to = t.from;
    }
    if (!(t.to > t.from)) continue;
    p.rays.push_back({t.to * u, t.from / t.to, each * cube(t.to)});
    p.share += each * t.cubes();
  }
  return p;
}

std::vector<BodyShares::Piece> BodyShares::pieces_of(const BodyShape& shape) {
  std::vector<Piece> all;
  if (shape.quadric) {
    if (shape.quadric->ball)
      all.push_back({{}, shape.bound, 1, {}, true});
    else
      all.push_back(superquadric(shape));
    return all;
  }
  double balls = 0, cut = 0;
  for (std::size_t k = 0; k < shape.spheres.size(); ++k) {
    all.push_back(part_of_clump(shape, k));
    (all.back().ball ? balls : cut) += all.back().share;
  }
  // all together are the body; what the rays err in goes to those that have rays
  const double ball = cut > 0 ? 1 : 1 / balls, other = cut > 0 ? (1 - balls) / cut : 1;
  for (Piece& p : all) {
    p.share *= p.ball ? ball : other;
    for (Ray& r : p.rays) r.share *= other;
  }
  return all;
}

template <class Visit>
void BodyShares::each_piece(const BodyRecord& b, Visit visit) const {
  const auto shape = static_cast<std::size_t>(b.shape);
  const auto& q = b.orientation;
  const shapes::Rotation turn =
      shapes::rotation(shapes::Quaternion{q[0], q[1], q[2], q[3]} * scene_->shapes[shape].body->turn);
  for (const Piece& p : kinds_[shape]) {
    const Vec3 centre = b.x + shapes::to_space(turn, b.scale * p.centre);
    visit(Placed{p, centre, b.scale * p.radius, b.scale, turn});
  }
}

double BodyShares::volume(const BodyRecord& b) const {
  return scene_->shapes[static_cast<std::size_t>(b.shape)].body->volume * cube(b.scale);
}

int BodyShares::spheres(const BodyRecord& b) const {
  return static_cast<int>(scene_->shapes[static_cast<std::size_t>(b.shape)].body->spheres.size());
}

double BodyShares::rays_inside(const Domain& domain, const Region& region, const Placed& p) {
  double sum = 0;
  each_image(domain, region, p.centre, p.radius, [&](Vec3 shift) {
    for (const Ray& r : p.piece.rays) sum += r.share * within(region, p.centre + shift, p.way(r), r.from);
  });
  return sum;
}

double BodyShares::points_inside(const Domain& domain, const Region& region, const Placed& p) {
  double in = 0, all = 0;
  for (std::size_t k = 0; k < p.piece.rays.size(); ++k) {  // a point on each ray, spread over its volume
    const Ray& r = p.piece.rays[k];
    const double low = cube(r.from), each = r.share * (1 - low);
    const double t = det::cbrt(low + (1 - low) * part(0.5 + k_plastic * static_cast<double>(k)));
    all += each;
    if (talus::inside(domain, region, p.centre + t * p.way(r))) in += each;
  }
  return all > 0 ? p.piece.share * (in / all) : 0;
}

double BodyShares::inside(const Domain& domain, const Region& region, const BodyRecord& b) const {
  constexpr double whole = 1 - 1e-12;  // of the sphere around a piece: then the piece lies within, too
  double sum = 0;
  each_piece(b, [&](const Placed& p) {
    const double share = share_inside(domain, region, p.centre, p.radius);
    if (p.piece.ball || share <= 0 || share >= whole)
      sum += p.piece.share * share;
    else
      sum += region.shape == Region::Shape::mesh ? points_inside(domain, region, p) : rays_inside(domain, region, p);
  });
  return sum;
}

void BodyShares::ray_cells(const ShareGrid& g, const Placed& p, std::vector<CellShare>& out) {
  const Reach c = reach_of(g, p.centre, p.radius);
  std::vector<double> sums(static_cast<std::size_t>(c.count[0]) * static_cast<std::size_t>(c.count[1]) *
                           static_cast<std::size_t>(c.count[2]));
  const auto add = [&](Vec3 x, double share) {
    std::size_t at = 0;
    for (int k = 2; k >= 0; --k) {
      const auto a = static_cast<std::size_t>(k);
      const int first = c.first[a], last = first + c.count[a] - 1;
      const auto cell = static_cast<int>(count_floor((x[k] - g.lower[k]) / g.spacing[k], first, last));
      at = at * static_cast<std::size_t>(c.count[a]) + static_cast<std::size_t>(cell - first);
    }
    sums[at] += share;
  };
  std::vector<double> ends;
  for (const Ray& r : p.piece.rays) {
    const Vec3 way = p.way(r);
    ends.assign({r.from, 1.0});
    for (int k = 0; k < 3; ++k)
      for (int s = 1; s < c.count[static_cast<std::size_t>(k)]; ++s) {
        const double side = g.lower[k] + (c.first[static_cast<std::size_t>(k)] + s) * g.spacing[k];
        const double t = way[k] == 0 ? 0 : (side - p.centre[k]) / way[k];
        if (t > r.from && t < 1) ends.push_back(t);
      }
    std::sort(ends.begin(), ends.end());
    for (std::size_t q = 1; q < ends.size(); ++q)
      add(p.centre + (0.5 * (ends[q - 1] + ends[q])) * way, r.share * (cube(ends[q]) - cube(ends[q - 1])));
  }
  std::size_t at = 0;
  each_cell(g, c, [&](std::array<int, 3> cell, Vec3) {
    if (const double share = sums[at++]; share > 0) out.push_back({cell, share});
  });
}

void BodyShares::cells(const ShareGrid& g, const BodyRecord& b, std::vector<CellShare>& out) const {
  out.clear();
  each_piece(b, [&](const Placed& p) {
    const Reach c = reach_of(g, p.centre, p.radius);
    if (c.one()) return out.push_back({c.first, p.piece.share});
    if (!p.piece.ball) return ray_cells(g, p, out);
    const double whole = Body{p.radius}.volume();
    each_cell(g, c, [&](std::array<int, 3> cell, Vec3 low) {
      const double v = gas::ball_in_box(p.centre, p.radius, low, low + g.spacing);
      if (v > 0) out.push_back({cell, p.piece.share * (v / whole)});
    });
  });
}

}  // namespace talus
