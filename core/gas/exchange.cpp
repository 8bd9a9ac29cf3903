// See exchange.hpp.
#include "core/gas/exchange.hpp"

#include <algorithm>

#include "core/base/det_math.hpp"
#include "core/gas/overlap.hpp"

namespace talus::gas {

void FromGrains::clear(int cells) {
  const auto n = static_cast<std::size_t>(cells);
  solid.assign(n, 0);
  specific.assign(n, 0);
  drag_factor.assign(n, 1);
  moment.assign(n, Vec3{});
  conductance.assign(n, 0);
  heat.assign(n, 0);
  source.assign(n, GasFractions{});
  enthalpy.assign(n, 0);
}

void ToGrains::resize(int cells) {
  const auto n = static_cast<std::size_t>(cells);
  for (auto* v : {&porosity, &diameter, &drag, &pressure, &temperature, &density, &viscosity, &conductivity, &prandtl,
                  &exchange_temperature})
    v->assign(n, 0);
  for (auto* v : {&velocity, &gradient}) v->assign(n, Vec3{});
  for (auto* v : {&fractions, &taken}) v->assign(n, GasFractions{});
}

namespace {

constexpr int k_planes = 10;  // a ball of three cells' radius meets eight cells at most

/// Planes between cells on one axis, from the centre in radii; cells first .. first + count - 1, unwrapped.
struct Cuts {
  int first = 0, count = 0;
  double at[k_planes];
};

Cuts cuts_of(double lower, double h, int n, bool periodic, double x, double r) {
  Cuts c;
  const double low = (x - r - lower) / h, high = (x + r - lower) / h;
  std::int64_t from = det::floor_int(low), to = det::floor_int(high);
  if (!periodic) from = std::max<std::int64_t>(from, 0), to = std::min<std::int64_t>(to, n - 1);
  c.first = static_cast<int>(from);
  c.count = static_cast<int>(std::min<std::int64_t>(to - from + 1, k_planes - 1));
  for (int q = 0; q <= std::max(c.count, 0); ++q)
    c.at[q] = fmax2(-1, fmin2(1, (lower + static_cast<double>(c.first + q) * h - x) / r));
  return c;
}

}  // namespace

void share(const Grid& g, Vec3 x, double r, std::vector<std::pair<int, double>>& parts) {
  share(g, x, {r, r, r}, parts);
}

void share(const Grid& g, Vec3 x, Vec3 reach, std::vector<std::pair<int, double>>& parts) {
  parts.clear();
  Cuts c[3];
  for (int k = 0; k < 3; ++k) {
    const auto q = static_cast<std::size_t>(k);
    c[k] = cuts_of(g.lower[k], g.h[k], g.n[q], g.periodic[q], x[k], reach[k]);
    if (c[k].count < 1) return;
  }
  const auto wrapped = [&](int k, int place) {
    const int n = g.n[static_cast<std::size_t>(k)];
    return ((place % n) + n) % n;
  };
  const auto is_whole = [](const Cuts& q) { return q.at[0] <= -1 && q.at[1] >= 1; };
  if (c[0].count == 1 && c[1].count == 1 && c[2].count == 1 && is_whole(c[0]) && is_whole(c[1]) && is_whole(c[2])) {
    parts.emplace_back(g.index(wrapped(0, c[0].first), wrapped(1, c[1].first), wrapped(2, c[2].first)),
                       4 * det::k_pi / 3 * (reach.x * reach.y * reach.z));
    return;
  }
  double beyond[2][k_planes][k_planes];  // of two planes on the third axis
  const auto fill = [&](int k) {
    for (int j = 0; j <= c[1].count; ++j)
      for (int i = 0; i <= c[0].count; ++i) beyond[k % 2][j][i] = ball_beyond(c[0].at[i], c[1].at[j], c[2].at[k]);
  };
  fill(0);
  for (int k = 0; k < c[2].count; ++k) {
    fill(k + 1);
    const auto &low = beyond[k % 2], &high = beyond[(k + 1) % 2];
    for (int j = 0; j < c[1].count; ++j)
      for (int i = 0; i < c[0].count; ++i) {
        const double v = ((low[j][i] - low[j][i + 1]) - (low[j + 1][i] - low[j + 1][i + 1])) -
                         ((high[j][i] - high[j][i + 1]) - (high[j + 1][i] - high[j + 1][i + 1]));
        if (v > 0)
          parts.emplace_back(
              g.index(wrapped(0, c[0].first + i), wrapped(1, c[1].first + j), wrapped(2, c[2].first + k)),
              v * (reach.x * reach.y * reach.z));
      }
  }
}

}  // namespace talus::gas
