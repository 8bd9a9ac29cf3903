// Implementation of pair_contact.hpp: the ladder of methods, from cheap to safe.
#include "core/shapes/pair_contact.hpp"

#include <algorithm>

#include "core/shapes/direction_search.hpp"

namespace talus::shapes {
namespace {

using Vector = Triple<Plain>;

Vector plain(Vec3 v) noexcept { return {v.x, v.y, v.z}; }
Vec3 vec(const Vector& v) noexcept { return {v.x, v.y, v.z}; }

PairState<Plain> start(const Vector& n, double eta, double care, double range) noexcept {
  PairState<Plain> s{};
  s.n = n;
  s.eta = eta;
  s.care = care;
  s.range = range;
  s.steps = 0;
  s.done = false;
  return s;
}

/// Runs Newton's method and adds its cost.
bool run(const PairForm<Plain>& p, PairState<Plain>& s, int most, double& spent) noexcept {
  iterate<Plain>(p, s, most);
  spent += s.steps;
  return s.done;
}

Vector line_of_centres(const PairForm<Plain>& p) noexcept {
  const double d2 = dot<Plain>(p.d, p.d);
  return d2 > 1e-24 * (p.size * p.size) ? unit<Plain>(p.d) : Vector{0, 0, 1};
}

/// From directions that the search found, with ever less rounding: `ceiling` is the overlap that it knows to be
/// reachable.
bool polish(const PairForm<Plain>& p, const Vector& n, double ceiling, double range, PairState<Plain>& s,
            double& spent) noexcept {
  for (const double eta : {0.1, 1e-2, 1e-3, 1e-4, 1e-6, k_eta}) {
    s = start(n, eta, 0.25, range);
    if (run(p, s, 120, spent) && s.delta <= ceiling + 1e-9 * p.size) return true;
  }
  return false;
}

/// Without Newton's help: the cell of the search is made as small as doubles allow.
void bracket(const PairForm<Plain>& p, double range, PairState<Plain>& s, double& spent) noexcept {
  const Direction d = search_directions(p, 1e-13 * p.size, 1e-10);
  spent += static_cast<double>(d.evaluations);
  s = start(d.n, k_eta, 1, range);
  s.delta = d.overlap;
  iterate<Plain>(p, s, 1);  // one step: points of both bodies that fit to each other
  s.n = d.n;
  s.delta = d.overlap;
  s.done = true;
}

/// Least overlap over all directions, to full precision.
void search(const PairForm<Plain>& p, double range, PairState<Plain>& s, double& spent, PairCount& count) noexcept {
  const Direction d = search_directions(p, 1e-3 * p.size, 3e-3);
  spent += static_cast<double>(d.evaluations);
  ++count.searched;
  if (polish(p, d.n, d.overlap, range, s, spent)) return;
  ++count.bracketed;
  bracket(p, range, s, spent);
}

}  // namespace

Body make_body(const Superquadric& s, double roundness, Vec3 centre, Quaternion q) noexcept {
  return {dual_form(s), fmax2(s.axes.x, fmax2(s.axes.y, s.axes.z)), roundness, centre, rotation(q)};
}

PairForm<Plain> pair_form(const Body& i, const Body& j) noexcept {
  PairForm<Plain> p;
  p.i = i.form;
  p.j = j.form;
  p.d = plain(to_body(i.turn, j.centre - i.centre));
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis{j.turn.row[0][k], j.turn.row[1][k], j.turn.row[2][k]};
    p.turn[k] = plain(to_body(i.turn, axis));
  }
  p.size = fmax2(i.size, j.size);
  return p;
}

PairContact solve_pair(const Body& i, const Body& j, PairMemory& memory, PairCount& count, double range) noexcept {
  const PairForm<Plain> p = pair_form(i, j);
  PairState<Plain> s{};
  double spent = 0;
  bool solved = false;
  ++count.pairs;
  if (memory.known) {
    s = start(plain(memory.normal), k_warm_eta, 1, range);
    solved = run(p, s, 60, spent);
    count.from_memory += solved;
  }
  if (!solved) {
    s = start(line_of_centres(p), 1, 1, range);
    solved = run(p, s, 80, spent);
    count.along_path += solved;
  }
  if (!solved) {
    s = start(line_of_centres(p), 30, 0.25, range);
    solved = run(p, s, 300, spent);
    count.with_care += solved;
  }
  if (!solved) search(p, range, s, spent, count);
  PairContact c;
  if (s.delta > i.roundness + j.roundness) {
    const PairState<Plain> local = s;
    search(p, range, s, spent, count);
    if (local.delta <= s.delta + 1e-12 * p.size) s = local;  // the one that was followed, where both are the least
    ++count.deep;
    c.deep = true;
  }
  count.evaluations += static_cast<std::int64_t>(spent);
  count.most_evaluations = std::max(count.most_evaluations, static_cast<std::int64_t>(spent));
  memory.normal = vec(s.n);
  memory.known = true;
  c.normal = to_space(i.turn, vec(s.n));
  c.overlap = s.delta;
  c.point = i.centre + (to_space(i.turn, vec(s.xi)) - (0.5 * s.delta) * c.normal);
  return c;
}

}  // namespace talus::shapes
