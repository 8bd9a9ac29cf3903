// A real dense bed as the kernels see it: particles in Morton order, cell-sorted float columns, candidate pairs and
// contacts. Who calls it: perf/kernels.cpp. Invariant: made with the engine's own search kernel and cell layout from
// the committed bed (solid fraction 0.6, friction history), so that pair and contact counts per grain are those of a
// run.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/io/particle_file.hpp"
#include "core/types.hpp"
#include "kernels/kernel_table.hpp"

namespace talus::perf {

inline std::uint64_t spread_bits(std::uint64_t x, int gap) {
  std::uint64_t out = 0;
  for (int b = 0; b < 21; ++b) out |= ((x >> b) & 1U) << (b * gap);
  return out;
}

struct Bed {
  static constexpr double skin = 0.02;  // [d], what the local policy gives a bed at rest
  std::int32_t n = 0;
  double size[3] = {0, 0, 0};
  Column<double> p, v, f, x0, p2, v2;  // rows as in scheduler/world.hpp, one dead row at n
  Column<float> sx, sy, sz, sr, reach;
  Column<std::int32_t> row, start, rank, pi, pj, ci, cj, scratch, build[6], out;
  Column<std::uint8_t> mask;
  Column<double> h[2][k_max_history];
  std::int32_t cells[3] = {0, 0, 0};
  std::int64_t candidates = 0, slots = 0, contacts = 0;
  double tested = 0;  // candidate positions that the search compares, per particle

  /// `tiles` copies of the bed per horizontal axis; `fraction` < 1 keeps that share of each horizontal axis instead.
  Bed(const std::string& file, int tiles, double fraction) {
    const Material grain{"grain", 1.909859317102744, 0, 0};
    const ParticleFile bed = read_particle_file(file, std::span(&grain, 1));
    const double lx = 40, ly = 20;
    std::vector<std::array<double, 10>> rows;
    for (int tx = 0; tx < tiles; ++tx)
      for (int ty = 0; ty < tiles; ++ty)
        for (std::size_t k = 0; k < bed.size(); ++k) {
          if (bed.x[k].x >= fraction * lx || bed.x[k].y >= fraction * ly) continue;
          const Vec3 x = bed.x[k] + Vec3{tx * lx, ty * ly, 0.5};
          const double r = bed.r[k];
          rows.push_back(
              {x.x, x.y, x.z, r, bed.v[k].x, bed.v[k].y, bed.v[k].z, r * bed.w[k].x, r * bed.w[k].y, r * bed.w[k].z});
        }
    size[0] = tiles * lx * std::min(1.0, fraction);
    size[1] = tiles * ly * std::min(1.0, fraction);
    size[2] = 46;
    const auto morton = [](const std::array<double, 10>& q) {
      std::uint64_t key = 0;
      for (int a = 0; a < 3; ++a)
        key |= spread_bits(static_cast<std::uint64_t>(q[static_cast<std::size_t>(a)] / 1.3), 3) << a;
      return key;
    };
    std::stable_sort(rows.begin(), rows.end(), [&](const auto& a, const auto& b) { return morton(a) < morton(b); });
    n = static_cast<std::int32_t>(rows.size());
    const auto padded = static_cast<std::size_t>(n) + 1 + k_pad;
    for (auto* c : {&p, &p2, &x0}) c->assign(4 * padded, 0.0);
    for (auto* c : {&v, &v2, &f}) c->assign(8 * padded, 0.0);
    reach.assign(padded, 0.0F);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto& q = rows[i];
      for (std::size_t k = 0; k < 4; ++k) p[4 * i + k] = q[k];
      for (std::size_t k = 0; k < 3; ++k) {
        v[8 * i + k] = q[4 + k];
        v[8 * i + 4 + k] = q[7 + k];
        x0[4 * i + k] = q[k];
      }
      v[8 * i + 7] = 1;
      x0[4 * i + 3] = skin * skin;
      reach[i] = static_cast<float>((q[3] + skin) * 1.00001);
    }
    for (std::size_t k = 0; k < 3; ++k) p[4 * static_cast<std::size_t>(n) + k] = 1e150;
    lay_cells();
    find_pairs();
  }

  SearchArgs search_args() {
    SearchArgs a{};
    a.x = sx.data();
    a.y = sy.data();
    a.z = sz.data();
    a.r = sr.data();
    a.row = row.data();
    a.start = start.data();
    a.rank = rank.data();
    for (int k = 0; k < 3; ++k) {
      a.n[k] = cells[k];
      a.inverse[k] = cells[k] / size[k];
    }
    a.p = p.data();
    a.reach = reach.data();
    a.hi = n;
    a.scratch = scratch.data();
    a.scratch_capacity = static_cast<std::int32_t>(scratch.size()) - k_pad;
    for (int s = 0; s < 3; ++s) {
      a.si[s] = build[2 * s].data();
      a.sj[s] = build[2 * s + 1].data();
      a.capacity[s] = static_cast<std::int64_t>(build[2 * s].size());
    }
    return a;
  }

  NarrowArgs narrow_args(int history) {
    NarrowArgs a{};
    a.p = p.data();
    a.pi = pi.data();
    a.pj = pj.data();
    a.mask = mask.data();
    for (int k = 0; k < 3; ++k) {
      a.end[k] = k == 0 ? 0 : slots;
      a.half[k] = 1e300;
    }
    a.history = history;
    for (int k = 0; k < k_max_history; ++k) {
      a.h_old[k] = h[0][k].data();
      a.h_new[k] = h[1][k].data();
    }
    a.deep = 0.5;
    a.ci = ci.data();
    a.cj = cj.data();
    return a;
  }

 private:
  std::int32_t cell(const double* x, int k) const {
    return std::clamp(static_cast<std::int32_t>(x[k] * (cells[k] / size[k])), 0, cells[k] - 1);
  }

  void lay_cells() {
    const double edge = 2 * (0.5 + skin) * 1.0001;
    for (int k = 0; k < 3; ++k) cells[k] = std::max(1, static_cast<std::int32_t>(size[k] / edge));
    const auto pencils = static_cast<std::size_t>(cells[1]) * static_cast<std::size_t>(cells[2]);
    std::vector<std::pair<std::uint64_t, std::int32_t>> codes;
    for (std::int32_t z = 0; z < cells[2]; ++z)
      for (std::int32_t y = 0; y < cells[1]; ++y)
        codes.emplace_back(spread_bits(static_cast<std::uint64_t>(y), 2) | spread_bits(static_cast<std::uint64_t>(z), 2)
                                                                               << 1,
                           z * cells[1] + y);
    std::sort(codes.begin(), codes.end());
    rank.resize(pencils);
    for (std::size_t q = 0; q < pencils; ++q)
      rank[static_cast<std::size_t>(codes[q].second)] = static_cast<std::int32_t>(q);
    const auto key = [&](std::int32_t i) {
      const double* x = p.data() + 4L * i;
      return rank[static_cast<std::size_t>(cell(x, 2) * cells[1] + cell(x, 1))] * cells[0] + cell(x, 0);
    };
    row.resize(static_cast<std::size_t>(n) + 2 * k_pad);
    start.assign(pencils * static_cast<std::size_t>(cells[0]) + 1, 0);
    for (std::int32_t i = 0; i < n; ++i) ++start[static_cast<std::size_t>(key(i)) + 1];
    for (std::size_t c = 1; c < start.size(); ++c) start[c] += start[c - 1];
    std::vector<std::int32_t> next(start.begin(), start.end());
    for (std::int32_t i = 0; i < n; ++i) row[static_cast<std::size_t>(next[static_cast<std::size_t>(key(i))]++)] = i;
    for (auto* c : {&sx, &sy, &sz, &sr}) c->assign(row.size(), 1e30F);
    for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
      const auto i = static_cast<std::size_t>(row[k]);
      sx[k] = static_cast<float>(p[4 * i]);
      sy[k] = static_cast<float>(p[4 * i + 1]);
      sz[k] = static_cast<float>(p[4 * i + 2]);
      sr[k] = reach[i];
    }
    for (std::int32_t i = 0; i < n; ++i)
      for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy) {
          const double* x = p.data() + 4L * i;
          const std::int32_t cx = cell(x, 0), y = cell(x, 1) + dy, z = cell(x, 2) + dz;
          if (y < 0 || z < 0 || y >= cells[1] || z >= cells[2]) continue;
          const std::int32_t* c =
              start.data() + static_cast<long>(rank[static_cast<std::size_t>(z * cells[1] + y)]) * cells[0];
          tested += c[std::min(cx + 2, cells[0])] - c[std::max(cx - 1, 0)];
        }
    tested /= n;
  }

  void find_pairs() {
    scratch.resize(1024);
    for (int s = 2; s < 4; ++s) build[s].resize(8 * static_cast<std::size_t>(n) + 4096);
    for (int s : {0, 1, 4, 5}) build[s].resize(4096);  // one chunk: no lower and no higher one
    SearchArgs a = search_args();
    select_kernels(Isa::automatic).search(a);
    candidates = a.count[1];
    slots = (candidates + 7) / 8 * 8;
    const auto room = static_cast<std::size_t>(slots) + 2 * k_pad;
    pi.assign(room, n);
    pj.assign(room, n);
    std::copy_n(build[2].begin(), candidates, pi.begin());
    std::copy_n(build[3].begin(), candidates, pj.begin());
    ci.assign(room, n);
    cj.assign(room, n);
    mask.assign(room, 0);
    out.resize(static_cast<std::size_t>(n));
    for (auto& side : h)
      for (auto& c : side) c.assign(room, 0.0);
    NarrowArgs b = narrow_args(0);
    select_kernels(Isa::automatic).narrow(b);
    contacts = b.contact_end[2];
  }
};

}  // namespace talus::perf
