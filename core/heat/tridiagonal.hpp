// Solution of a tridiagonal system without pivoting (Thomas). Who calls it: the grain solvers, whose matrices are
// diagonally dominant by columns. Invariant: fixed order of operations; no branch on a value.
#pragma once

#include <vector>

namespace talus::heat {

/// lower[i] x[i-1] + diagonal[i] x[i] + upper[i] x[i+1] = right[i]; on return `right` holds x. diagonal is overwritten.
template <class V>
void solve_tridiagonal(const std::vector<V>& lower, std::vector<V>& diagonal, const std::vector<V>& upper,
                       std::vector<V>& right) {
  const std::size_t n = right.size();
  for (std::size_t i = 1; i < n; ++i) {
    const V w = lower[i] / diagonal[i - 1];
    diagonal[i] = diagonal[i] - w * upper[i - 1];
    right[i] = right[i] - w * right[i - 1];
  }
  right[n - 1] = right[n - 1] / diagonal[n - 1];
  for (std::size_t i = n - 1; i > 0; --i) right[i - 1] = (right[i - 1] - upper[i - 1] * right[i]) / diagonal[i - 1];
}

}  // namespace talus::heat
