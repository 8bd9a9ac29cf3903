// See cli_compare_growth.hpp.
#include "cases/program/cli_compare_growth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/error.hpp"
#include "core/io/particle_frames.hpp"

namespace talus::cli {
bool same_bits(double a, double b) noexcept {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

ColumnPairs common_columns(const Frame& a, const Frame& b) {
  ColumnPairs both;
  for (const ExtraColumn& e : a.extra)
    for (const ExtraColumn& f : b.extra)
      if (e.name == f.name) both.emplace_back(&e, &f);
  return both;
}

namespace {

bool same_bits(Vec3 a, Vec3 b) {
  return cli::same_bits(a.x, b.x) && cli::same_bits(a.y, b.y) && cli::same_bits(a.z, b.z);
}

/// The body whose first sphere is particle `id`; frames have their bodies in id order.
const BodyRecord* body_of(const Frame& f, ParticleId id) {
  const auto at = std::lower_bound(f.bodies.begin(), f.bodies.end(), id,
                                   [](const BodyRecord& b, ParticleId wanted) { return b.id < wanted; });
  return at != f.bodies.end() && at->id == id ? &*at : nullptr;
}

/// Where one frame does not tell how bodies lie, they lie alike.
bool lie_alike(const Frame& a, const Frame& b, ParticleId id) {
  const BodyRecord *p = body_of(a, id), *q = body_of(b, id);
  if (p == nullptr || q == nullptr) return true;
  for (std::size_t k = 0; k < 4; ++k)
    if (!cli::same_bits(p->orientation[k], q->orientation[k])) return false;
  return true;
}

/// Adds the names of the columns in which the grains differ.
bool same_columns(const ColumnPairs& columns, std::size_t i, std::size_t j, std::vector<std::string>& others) {
  bool same = true;
  for (const auto& [e, f] : columns) {
    if (cli::same_bits(e->values[i], f->values[j])) continue;
    same = false;
    if (std::find(others.begin(), others.end(), e->name) == others.end()) others.push_back(e->name);
  }
  return same;
}

bool same_grain(const Frame& a, std::size_t i, const Frame& b, std::size_t j) {
  const bool spins = a.w.empty() || b.w.empty() || same_bits(a.w[i], b.w[j]);
  return same_bits(a.x[i], b.x[j]) && same_bits(a.v[i], b.v[j]) && cli::same_bits(a.r[i], b.r[j]) && spins &&
         lie_alike(a, b, a.id[i]);
}

GrowthPoint compare_frames(const Frame& a, const Frame& b, const Box& box, std::vector<std::string>& others) {
  const ColumnPairs columns = common_columns(a, b);
  GrowthPoint p;
  p.time = a.time;
  p.step_a = a.step;
  p.step_b = b.step;
  double x2 = 0, v2 = 0;
  std::size_t i = 0, j = 0;
  while (i < a.id.size() || j < b.id.size()) {  // frames are in id order: one merge
    if (j == b.id.size() || (i < a.id.size() && a.id[i] < b.id[j])) {
      ++p.only_a, ++i;
      continue;
    }
    if (i == a.id.size() || b.id[j] < a.id[i]) {
      ++p.only_b, ++j;
      continue;
    }
    ++p.common;
    if (const bool alike = same_columns(columns, i, j, others); !alike || !same_grain(a, i, b, j)) {
      ++p.different;
      if (p.first < 0) p.first = a.id[i];
    }
    const Vec3 d = box.nearest_of_any(a.x[i] - b.x[j]);
    const double dx2 = norm2(d), dv2 = norm2(a.v[i] - b.v[j]);
    x2 += dx2;
    v2 += dv2;
    if (dx2 > p.max * p.max || p.worst < 0) p.max = std::sqrt(dx2), p.worst = a.id[i];
    p.max_velocity = std::max(p.max_velocity, std::sqrt(dv2));
    ++i, ++j;
  }
  if (p.common > 0) {
    p.rms = std::sqrt(x2 / static_cast<double>(p.common));
    p.rms_velocity = std::sqrt(v2 / static_cast<double>(p.common));
  }
  return p;
}

/// Least squares of ln(rms) over t, while the difference is there and still small.
void fit(Growth& g) {
  double st = 0, sy = 0, stt = 0, sty = 0, syy = 0;
  for (const GrowthPoint& p : g.points) {
    if (p.rms > 0.1 * g.radius) break;  // saturates from here on
    if (!(p.rms > 0)) continue;
    const double y = std::log(p.rms);
    st += p.time;
    sy += y;
    stt += p.time * p.time;
    sty += p.time * y;
    syy += y * y;
    ++g.fitted;
  }
  const double n = g.fitted, tt = n * stt - st * st, ty = n * sty - st * sy, yy = n * syy - sy * sy;
  if (g.fitted < 3 || !(tt > 0)) return;
  g.rate = ty / tt;
  g.quality = yy > 0 ? ty * ty / (tt * yy) : 1;
}

}  // namespace

Growth compare_growth(const std::string& a, const std::string& b, const Domain& domain) {
  const ParticleFrames first(a), second(b);
  const auto &sa = first.steps(), &sb = second.steps();
  Growth g;
  std::size_t i = 0, j = 0;
  while (i < sa.size() && j < sb.size()) {
    const double slack = 1e-9 * std::max(std::fabs(sa[i].time), std::fabs(sb[j].time));
    if (sa[i].time < sb[j].time - slack) {
      ++i;
    } else if (sb[j].time < sa[i].time - slack) {
      ++j;
    } else {
      const Frame fa = first.frame(i++), fb = second.frame(j++);
      if (g.radius == 0 && !fa.r.empty()) {
        for (const double r : fa.r) g.radius += r / static_cast<double>(fa.r.size());
      }
      const GrowthPoint p = compare_frames(fa, fb, domain.box(), g.others);
      if (g.first_time < 0 && p.different + p.only_a + p.only_b > 0) g.first_time = p.time;
      if (g.horizon < 0 && g.radius > 0 && p.rms > g.radius) g.horizon = p.time;
      g.points.push_back(p);
    }
  }
  fit(g);
  return g;
}

std::string growth_text(const Growth& g) {
  if (g.points.empty()) return "the runs have no frame of the same time\n";
  if (g.equal()) return fmt::format("frames: {} common ones, equal bit for bit\n", g.points.size());
  std::string text =
      fmt::format("frames: {} common ones, the first that differs at t = {:.6g} s\n", g.points.size(), g.first_time);
  text += fmt::format("  {:>12} {:>10} {:>10} {:>12} {:>12} {:>12}  {}\n", "t [s]", "common", "different", "rms [m]",
                      "max [m]", "rms v [m/s]", "first id");
  std::string others;
  for (const std::string& name : g.others) others += (others.empty() ? "" : ", ") + name;
  if (!others.empty()) text += fmt::format("  also in the columns: {}\n", others);
  const std::size_t every = (g.points.size() + 23) / 24;
  for (std::size_t k = 0; k < g.points.size(); ++k) {
    const GrowthPoint& p = g.points[k];
    // all of them where they are few; otherwise the first that differs, the last, and every n-th
    if (k % every != 0 && k + 1 != g.points.size() && p.time != g.first_time) continue;
    text += fmt::format("  {:>12.6g} {:>10} {:>10} {:>12.4e} {:>12.4e} {:>12.4e}  {}\n", p.time, p.common, p.different,
                        p.rms, p.max, p.rms_velocity, p.first < 0 ? "-" : fmt::format("{}", p.first));
  }
  if (g.fitted >= 3)
    text += fmt::format("growth: rms ~ exp({:.4g} t / s) over {} frames below a tenth of a radius (R^2 {:.3f})\n",
                        g.rate, g.fitted, g.quality);
  else
    text += "growth: fewer than 3 frames with a small difference, no rate\n";
  if (g.horizon >= 0) text += fmt::format("horizon: rms exceeds one radius at t = {:.6g} s\n", g.horizon);
  return text;
}

}  // namespace talus::cli
