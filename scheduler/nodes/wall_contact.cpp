// See wall_contact.hpp. A wall is a partner of radius 0 and infinite mass at rest in its own spin: the same laws apply.
// Invariants: I3 (after all pairs, in the order of walls and elements), I5.
#include "scheduler/nodes/wall_contact.hpp"

#include <algorithm>
#include <utility>

#include "core/shapes/body_walls.hpp"
#include "scheduler/lists/skin_check.hpp"
#include "scheduler/nodes/add_ons.hpp"
#include "scheduler/nodes/surface.hpp"

namespace talus {

namespace {

/// What all rows of a chunk have in common.
struct WallPass {
  const Rules& rules;
  const Rows& rows;
  const WallSet& walls;
  const double* listed_at;  ///< rows of the positions that the candidates were listed at
  double wall_travel;
};

/// Candidates of row number q that its way and that of the walls since the rebuild may have brought within its radius:
/// into scratch.wall_near. Most have none.
std::size_t near_candidates(const WallPass& pass, Chunk& c, std::size_t q, double radius) {
  const WallContacts& t = c.wall;
  Scratch& s = *c.scratch;
  const Row i = t.row[q];
  const std::size_t first = t.begin[q], count = t.begin[q + 1] - first;
  if (s.wall_near.size() < count) s.wall_near.resize(2 * count);
  const double way2 = distance2(pass.rules, pass.rows.p.data() + 4L * i, pass.listed_at + 4L * i);
  const double gap = static_cast<double>(t.nearest[q]) - (radius + pass.wall_travel) * (1 + 1e-6);
  if (gap > 0 && gap * gap > way2 * (1 + 3e-6)) return 0;
  const double way = __builtin_sqrt(way2) + pass.wall_travel;
  const auto limit = static_cast<float>((radius + way) * (1 + 1e-6));
  std::size_t near = 0;
  for (std::size_t k = first; k < first + count; ++k) {
    s.wall_near[near] = t.element[k];
    near += t.distance[k] <= limit ? 1 : 0;
  }
  return near;
}

/// Contacts of one row, now and before; arms of superquadrics. Made once per chunk: its initial values would cost more
/// than a row's contacts.
struct RowContacts {
  WallContact found[WallSet::k_max_contacts], before[WallSet::k_max_contacts];
  std::int32_t from[WallSet::k_max_contacts];
  std::vector<shapes::BodyWallContact> shaped;
};

/// Contacts of a superquadric into `found` and row.shaped.
int find_shaped(const WallPass& pass, Row i, std::span<const std::int32_t> near, const WallSet::Wraps& wraps,
                RowContacts& row) {
  const double* p = pass.rows.p.data() + 4L * i;
  const shapes::Body body = surface_of(pass.rules, pass.rows, i).body({p[0], p[1], p[2]});
  shapes::body_wall_contacts(body, p[3], pass.walls, near, wraps, row.shaped);
  int n = 0;
  for (const shapes::BodyWallContact& c : row.shaped) row.found[n++] = c.contact;
  return n;
}

/// Appends the contacts of row number q with the history that they had. `old`: first old contact that is not of an
/// earlier row.
void find_row(const WallPass& pass, Chunk& c, std::size_t q, std::size_t& old, RowContacts& row) {
  WallContacts& t = c.wall;
  const Features& h = pass.rules.has;
  const Row i = t.row[q];
  const double* x = pass.rows.p.data() + 4L * i;
  if (!(x[0] < k_far)) return;
  const double radius = h.adhesion ? t.radius[q] : x[3];
  const std::size_t near = near_candidates(pass, c, q, radius);
  if (near == 0) return;
  auto& [found, before, from, arms] = row;
  const WallSet::Wraps wraps =
      pass.walls.has_images() ? wraps_of(pass.rules, x, pass.listed_at + 4L * i) : WallSet::Wraps{};
  const std::span<const std::int32_t> candidates(c.scratch->wall_near.data(), near);
  const bool shaped = h.superquadrics && superquadric_of(pass.rules, pass.rows, i) != nullptr;
  int n = shaped ? find_shaped(pass, i, candidates, wraps, row)
                 : pass.walls.contacts({x[0], x[1], x[2]}, radius, candidates, found, wraps);
  if (n == 0) return;
  while (old < t.state.size() && t.state[old].row < i) ++old;
  int nb = 0;
  for (std::size_t end = old; end < t.state.size() && t.state[end].row == i && nb < WallSet::k_max_contacts; ++end)
    before[nb++] = t.state[end].contact;
  for (int k = 0; k < nb && shaped; ++k) before[k].element = -1;  // it may meet one element twice: by the normals
  pass.walls.match(std::span(before, static_cast<std::size_t>(nb)), std::span(found, static_cast<std::size_t>(n)),
                   from);
  if (h.adhesion) n = keep_wall_contacts(pass.rules, pass.rows, pass.walls, i, found, from, n);
  const auto columns = static_cast<std::size_t>(h.moment_columns);
  for (int k = 0; k < n; ++k) {
    WallState s;
    s.row = i;
    s.contact = found[k];
    if (from[k] >= 0)
      for (int q = 0; q < h.law_columns; ++q) s.h[q] = t.state[old + from[k]].h[q];
    t.next.push_back(s);
    if (h.superquadrics) t.arm.push_back(shaped ? arms[static_cast<std::size_t>(k)].arm : Vec3{});
    for (std::size_t m = 0; m < columns; ++m)
      t.moment_next.push_back(from[k] >= 0 ? t.moment[(old + from[k]) * columns + m] : 0.0);
  }
}

/// L1 buffers of one block of wall contacts.
struct WallBlock {
  alignas(64) double x[k_block + k_pad], y[k_block + k_pad], z[k_block + k_pad], w[k_block + k_pad];
  alignas(64) double r[8][k_block + k_pad], e[3][k_block + k_pad], h[k_max_history][k_block + k_pad],
      g[4][k_block + k_pad], reff[k_block + k_pad], slid[k_block + k_pad];
  alignas(64) std::int32_t pair[k_block + k_pad];
};

/// Geometry and motion of a superquadric's contact, as ShapedContacts gives them of pairs; after the geometry of
/// spheres.
void load_shaped(const WallPass& pass, Chunk& c, std::size_t at, int k, double deep, const Surface& s, WallBlock& to) {
  const WallState& t = c.wall.next[at];
  const Vec3 n = t.contact.normal, arm = c.wall.arm[at], v = (s.v + cross(s.w, arm)) - t.contact.velocity;
  const double overlap = pass.rows.p[4L * t.row + 3] - t.contact.distance;
  if (overlap > (1 - deep) * s.inner) c.result.deep_wall = static_cast<std::int64_t>(at);
  const double answer = answer_of(s, arm, n), ms = answer > 0 ? answer : 1.0;
  const double g[4] = {0, k_far_inverse, 1 / ms, 0};
  for (int q = 0; q < 4; ++q) to.g[q][k] = g[q];
  to.x[k] = k_far_away * n.x, to.y[k] = k_far_away * n.y, to.z[k] = k_far_away * n.z;
  to.w[k] = overlap;
  to.r[7][k] = ms;
  for (int q = 0; q < 3; ++q) to.r[q][k] = v[q], to.r[4 + q][k] = 0;
  if (pass.rules.has.reff) to.reff[k] = hertz_radius_of(s, -n);
}

/// Contacts [k0, k0 + n) of wall.next. `deep`: a distance below deep radii is recorded.
Block load(const WallPass& pass, Chunk& c, std::size_t k0, int n, double deep, WallBlock& to) {
  const Features& h = pass.rules.has;
  const int padded = (n + 7) / 8 * 8, mass_lane = h.rotation ? 7 : 3;
  for (int k = 0; k < padded; ++k) {
    const WallState& t = c.wall.next[k0 + static_cast<std::size_t>(std::min(k, n - 1))];
    const double* v = pass.rows.v.data() + static_cast<long>(pass.rows.stride) * t.row;
    to.x[k] = t.contact.normal.x * t.contact.distance;
    to.y[k] = t.contact.normal.y * t.contact.distance;
    to.z[k] = t.contact.normal.z * t.contact.distance;
    to.w[k] = to.reff[k] = pass.rows.p[4L * t.row + 3];
    const bool shaped = h.superquadrics && superquadric_of(pass.rules, pass.rows, t.row) != nullptr;
    if (!shaped && t.contact.distance < deep * to.w[k])
      c.result.deep_wall = static_cast<std::int64_t>(k0) + (k < n ? k : n - 1);
    to.r[0][k] = v[0] - t.contact.velocity.x;
    to.r[1][k] = v[1] - t.contact.velocity.y;
    to.r[2][k] = v[2] - t.contact.velocity.z;
    if (h.rotation)
      for (int q = 4; q < 7; ++q) to.r[q][k] = v[q];
    to.r[mass_lane][k] = v[mass_lane] > 0 ? v[mass_lane] : 1.0;  // a fixed grain feels nothing anyway
    for (int q = 0; q < h.law_columns; ++q) to.h[q][k] = t.h[q];
    if (h.materials) to.pair[k] = pass.rules.pair_index(pass.rows.material[t.row], pass.walls.material(t.contact.wall));
  }
  Block b{};
  b.n = n;
  b.x = to.x;
  b.y = to.y;
  b.z = to.z;
  b.w = to.w;
  b.g = to.g;
  b.r = to.r;
  pass.rules.kernels->geometry(GeometryArgs{n, to.x, to.y, to.z, to.w, to.r[mass_lane], to.g});
  for (int k = 0; k < padded && h.superquadrics; ++k) {
    const std::size_t at = k0 + static_cast<std::size_t>(std::min(k, n - 1));
    const Row i = c.wall.next[at].row;
    if (superquadric_of(pass.rules, pass.rows, i) != nullptr)
      load_shaped(pass, c, at, k, deep, surface_of(pass.rules, pass.rows, i), to);
  }
  for (int q = 0; q < h.law_columns; ++q) b.h_in[q] = b.h[q] = to.h[q];
  b.reff = to.reff;
  b.pair = to.pair;
  b.e = to.e;
  b.slid = pass.rules.has.moments ? to.slid : nullptr;
  return b;
}

/// Adds force and torque of a superquadric's contact to its row f.
void store_shaped(const WallPass& pass, Chunk& c, std::size_t at, double stiffness, double press, double* f) {
  const WallState& t = c.wall.next[at];
  const Vec3 force = c.wall.force[at], arm = c.wall.arm[at];
  const Surface s = surface_of(pass.rules, pass.rows, t.row);
  const Vec3 turn = (1 / pass.rows.p[4L * t.row + 3]) * cross(arm, force);
  for (int q = 0; q < 3; ++q) f[q] = f[q] + force[q], f[4 + q] = f[4 + q] + turn[q];
  f[3] = f[3] + weight_of(s, answer_of(s, arm, t.contact.normal)) * stiffness;
  f[7] = f[7] + press;
  c.wall.point[at] = position_of(pass.rules, pass.rows, t.row) + arm;
}

/// What the law has made of them: history, force rows, forces of the walls, energies.
void store(const WallPass& pass, Column<double>& energy, Chunk& c, std::size_t k0, int n, const WallBlock& from) {
  const Features& has = pass.rules.has;
  const int stride = pass.rows.stride;
  for (int k = 0; k < n; ++k) {
    const std::size_t at = k0 + static_cast<std::size_t>(k);
    WallState& t = c.wall.next[at];
    for (int q = 0; q < has.law_columns; ++q) t.h[q] = from.h[q][k];
    double* f = c.scratch->f.data() + static_cast<std::ptrdiff_t>(stride) * (t.row - c.lo);
    const Vec3 force{from.r[0][k], from.r[1][k], from.r[2][k]};
    c.wall.force[at] = force;
    c.wall.point[at] = position_of(pass.rules, pass.rows, t.row) - t.contact.distance * t.contact.normal;
    if (has.superquadrics && superquadric_of(pass.rules, pass.rows, t.row) != nullptr)
      store_shaped(pass, c, at, from.r[3][k], from.r[7][k], f);
    else
      for (int q = 0; q < stride; ++q) f[q] = f[q] + from.r[q][k];
    if (!has.energies) continue;
    double* en = energy.data() + 4L * t.row;
    for (int q = 0; q < 3; ++q) en[q] = en[q] + from.e[q][k];
    double power = dot(force, t.contact.velocity);
    if (has.moments) power += dot(c.wall.torque[at], pass.walls.pose(t.contact.wall).omega);
    c.wall.power[at] = pass.rules.scene.dt * power;
  }
}

}  // namespace

void wall_chunk(const Rules& rules, const Clock& clock, const Rows& rows, const Lists& lists, const WallSet& walls,
                Column<double>& energy, Chunk& c) {
  WallContacts& t = c.wall;
  const WallPass pass{rules, rows, walls, (lists.skin.cuts() ? lists.outer : lists.x0).data(), walls.largest_travel()};
  t.next.clear();
  t.moment_next.clear();
  t.arm.clear();
  std::size_t old = 0;
  RowContacts row;
  for (std::size_t q = 0; q + 1 < t.begin.size(); ++q) find_row(pass, c, q, old, row);
  t.force.resize(t.next.size());
  t.point.resize(t.next.size());
  if (rules.has.moments) t.torque.resize(t.next.size());
  if (rules.has.energies) t.power.resize(t.next.size());
  // where the centre of a grain gets this close to a wall it is about to come out on the other side
  const double deep = clock.step < rules.scene.relax.steps ? -1.0 : 1.0 - rules.scene.max_overlap;
  c.result.deep_wall = -1;
  LawArgs args = rules.law_args(clock.step);
  if (!rules.has.materials) args.one = rules.law.parameters[0];
  // The mid-step normal of the synchronised form is that of two spheres, which turns with their chord. A wall's contact
  // point follows the grain: the normal at n holds at n-1/2 too (exactly on a plane), and tilting it back by half the
  // chord would press a sliding grain into the wall.
  args.synchronised = 0;
  WallBlock buffers;
  for (std::size_t k0 = 0; k0 < t.next.size(); k0 += k_block) {
    const int n = static_cast<int>(std::min<std::size_t>(k_block, t.next.size() - k0));
    Block b = load(pass, c, k0, n, deep, buffers);
    rules.kernels->law[rules.law.variant](b, args);
    if (rules.has.moments || rules.has.cohesion) wall_add_ons(rules, clock, rows, walls, c, k0, b);
    store(pass, energy, c, k0, n, buffers);
  }
  std::swap(t.state, t.next);
  std::swap(t.moment, t.moment_next);
}

}  // namespace talus
