// See heat_near.hpp.
#include "scheduler/parts/heat_near.hpp"

#include <algorithm>

namespace talus {

std::array<int, 3> NearGrid::cell_of(const double* x) const {
  std::array<int, 3> c{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double at = x[k] / edge_[k];
    c[k] = !(at >= 1) ? 0 : (at >= n_[k] ? n_[k] - 1 : static_cast<int>(at));
  }
  return c;
}

NearGrid::NearGrid(const Rules& rules, const Rows& rows, double reach, bool fixed_alone) {
  const double wanted = std::max(reach, 1e-300), room = 4.0 * (static_cast<double>(rows.n) + 64);
  double edge = wanted;
  const auto cells = [&](double e, int k) { return std::max(1.0, __builtin_floor(rules.size[k] / e)); };
  while (cells(edge, 0) * cells(edge, 1) * cells(edge, 2) > room) edge = 1.26 * edge;
  for (int k = 0; k < 3; ++k) {
    periodic_[k] = rules.scene.domain.periodic(k);
    n_[k] = static_cast<int>(cells(edge, k));
    edge_[k] = rules.size[k] / n_[k];
  }
  first_.assign(static_cast<std::size_t>(n_[0]) * static_cast<std::size_t>(n_[1]) * static_cast<std::size_t>(n_[2]) + 1,
                0);
  std::vector<std::int32_t> of(static_cast<std::size_t>(rows.n), -1);
  for (Row i = 0; i < rows.n; ++i) {
    if (!rows.is_alive(i) || (fixed_alone && rows.fixed[i] == 0)) continue;
    const auto c = cell_of(rows.p.data() + 4L * i);
    of[static_cast<std::size_t>(i)] = index(c[0], c[1], c[2]);
    ++first_[static_cast<std::size_t>(of[static_cast<std::size_t>(i)]) + 1];
  }
  for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
  rows_.resize(static_cast<std::size_t>(first_.back()));
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (Row i = 0; i < rows.n; ++i)
    if (const std::int32_t c = of[static_cast<std::size_t>(i)]; c >= 0)
      rows_[static_cast<std::size_t>(next[static_cast<std::size_t>(c)]++)] = i;
}

void NearGrid::partners(const Rows& rows, Row i, std::vector<Row>& out) const {
  out.clear();
  const auto c = cell_of(rows.p.data() + 4L * i);
  int around[3][3], count[3] = {0, 0, 0};
  for (std::size_t k = 0; k < 3; ++k)
    for (int o = -1; o <= 1; ++o) {
      int at = c[k] + o;
      if (periodic_[k]) at = (at + n_[k]) % n_[k];
      if (at < 0 || at >= n_[k]) continue;
      if (std::find(around[k], around[k] + count[k], at) == around[k] + count[k]) around[k][count[k]++] = at;
    }
  for (int z = 0; z < count[2]; ++z)
    for (int y = 0; y < count[1]; ++y)
      for (int x = 0; x < count[0]; ++x) {
        const auto at = static_cast<std::size_t>(index(around[0][x], around[1][y], around[2][z]));
        for (std::int32_t k = first_[at]; k < first_[at + 1]; ++k)
          if (rows_[static_cast<std::size_t>(k)] != i) out.push_back(rows_[static_cast<std::size_t>(k)]);
      }
  std::sort(out.begin(), out.end());
}

}  // namespace talus
