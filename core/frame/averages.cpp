// Averages; see averages.hpp.
#include "core/frame/averages.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/count.hpp"
#include "core/base/error.hpp"
#include "core/frame/body_shares.hpp"
#include "core/gas/overlap.hpp"
#include "core/grains/body.hpp"
#include "core/grains/region.hpp"

namespace talus {

namespace {

/// Share of a sphere's volume below a plane at signed distance t radii above its centre.
double below(double t) {
  if (t <= -1) return 0;
  if (t >= 1) return 1;
  return 0.25 * (2 + 3 * t - t * t * t);
}

Body body_of(const Frame& f, const Scene& s, std::size_t i) {
  return {f.r[i], s.materials[f.material.empty() ? 0 : f.material[i]].density};
}

/// The frame's where sizes change on their own, else by way of the volume: so its last bits are those of older series.
double mass_of(const Frame& f, const Scene& s, std::size_t i) {
  if (!f.mass.empty()) return f.mass[i];
  const Body body = body_of(f, s, i);
  return body.volume() * body.density;
}

/// A sphere, or a body with all its spheres: particles [first, end) of the frame.
struct Grain {
  std::size_t first, end;
  const BodyRecord* body;  ///< null: a sphere
  double mass, volume;
  Vec3 v;
  double contacts;
};

/// visit(grain) in the order of the frame, in which bodies stand as their first spheres do.
template <class Visit>
void each_grain(const Frame& f, const Scene& s, const BodyShares& shares, Visit visit) {
  auto next = f.bodies.begin();
  Grain g{};
  for (std::size_t i = 0; i < f.x.size(); i = g.end) {
    if (next != f.bodies.end() && next->id == f.id[i]) {
      g = {i, i + static_cast<std::size_t>(shares.spheres(*next)), &*next, next->mass, shares.volume(*next), next->v,
           0};
      ++next;
    } else {
      g = {i, i + 1, nullptr, mass_of(f, s, i), body_of(f, s, i).volume(), f.v[i], 0};
    }
    if (!f.coordination.empty())
      for (std::size_t k = g.first; k < g.end; ++k) g.contacts += f.coordination[k];
    visit(g);
  }
}

/// Weighted sums of one region or cell; add() all grains, mean(), deviate() all grains, finish().
struct Sums {
  double w = 0, mass = 0, volume = 0, contacts = 0, deviation = 0;
  Vec3 momentum, mean;
  std::array<double, 6> stress{};

  void add(const Frame& f, const Grain& g, double share) {
    const double m = share * g.mass, v = share * g.volume;
    w += share;
    mass += m;
    volume += v;
    momentum = momentum + m * g.v;
    if (!f.coordination.empty()) contacts += share * g.contacts;
    if (!f.stress.empty())
      for (int k = 0; k < 6; ++k) stress[k] += v * f.stress[g.first][k];  // all spheres of a body show its own
  }
  void close() {
    if (mass > 0) mean = (1 / mass) * momentum;
  }
  void deviate(const Grain& g, double share) { deviation += share * g.mass * norm2(g.v - mean); }
  RegionAverage finish(double region_volume) const {
    RegionAverage a;
    a.particles = w;
    a.velocity = mean;
    if (mass > 0) a.temperature = deviation / (3 * mass);
    if (w > 0) a.coordination = contacts / w;
    if (region_volume > 0) {
      a.solid_fraction = volume / region_volume;
      for (int k = 0; k < 6; ++k) a.stress[k] = stress[k] / region_volume;
    }
    return a;
  }
};

/// Cells of one axis that a sphere touches, with the share of the sphere in each slab.
struct Slabs {
  int first = 0;
  std::vector<double> share;
  std::vector<double> lower, upper;  ///< [m] of each slab; the outer ones reach as far as the sphere

  /// `least` and `most`: what lies beyond them is put into them.
  void fill(double centre, double r, double from, double h, int least, int most) {
    first = static_cast<int>(count_floor((centre - r - from) / h, least, most));
    const int last = static_cast<int>(count_floor((centre + r - from) / h, least, most));
    share.clear();
    lower.clear();
    upper.clear();
    double before = 0;  // what lies below the first slab is nothing
    for (int k = first; k <= last; ++k) {
      const double now = k == last ? 1.0 : below((from + (k + 1) * h - centre) / r);
      share.push_back(now - before);
      lower.push_back(k == first ? centre - 2 * r : from + k * h);
      upper.push_back(k == last ? centre + 2 * r : from + (k + 1) * h);
      before = now;
    }
  }
};

/// Share of the sphere in a cell: one of slabs where it lies between sides of one axis, else by the exact overlap.
double share_of_cell(const std::array<Slabs, 3>& slabs, const std::array<std::size_t, 3>& at, Vec3 centre, double r) {
  int cut = 0;
  double share = 1;
  Vec3 lower, upper;
  for (int a = 0; a < 3; ++a) {
    const Slabs& s = slabs[static_cast<std::size_t>(a)];
    const std::size_t k = at[static_cast<std::size_t>(a)];
    cut += s.share.size() > 1 ? 1 : 0;
    share *= s.share[k];
    lower[a] = s.lower[k];
    upper[a] = s.upper[k];
  }
  return cut > 1 ? gas::ball_in_box(centre, r, lower, upper) / Body{r}.volume() : share;
}

/// Puts the sums of all cells together.
class GridSums {
 public:
  GridSums(const Scene& scene, const GridData& g) : scene_(scene), g_(g) {
    sums.resize(static_cast<std::size_t>(g.cells[0]) * g.cells[1] * g.cells[2]);
    bodies_.lower = g.lower;
    bodies_.spacing = g.spacing;
    for (std::size_t a = 0; a < 3; ++a) {
      // a periodic side is longer than two diameters; elsewhere a grain may be larger than the domain
      const int beyond = scene.domain.periodic(static_cast<int>(a)) ? g.cells[a] : 1;
      bodies_.least[a] = -beyond;
      bodies_.most[a] = g.cells[a] - 1 + beyond;
    }
  }

  /// visit(sums of a cell, share of the sphere in it)
  template <class Visit>
  void of_sphere(Vec3 x, double r, Visit visit) {
    for (int a = 0; a < 3; ++a) slabs_[a].fill(x[a], r, g_.lower[a], g_.spacing[a], bodies_.least[a], bodies_.most[a]);
    for (std::size_t kz = 0; kz < slabs_[2].share.size(); ++kz) {
      const int z = index(2, slabs_[2].first + static_cast<int>(kz));
      if (z < 0) continue;
      for (std::size_t ky = 0; ky < slabs_[1].share.size(); ++ky) {
        const int y = index(1, slabs_[1].first + static_cast<int>(ky));
        if (y < 0) continue;
        for (std::size_t kx = 0; kx < slabs_[0].share.size(); ++kx) {
          const int at = index(0, slabs_[0].first + static_cast<int>(kx));
          if (at < 0) continue;
          const double share = share_of_cell(slabs_, {kx, ky, kz}, x, r);
          if (share > 0) visit(cell(at, y, z), share);
        }
      }
    }
  }

  /// The same of body number `k` of the frame; its shares are found once.
  template <class Visit>
  void of_body(const BodyShares& shares, const BodyRecord& b, std::size_t k, Visit visit) {
    if (k == parts_.size()) {
      shares.cells(bodies_, b, found_);
      parts_.emplace_back(found_);
    }
    for (const CellShare& p : parts_[k]) {
      const int x = index(0, p.at[0]), y = index(1, p.at[1]), z = index(2, p.at[2]);
      if (x >= 0 && y >= 0 && z >= 0) visit(cell(x, y, z), p.share);
    }
  }

  std::vector<Sums> sums;

 private:
  /// Of cell k on an axis: wrapped where periodic, -1 outside the domain.
  int index(int axis, int k) const {
    const int n = g_.cells[static_cast<std::size_t>(axis)];
    if (scene_.domain.periodic(axis)) return ((k % n) + n) % n;
    return k < 0 || k >= n ? -1 : k;
  }
  Sums& cell(int x, int y, int z) { return sums[(static_cast<std::size_t>(z) * g_.cells[1] + y) * g_.cells[0] + x]; }

  const Scene& scene_;
  const GridData& g_;
  ShareGrid bodies_;
  std::array<Slabs, 3> slabs_;
  std::vector<CellShare> found_;
  std::vector<std::vector<CellShare>> parts_;  // of bodies, for the second pass
};

bool wants_coordination(const Scene& s) { return s.output.coordination; }
bool wants_stress(const Scene& s) { return s.output.stress; }

using A = RegionAverage;
constexpr AverageQuantity k_averages[] = {
    {"particles", "-", "grains, those partly inside by their share of volume inside; the same weight in all averages",
     1, [](const A& a, double* to) { *to = a.particles; }, nullptr, false},
    {"solid_fraction", "-", "volume of grains inside / volume of the region", 1,
     [](const A& a, double* to) { *to = a.solid_fraction; }},
    {"velocity", "m/s", "mean velocity of the grains, weighted by mass", 3,
     [](const A& a, double* to) { to[0] = a.velocity.x, to[1] = a.velocity.y, to[2] = a.velocity.z; }},
    {"granular_temperature", "m2/s2", "a third of the mean square of velocities about their mean, weighted by mass", 1,
     [](const A& a, double* to) { *to = a.temperature; }},
    {"coordination", "-",
     "mean over grains of the column coordination of frames; a clump has the contacts of all its spheres", 1,
     [](const A& a, double* to) { *to = a.coordination; }, wants_coordination},
    {"stress", "Pa", "sum of the stress of grains times their volume inside / volume of the region", 6,
     [](const A& a, double* to) { std::copy(a.stress.begin(), a.stress.end(), to); }, wants_stress},
};

PolyColumn cell_column(const AverageQuantity& q, const std::vector<RegionAverage>& cells) {
  const auto width = static_cast<std::size_t>(q.components);
  std::vector<double> values(width * cells.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    double* const to = values.data() + width * k;
    q.value(cells[k], to);
    if (width == 6) std::swap(to[4], to[5]);  // to VTK's XX YY ZZ XY YZ XZ
  }
  return {std::string(q.name), q.components, std::move(values)};
}

}  // namespace

std::span<const AverageQuantity> average_quantities() noexcept { return k_averages; }

std::vector<const AverageQuantity*> averages_of(const Scene& scene) {
  std::vector<const AverageQuantity*> wanted;
  for (const AverageQuantity& q : k_averages)
    if (q.wanted == nullptr || q.wanted(scene)) wanted.push_back(&q);
  return wanted;
}

RegionAverage average_region(const Frame& frame, const Scene& scene, const Region& region) {
  return average_region(frame, scene, region, BodyShares(scene));
}

RegionAverage average_region(const Frame& frame, const Scene& scene, const Region& region, const BodyShares& shares) {
  Sums sums;
  std::vector<double> share;  // of bodies, which are costly, for the second pass
  for (int pass = 0; pass < 2; ++pass) {
    std::size_t next = 0;
    each_grain(frame, scene, shares, [&](const Grain& g) {
      double in = 0;
      if (g.body == nullptr)
        in = share_inside(scene.domain, region, frame.x[g.first], frame.r[g.first]);
      else if (pass == 0)
        share.push_back(in = shares.inside(scene.domain, region, *g.body));
      else
        in = share[next++];
      if (in <= 0) return;
      pass == 0 ? sums.add(frame, g, in) : sums.deviate(g, in);
    });
    if (pass == 0) sums.close();
  }
  return sums.finish(volume(region));
}

GridData average_grid(const Frame& frame, const Scene& scene, std::array<int, 3> cells) {
  return average_grid(frame, scene, cells, BodyShares(scene));
}

GridData average_grid(const Frame& frame, const Scene& scene, std::array<int, 3> cells, const BodyShares& shares) {
  for (int n : cells)
    if (n < 1) throw Error(ErrorCode::io, "averaging grid needs at least one cell per axis", "output.grid");
  const Vec3 size = scene.domain.upper - scene.domain.lower;
  GridData g;
  g.lower = scene.domain.lower;
  g.cells = cells;
  g.spacing = {size.x / cells[0], size.y / cells[1], size.z / cells[2]};
  GridSums grid(scene, g);
  for (int pass = 0; pass < 2; ++pass) {
    each_grain(frame, scene, shares, [&](const Grain& grain) {
      const auto put = [&](Sums& cell, double share) {
        pass == 0 ? cell.add(frame, grain, share) : cell.deviate(grain, share);
      };
      if (grain.body == nullptr)
        grid.of_sphere(frame.x[grain.first], frame.r[grain.first], put);
      else
        grid.of_body(shares, *grain.body, static_cast<std::size_t>(grain.body - frame.bodies.data()), put);
    });
    if (pass == 0)
      for (Sums& s : grid.sums) s.close();
  }
  std::vector<RegionAverage> averages;
  averages.reserve(grid.sums.size());
  for (const Sums& s : grid.sums) averages.push_back(s.finish(g.spacing.x * g.spacing.y * g.spacing.z));
  // By the scene, not by the frame: a frame without particles has the same columns as the others.
  for (const AverageQuantity* q : averages_of(scene))
    if (q->in_grids) g.cell_data.push_back(cell_column(*q, averages));
  return g;
}

double grid_bytes(std::array<int, 3> cells) noexcept {
  constexpr double columns = 12 * sizeof(double);  // solid fraction to stress
  return (sizeof(Sums) + sizeof(RegionAverage) + columns) * static_cast<double>(cells[0]) * cells[1] * cells[2];
}

}  // namespace talus
