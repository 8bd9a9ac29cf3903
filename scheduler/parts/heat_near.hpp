// Grains that are near each other without touching: a list of their own, made at heat steps. Who uses it: heat_step.
// Invariant: partners of a row come in ascending storage index (I3), whatever the cells.
#pragma once

#include <array>
#include <vector>

#include "scheduler/state/rows.hpp"
#include "scheduler/state/rules.hpp"

namespace talus {

/// Cells of an edge of at least `reach` over the domain; every living row lies in one, or every fixed one.
class NearGrid {
 public:
  NearGrid(const Rules& rules, const Rows& rows, double reach, bool fixed_alone);
  /// Rows of it other than i whose cells meet that of i, ascending.
  void partners(const Rows& rows, Row i, std::vector<Row>& out) const;

 private:
  std::array<int, 3> cell_of(const double* x) const;
  int index(int x, int y, int z) const { return (z * n_[1] + y) * n_[0] + x; }
  int n_[3];
  double edge_[3];
  bool periodic_[3];
  std::vector<std::int32_t> first_;
  std::vector<Row> rows_;
};

}  // namespace talus
