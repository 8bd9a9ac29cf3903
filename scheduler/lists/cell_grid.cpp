// Skins, reference positions and the hierarchical cell grid of a rebuild. Who calls it: rebuild_lists().
// Invariants: I1 (a particle's cell level covers its reach), I2 (the skin that the check uses is the one stored here).
// All loops run over chunks or blocks in parallel. The order of particles within a cell may depend on the threads:
// the search sorts what it finds, so no list does.
#include <algorithm>
#include <atomic>
#include <cstring>

#include "core/base/count.hpp"
#include "scheduler/lists/rebuild.hpp"
#include "scheduler/state/step_failure.hpp"
#include "scheduler/team/parallel.hpp"

namespace talus {

namespace {

/// What one chunk finds out about its rows.
struct alignas(64) ChunkReach {
  double top[k_max_levels] = {};
  std::int32_t count[k_max_levels] = {};
  double skins = 0;  ///< sum of skin / diameter
  Row bad = -1;
};

/// Upper reach of each level; rows above the last limit live in the last level.
struct LevelLimits {
  int levels = 1;
  float limit[k_max_levels] = {};

  /// `far` [m], if any: rows of a larger reach get a level of their own.
  LevelLimits(double r_min, double r_max, double far) {
    if (r_max > k_level_from * r_min && r_min > 0) {
      double edge = k_level_ratio * r_min;
      for (; levels < k_max_levels - 1 && edge < r_max; ++levels, edge *= k_level_ratio)
        limit[levels - 1] = static_cast<float>(edge);
    }
    if (far > 0) limit[levels++ - 1] = static_cast<float>(far);
  }
  int operator()(float reach) const {
    int l = 0;
    while (l + 1 < levels && reach > limit[l]) ++l;
    return l;
  }

  /// One grid up to this ratio of radii, levels of k_level_ratio beyond. Radii 1:5 uniform: 134 ns per particle and
  /// rebuild with one grid, 158 with levels; one grain of 1:20 per 10^4: 8180 with one grid, 200 with levels.
  static constexpr double k_level_from = 6, k_level_ratio = 3;
};

/// Skins of a chunk's rows: writes x0 and reach.
void set_skins(const Rules& rules, const Rows& rows, Lists& lists, const Chunk& c, const LevelLimits& limits,
               double slack, ChunkReach& out) {
  const SkinRule rule = lists.skin;
  const double stretch = (rules.hooks.stretch ? lists.frame.stretch : 1.0) * 1.000002;
  RowSkins skins(rules, rows, lists, c);
  for (Row i = c.lo; i < c.hi; ++i) {
    const double* x = rows.p.data() + 4L * i;
    if (!(x[0] < k_far)) {
      if (!(x[0] >= k_far)) out.bad = i;
      continue;
    }
    const double skin = skins(i);
    if (skin < 0) {
      out.bad = i;
      continue;
    }
    out.skins += skin / (2 * x[3]);
    set_reference(rules, rows, lists, i, skin);
    double listed = skin;
    if (rule.cuts()) {
      set_near(rules, rows, lists, i, skin);
      listed = rule.outer_skin(x[3], skin);
      double* outer = lists.outer.data() + 4L * i;
      for (int k = 0; k < 3; ++k) outer[k] = x[k];
      outer[3] = listed;
    }
    // the check compares squares: the reach covers the rounding of the square root, and `slack` that of coordinates
    const auto reach = static_cast<float>((x[3] + lists.skin.range(x[3]) + listed) * stretch + slack);
    lists.grid.reach[static_cast<std::size_t>(i)] = reach;
    const int l = limits(reach);
    out.top[l] = fmax2(out.top[l], reach);
    ++out.count[l];
  }
}

/// Cell edges in sums of two largest reaches. The search covers any edge; thick pencils fill its lanes best: dense bed
/// 99 ns per particle and rebuild with 1 x 2, 105 with 1 x 1.5, 111 with cubes of edge 1; dilute gas 81, 66, 90.
constexpr double k_edge[3] = {1, 1.75, 1.75};

/// Lays the cells of one level over the domain.
GridLevel lay_level(const Rules& rules, double top, std::int64_t particles) {
  GridLevel g{};
  g.top = top;
  const double limit = 2.0 * static_cast<double>(particles) + 64;
  for (double scale = 1;; scale *= 1.26) {  // sparse scenes: coarser cells rather than more cells than particles
    double total = 1;
    for (int k = 0; k < 3; ++k) {
      const double c = rules.size[k] / (2 * top * k_edge[k] * scale);
      g.n[k] = static_cast<std::int32_t>(count_floor(c, 1, 1000000));
      g.inverse[k] = g.n[k] / rules.size[k];
      total *= g.n[k];
    }
    if (total <= limit || (g.n[0] == 1 && g.n[1] == 1 && g.n[2] == 1)) return g;
  }
}

std::int32_t cell_of(const GridLevel& g, const double* x) {
  return g.first_cell +
         (cell_index(x[2] * g.inverse[2], g.n[2]) * g.n[1] + cell_index(x[1] * g.inverse[1], g.n[1])) * g.n[0] +
         cell_index(x[0] * g.inverse[0], g.n[0]);
}

/// Turns counts into first positions; start[cells] becomes the total.
void scan_cells(CellGrid& grid, Team& team, std::int32_t cells) {
  const int blocks = std::max(1, std::min(team.threads, cells / 65536 + 1));
  std::vector<std::int32_t> first(static_cast<std::size_t>(blocks) + 1, 0);
  std::int32_t* start = grid.cell_start.data();
  const auto from = [&](int b) { return static_cast<std::int32_t>(static_cast<std::int64_t>(cells) * b / blocks); };
  if (blocks > 1) {
    parallel(team, blocks, [&](int b) {
      std::int32_t sum = 0;
      for (std::int32_t c = from(b); c < from(b + 1); ++c) sum += start[c];
      first[static_cast<std::size_t>(b) + 1] = sum;
    });
    for (std::size_t b = 0; b < static_cast<std::size_t>(blocks); ++b) first[b + 1] += first[b];
  }
  parallel(team, blocks, [&](int b) {
    std::int32_t sum = first[static_cast<std::size_t>(b)];
    for (std::int32_t c = from(b); c < from(b + 1); ++c) {
      const std::int32_t count = start[c];
      start[c] = sum;
      sum += count;
    }
    if (b == blocks - 1) start[cells] = sum;
  });
}

/// Skins and reference positions of all rows; a non-finite coordinate ends the run here at the latest (I9).
ChunkReach set_all_skins(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists,
                         const WallSet& walls, const LevelLimits& limits, double slack, Team& team) {
  std::vector<ChunkReach> found(contacts.chunks.size());
  parallel(team, contacts.count(), [&](int q) {
    set_skins(rules, rows, lists, contacts[q], limits, slack, found[static_cast<std::size_t>(q)]);
  });
  ChunkReach all;
  for (const ChunkReach& f : found) {
    for (int l = 0; l < limits.levels; ++l) {
      all.top[l] = fmax2(all.top[l], f.top[l]);
      all.count[l] += f.count[l];
    }
    all.skins += f.skins;
    if (f.bad >= 0) fail_non_finite(rows, contacts, walls, f.bad);
  }
  lists.frame.mean_skin = rows.alive > 0 ? all.skins / static_cast<double>(rows.alive) : 0;
  return all;
}

/// Which level of the grid each level of limits is, and the number of all cells.
struct Levels {
  int at[k_max_levels] = {};
  std::int32_t cells = 0;
};

/// Cells of the levels that hold particles, one after another; their counters are zero.
Levels lay_levels(const Rules& rules, const LevelLimits& limits, const ChunkReach& all, CellGrid& grid, Team& team) {
  Levels levels;
  grid.levels = 0;
  for (int l = 0; l < limits.levels; ++l) {
    levels.at[l] = grid.levels;
    if (all.count[l] == 0) continue;
    GridLevel& g = grid.level[grid.levels++];
    g = lay_level(rules, all.top[l], all.count[l]);
    g.first_cell = levels.cells;
    levels.cells += g.n[0] * g.n[1] * g.n[2];
  }
  grow_discarding(grid.cell_start, static_cast<std::size_t>(levels.cells) + 1);
  std::int32_t* count = grid.cell_start.data();
  const int blocks = std::min(team.threads, levels.cells / 65536 + 1);
  parallel(team, blocks, [&](int b) {
    const std::int64_t from = std::int64_t{levels.cells} * b / blocks,
                       to = std::int64_t{levels.cells} * (b + 1) / blocks;
    std::memset(count + from, 0, static_cast<std::size_t>(to - from) * sizeof(std::int32_t));
  });
  return levels;
}

/// First half of a counting sort: a row's place in its cell is its turn in counting.
void count_rows(const Rows& rows, const Contacts& contacts, const LevelLimits& limits, const Levels& levels,
                CellGrid& grid, Team& team) {
  std::int32_t* count = grid.cell_start.data();
  const bool shared = team.threads > 1 && contacts.count() > 1;
  parallel(team, contacts.count(), [&](int q) {
    const Chunk& c = contacts[q];
    for (Row i = c.lo; i < c.hi; ++i) {
      const double* x = rows.p.data() + 4L * i;
      if (!(x[0] < k_far)) continue;
      const auto k = static_cast<std::size_t>(i);
      const std::int32_t cell = cell_of(grid.level[limits.levels == 1 ? 0 : levels.at[limits(grid.reach[k])]], x);
      grid.cell_of_row[k] = cell;
      grid.place_in_cell[k] =
          shared ? std::atomic_ref<std::int32_t>(count[cell]).fetch_add(1, std::memory_order_relaxed) : count[cell]++;
    }
  });
}

/// Second half: rows in the order of their cells, as the search reads them.
void fill_sorted(const Rows& rows, const Contacts& contacts, CellGrid& grid, Team& team) {
  parallel(team, contacts.count(), [&](int q) {
    const Chunk& c = contacts[q];
    for (Row i = c.lo; i < c.hi; ++i) {
      const double* x = rows.p.data() + 4L * i;
      if (!(x[0] < k_far)) continue;
      const auto row = static_cast<std::size_t>(i);
      const auto k = static_cast<std::size_t>(grid.cell_start[static_cast<std::size_t>(grid.cell_of_row[row])] +
                                              grid.place_in_cell[row]);
      grid.sx[k] = static_cast<float>(x[0]);
      grid.sy[k] = static_cast<float>(x[1]);
      grid.sz[k] = static_cast<float>(x[2]);
      grid.sr[k] = grid.reach[row];
      grid.sorted_row[k] = i;
    }
  });
  for (std::size_t k = static_cast<std::size_t>(rows.alive); k < static_cast<std::size_t>(rows.alive) + k_pad; ++k) {
    grid.sx[k] = grid.sy[k] = grid.sz[k] = grid.sr[k] = 0;
    grid.sorted_row[k] = rows.n;
  }
}

}  // namespace

void fill_cells(const Rules& rules, const Rows& rows, const Contacts& contacts, Lists& lists, const WallSet& walls,
                Team& team) {
  CellGrid& grid = lists.grid;
  const auto room = static_cast<std::size_t>(rows.n) + 2 * k_pad;
  for (auto* c : {&grid.sx, &grid.sy, &grid.sz, &grid.sr, &grid.reach}) grow_discarding(*c, room);
  for (auto* c : {&grid.sorted_row, &grid.cell_of_row, &grid.place_in_cell}) grow_discarding(*c, room);
  PartClock parts(lists.seconds);
  double extent = 0;
  for (int k = 0; k < 3; ++k) extent = fmax2(extent, rules.size[k]);
  // float32 rounding of a coordinate, of a period and of a drift
  const double slack = 8 * 5.97e-8 * extent + lists.frame.rounding;
  const double far =
      lists.skin.cap > 0.5 ? (1.5 * rules.r_max + lists.skin.range(rules.r_max)) * lists.frame.stretch + slack : 0;
  const LevelLimits limits(rules.r_min, rules.r_max, far);
  const ChunkReach all = set_all_skins(rules, rows, contacts, lists, walls, limits, slack, team);
  parts.lap(RebuildPart::skin);
  const Levels levels = lay_levels(rules, limits, all, grid, team);
  count_rows(rows, contacts, limits, levels, grid, team);
  parts.lap(RebuildPart::keys);
  scan_cells(grid, team, levels.cells);
  parts.lap(RebuildPart::sort);
  fill_sorted(rows, contacts, grid, team);
  parts.lap(RebuildPart::fill);
}

}  // namespace talus
