// See heat_neighbours.hpp.
#include "scheduler/parts/heat_neighbours.hpp"

#include <algorithm>

#include "core/heat/radiation.hpp"

namespace talus {
namespace {

/// fn(image - place of the other, whether it is the nearest one) of all images within reach; d: to the nearest one.
template <class F>
void for_images(const Box& box, Vec3 d, double reach, F fn) {
  int most[3];
  for (int k = 0; k < 3; ++k)
    most[k] = box.periodic[static_cast<std::size_t>(k)] ? static_cast<int>(reach / box.size[k] + 0.5) : 0;
  for (int z = -most[2]; z <= most[2]; ++z)
    for (int y = -most[1]; y <= most[1]; ++y)
      for (int x = -most[0]; x <= most[0]; ++x) {
        const double at = norm(d + Vec3{x * box.size.x, y * box.size.y, z * box.size.z});
        if (at < reach) fn(at, x == 0 && y == 0 && z == 0);
      }
}

}  // namespace

/// Largest distance of centres at which grains of radii r and q exchange something [m]. Gas of both layers: up to a gap
/// of twice a layer, whose thickness is a share of the harmonic mean 2 R*.
double HeatNeighbours::reach(double r, double q) const {
  const double film = s_.scene.gap.conductivity > 0 ? 4 * s_.scene.gap.layer * heat::reduced(r, q) : 0;
  const double sight = s_.scene.radiation.grains ? s_.scene.radiation.range * (0.5 * (r + q)) : 0;
  return (r + q) + fmax2(film, sight);
}

/// Now: grains may have grown beyond those that the scene begins with.
double HeatNeighbours::largest_radius() const {
  double r = w_.rules.r_max;
  if (w_.rows.resized)
    for (Row i = 0; i < w_.rows.n; ++i)
      if (w_.rows.is_alive(i)) r = fmax2(r, w_.rows.p[4L * i + 3]);
  return r;
}

/// A grain sees its own images, which stand before what is behind them.
bool HeatNeighbours::meets_itself(double r) const {
  if (!s_.scene.radiation.grains) return false;
  for (int k = 0; k < 3; ++k)
    if (box_.periodic[static_cast<std::size_t>(k)] && box_.size[k] < reach(r, r)) return true;
  return false;
}

void HeatNeighbours::find(int blocks) {
  if (!reaches() && !w_.rules.has.fixed) return;
  const double r = largest_radius();
  const NearGrid grid(w_.rules, w_.rows, reach(r, r), !reaches());
  near_.resize(static_cast<std::size_t>(blocks));
  if (reaches()) shade_.assign(static_cast<std::size_t>(w_.rows.n), 1.0);
  entry_ = heat_wall_entries(s_, w_.walls);
  w_.blocks(blocks, [&](int b) { find(grid, b); });
}

void HeatNeighbours::find(const NearGrid& grid, int block) {
  NearRows& near = near_[static_cast<std::size_t>(block)];
  std::vector<Row> partners;
  std::vector<std::int32_t> elements;
  near.first.reserve(k_heat_rows + 1);
  near.first_wall.reserve(k_heat_rows + 1);
  for (Row i = block * k_heat_rows; i < std::min<Row>(w_.rows.n, (block + 1) * k_heat_rows); ++i) {
    if (!w_.rows.is_alive(i)) continue;
    near.first.push_back(static_cast<std::int32_t>(near.all.size()));
    near.first_wall.push_back(static_cast<std::int32_t>(near.walls.size()));
    partners.clear();
    if (reaches() || fixed(i)) grid.partners(w_.rows, i, partners);
    if (meets_itself(w_.rows.p[4L * i + 3])) partners.insert(std::lower_bound(partners.begin(), partners.end(), i), i);
    double seen = reaches() ? find_walls(i, near.walls, elements) : 0.0;
    seen = seen + find_grains(i, partners, near.all);
    // more than the whole surface cannot be seen: those behind stand in the shade of those before
    if (const double all = s_.surface(w_, i); seen > all) shade_[static_cast<std::size_t>(i)] = all / seen;
  }
  near.first.push_back(static_cast<std::int32_t>(near.all.size()));
  near.first_wall.push_back(static_cast<std::int32_t>(near.walls.size()));
}

/// Returns the area of row i that they are seen from.
double HeatNeighbours::find_grains(Row i, const std::vector<Row>& partners, std::vector<Near>& found) const {
  const double* a = w_.rows.p.data() + 4L * i;
  double seen = 0;
  for (const Row j : partners) {
    const double* o = w_.rows.p.data() + 4L * j;
    const Vec3 d = box_.nearest({a[0] - o[0], a[1] - o[1], a[2] - o[2]});
    for_images(box_, d, reach(a[3], o[3]), [&](double at, bool nearest) {
      if (i != j || !nearest) seen = seen + add_grain(i, j, at, nearest, found);
    });
  }
  return seen;
}

double HeatNeighbours::add_grain(Row i, Row j, double distance, bool nearest, std::vector<Near>& found) const {
  const double r = w_.rows.p[4L * i + 3], q = w_.rows.p[4L * j + 3], gap = distance - (r + q);
  const GapHeat& gas = s_.scene.gap;
  Near n{j, 0, 0};
  const double contact = nearest && fixed(i) && fixed(j) ? conductance_between(s_, w_, i, j, (r + q) - distance) : 0.0;
  if (gas.conductivity > 0)
    n.gap = heat::gap_conductance(gas.conductivity, 2 * heat::reduced(r, q), gap, gas.layer, gas.least_gap);
  if (s_.scene.radiation.grains && distance < (r + q) + s_.scene.radiation.range * (0.5 * (r + q)))
    n.area = heat::exchange_area(r, q, distance);
  n.gap = n.gap + contact;
  if (n.gap > 0 || n.area > 0) found.push_back(n);
  return n.area;
}

/// Walls of given temperature near row i. Returns the area of the grain that they are seen from.
double HeatNeighbours::find_walls(Row i, std::vector<NearWall>& found, std::vector<std::int32_t>& elements) const {
  if (s_.scene.walls.empty()) return 0;
  const double* a = w_.rows.p.data() + 4L * i;
  const GapHeat& gap = s_.scene.gap;
  const double reach = heat_reach(s_.scene, a[3]);
  elements.clear();
  w_.walls.candidates({a[0], a[1], a[2]}, reach, elements);
  WallContact contact[WallSet::k_max_contacts];
  const int n = elements.empty() ? 0 : w_.walls.contacts({a[0], a[1], a[2]}, reach, elements, contact);
  double seen = 0;
  for (int k = 0; k < n; ++k) {
    const int e = entry_[static_cast<std::size_t>(contact[k].wall)];
    if (e < 0 || !s_.scene.walls[static_cast<std::size_t>(e)].temperature.given()) continue;
    const WallHeat& wall = s_.scene.walls[static_cast<std::size_t>(e)];
    NearWall w{e, 0, 0, s_.matter[static_cast<std::size_t>(w_.walls.material(contact[k].wall))].emissivity};
    if (gap.conductivity > 0)
      w.gap =
          heat::gap_conductance_to_plane(gap.conductivity, a[3], contact[k].distance - a[3], gap.layer, gap.least_gap);
    if (s_.scene.radiation.grains)
      w.area = 4 * det::k_pi * (a[3] * a[3]) * heat::share_of_plane(contact[k].distance, reach);
    if (!wall.layer.empty()) {
      w.layer = layer_conductance(wall, a[3]);
      w.touch = touch_of_wall(s_, w_, wall, i, contact[k]);
    }
    seen = seen + w.area;
    found.push_back(w);
  }
  return seen;
}

}  // namespace talus
