// See shaped_contacts.hpp.
#include "scheduler/nodes/shaped_contacts.hpp"

#include <vector>

namespace talus {

/// A pair that is to be solved, from its lower row a to its higher row o.
struct ShapedLane {
  int k = 0;             ///< contact of the block
  bool swapped = false;  ///< a is j
  const Surface *a = nullptr, *o = nullptr;
  Vec3 d;       ///< x_o - x_a [m]
  Vec3 before;  ///< normal of the last step, from a to o; 0: not known
  Vec3 sum;     ///< of the arms of the last step [m]; 0: it did not touch
};

/// A pair that did not touch in the last step, and the direction that may still part it: from its lower row.
struct GapLane {
  int k = 0;  ///< contact of the block
  Vec3 n;
};

/// Pairs that go to the solver together: all of it stays in L1.
struct ShapedBatch {
  static constexpr int k_width = 8;
  alignas(64) double in[PairColumns::k_in][k_width], out[PairColumns::k_out][k_width];
  ShapedLane lane[k_width];
  int n = 0;
  bool full() const { return n == k_width; }
};

struct ShapedLanes {
  /// Nearly all pairs whose last normal is known are solved by few steps of Newton's method on the bodies as they are.
  /// The others take the path from rounder ones, in batches of their own: one of them would hold up seven.
  ShapedBatch quick, hard;
  alignas(64) double gap_in[GapColumns::k_in][ShapedBatch::k_width], gap[ShapedBatch::k_width];
  GapLane apart[ShapedBatch::k_width];
  int gaps = 0;
  std::vector<Surface> own;  ///< of the rows of the chunk
  /// Of the rows of other chunks that contacts of the block have; -1: not looked at.
  Surface outside[k_block];
  Row outside_row[k_block];
};

/// What the solver found, in space: the normal from a to o.
struct ShapedContacts::Answer {
  Vec3 normal;
  double overlap = 0;
  Vec3 arm;  ///< from the centre of a to the contact point [m]
};

namespace {

using shapes::Plain;

constexpr int k_quick = 3, k_most = 80;  // evaluations; pairs that need more take the ladder of solve_pair()

/// A gap has to exceed this to count, relative to the sum of the radii of both spheres: more than rounding leaves.
constexpr double k_gap_margin = 1e-12;

Vec3 line_of_centres(Vec3 d, double size) {
  const double d2 = norm2(d);
  return d2 > 1e-24 * (size * size) ? (1 / __builtin_sqrt(d2)) * d : Vec3{0, 0, 1};
}

/// Fills a batch up with copies of the last pair.
template <std::size_t N>
void fill_up(double (&columns)[N][ShapedBatch::k_width], int n) {
  for (int k = n; k < ShapedBatch::k_width; ++k)
    for (auto& column : columns) column[k] = column[n - 1];
}

/// As shapes::pair_form().
void fill_lane(ShapedBatch& batch, int at, double eta) {
  const ShapedLane& q = batch.lane[at];
  const Surface &a = *q.a, &o = *q.o;
  int column = 0;
  const auto put = [&](double v) { batch.in[column++][at] = v; };
  const auto put3 = [&](Vec3 v) { put(v.x), put(v.y), put(v.z); };
  for (const shapes::DualForm<Plain>* f : {&a.form, &o.form})
    put3({f->axes2.x, f->axes2.y, f->axes2.z}), put(f->p1), put(f->p2);
  for (int k = 0; k < 3; ++k) put3(shapes::to_body(a.turn, {o.turn.row[0][k], o.turn.row[1][k], o.turn.row[2][k]}));
  put3(shapes::to_body(a.turn, q.d));
  const double size = fmax2(a.size, o.size);
  put(size);
  put(0);  // range
  put3(shapes::to_body(a.turn, norm2(q.before) > 0 ? q.before : line_of_centres(q.d, size)));
  put(eta);
  put(1);  // care
}

void solve(const Rules& rules, ShapedBatch& batch, int most) {
  if (batch.n == 0) return;
  fill_up(batch.in, batch.n);
  rules.law.solver({batch.n, ShapedBatch::k_width, batch.in[0], batch.out[0]}, most);
}

bool solved(const ShapedBatch& batch, int lane) { return batch.out[10][lane] > 0.5; }

}  // namespace

ShapedContacts::ShapedContacts(const Rules& rules, const Clock& clock, const Rows& rows, Chunk& c)
    : rules_(rules), rows_(rows), c_(c), relaxing_(clock.step < rules.scene.relax.steps) {
  Scratch& s = *c.scratch;
  grow(s.depth, static_cast<std::size_t>(c.contacts.end[2]));
  if (s.lanes == nullptr) s.lanes = std::make_shared<ShapedLanes>();
  s.lanes->own.resize(static_cast<std::size_t>(c.hi - c.lo));
  for (Row i = c.lo; i < c.hi; ++i) set_surface(rules, rows, i, s.lanes->own[static_cast<std::size_t>(i - c.lo)]);
  for (std::int64_t& n : c.contacts.apart) n = 0;
  for (std::int64_t& n : c.contacts.solved) n = 0;
}

void ShapedContacts::judge_depth(std::int64_t slot, Row i, Row j, double overlap, double inner) {
  const std::int64_t known = c_.result.deep_slot;  // the first of the list, whatever is solved first
  if (relaxing_ || (known >= 0 && known < slot) || overlap <= rules_.scene.max_overlap * inner) return;
  c_.result.deep_slot = slot;
  c_.result.deep_rows[0] = i;
  c_.result.deep_rows[1] = j;
}

const Surface& ShapedContacts::surface(int k, Row i) const {
  ShapedLanes& lanes = *c_.scratch->lanes;
  if (i >= c_.lo && i < c_.hi) return lanes.own[static_cast<std::size_t>(i - c_.lo)];
  if (lanes.outside_row[k] != i) set_surface(rules_, rows_, i, lanes.outside[k]);
  lanes.outside_row[k] = i;
  return lanes.outside[k];
}

bool ShapedContacts::between_spheres(Row i, Row j) const {
  const auto sphere = [&](Row row) {
    if (row < c_.lo || row >= c_.hi) return superquadric_of(rules_, rows_, row) == nullptr;
    return c_.scratch->lanes->own[static_cast<std::size_t>(row - c_.lo)].shape == nullptr;
  };
  return sphere(i) && sphere(j);
}

/// A pair that did not touch: what the overlap along its last normal needs, or along the line of centres.
void ShapedContacts::guess(int k, std::int64_t at, Row i, Row j, const Block& b, ShapedLanes& lanes) {
  const int lane = lanes.gaps++;
  const bool swapped = i > j;
  const double sign = swapped ? -1 : 1;
  const Vec3 d = -sign * Vec3{b.x[k], b.y[k], b.z[k]};
  const Column<double>* h = c_.contacts.h + rules_.has.law_columns;
  const auto slot = static_cast<std::size_t>(at);
  Vec3 n = sign * Vec3{h[0][slot], h[1][slot], h[2][slot]};
  if (!(norm2(n) > 0)) n = line_of_centres(d, b.w[k]);
  lanes.apart[lane] = {k, n};
  int column = 0;
  const auto put = [&](double v) { lanes.gap_in[column++][lane] = v; };
  const Row rows[2] = {swapped ? j : i, swapped ? i : j};
  for (int side = 0; side < 2; ++side) {
    const Surface& of = surface(k, rows[side]);
    const Vec3 m = shapes::to_body(of.turn, n);
    put(of.form.axes2.x), put(of.form.axes2.y), put(of.form.axes2.z), put(of.form.p1), put(of.form.p2);
    put(m.x), put(m.y), put(m.z);
  }
  put(dot(n, d));
}

/// Pairs that their direction still parts are left: the others go to the solver.
void ShapedContacts::part(std::int64_t k0, const Block& b, ShapedLanes& lanes, BlockBuffers& buffers) {
  if (lanes.gaps == 0) return;
  fill_up(lanes.gap_in, lanes.gaps);
  rules_.law.gaps({lanes.gaps, ShapedBatch::k_width, lanes.gap_in[0], lanes.gap});
  Column<double>* h = c_.contacts.h + rules_.has.law_columns;
  for (int lane = 0; lane < lanes.gaps; ++lane) {
    const GapLane& q = lanes.apart[lane];
    if (!(lanes.gap[lane] < -k_gap_margin * b.w[q.k])) continue;
    const auto slot = static_cast<std::size_t>(k0 + q.k);
    const double sign = c_.scratch->ci[slot] > c_.scratch->cj[slot] ? -1 : 1;
    for (int m = 0; m < 3; ++m) h[m][slot] = sign * q.n[m];
    leave(q.k, k0 + q.k, buffers);
  }
  lanes.gaps = 0;
}

void ShapedContacts::leave(int k, std::int64_t at, BlockBuffers& buffers) {
  kind_[k] = Kind::apart;
  c_.scratch->depth[static_cast<std::size_t>(at)] = 0;
  ++c_.contacts.apart[interior(at) ? 0 : 1];
  give_apart(k, buffers);
}

void ShapedContacts::queue(int k, std::int64_t at, Row i, Row j, const Block& b, ShapedLanes& lanes) const {
  const Column<double>* h = c_.contacts.h + rules_.has.law_columns;
  const auto n = static_cast<std::size_t>(at);
  const Vec3 before{h[0][n], h[1][n], h[2][n]};
  const bool known = norm2(before) > 0;
  ShapedBatch& batch = known ? lanes.quick : lanes.hard;
  ShapedLane& q = batch.lane[batch.n];
  q.k = k;
  q.swapped = i > j;
  const Row a = q.swapped ? j : i, o = q.swapped ? i : j;
  q.a = &surface(k, a);
  q.o = &surface(k, o);
  const double sign = q.swapped ? -1 : 1;
  q.d = -sign * Vec3{b.x[k], b.y[k], b.z[k]};
  q.before = sign * before;
  q.sum = {h[3][n], h[4][n], h[5][n]};
  fill_lane(batch, batch.n++, known ? shapes::k_eta : 1);
}

/// What the solver left undone is done by the safe method.
ShapedContacts::Answer ShapedContacts::safe_answer(const ShapedLane& q, double share) {
  shapes::PairMemory memory;
  memory.known = norm2(q.before) > 0;
  memory.normal = shapes::to_body(q.a->turn, q.before);
  shapes::PairCount count;
  const shapes::PairContact c = shapes::solve_pair(q.a->body({}), q.o->body(q.d), memory, count);
  return {c.normal, c.overlap, c.point + ((0.5 - share) * c.overlap) * c.normal};
}

/// Inlined: an answer that goes through memory would be read before its stores are done.
[[gnu::always_inline]] inline ShapedContacts::Answer ShapedContacts::answer(int lane, std::int64_t at,
                                                                            const ShapedBatch& batch) {
  const ShapedLane& q = batch.lane[lane];
  const auto out = [&](int column) { return batch.out[column][lane]; };
  Answer r;
  r.overlap = out(3);
  // the point parts the overlap as the sizes are to each other, which is where two spheres have theirs
  const double share = q.a->middle / (q.a->middle + q.o->middle);
  const bool done = solved(batch, lane), deep = r.overlap > q.a->roundness + q.o->roundness;
  c_.contacts.solved[0] += interior(at) ? 2 : 1;
  if (done && !deep) {
    r.normal = shapes::to_space(q.a->turn, {out(0), out(1), out(2)});
    r.arm = shapes::to_space(q.a->turn, {out(4), out(5), out(6)}) - (share * r.overlap) * r.normal;
    return r;
  }
  c_.contacts.solved[1] += interior(at) ? 2 : 1;
  return safe_answer(q, share);
}

void ShapedContacts::give_apart(int k, BlockBuffers& buffers) const {  // nothing that the law could stumble over
  const double x[4] = {0, 0, k_far_away, 1e-9}, g[4] = {0, k_far_inverse, 1, 0};
  for (int q = 0; q < 4; ++q) buffers.x[q][k] = x[q], buffers.g[q][k] = g[q];
  for (int q = 0; q < 7; ++q) buffers.r[q][k] = 0;
  buffers.r[7][k] = 0;  // as of two held grains: no first step of a contact is weighed
  buffers.reff[k] = 1;
}

/// Geometry and motion of the contact at the middle of the step, as of two points that meet.
void ShapedContacts::give(int lane, std::int64_t k0, const ShapedBatch& batch, BlockBuffers& buffers) {
  const ShapedLane& q = batch.lane[lane];
  const int k = q.k;
  const std::int64_t at = k0 + k;
  const Answer r = answer(lane, at, batch);
  const double sign = q.swapped ? -1 : 1, dt = rules_.scene.dt;
  const bool touch = r.overlap > 0;
  const Vec3 n = r.normal, arm_a = r.arm, arm_o = r.arm - q.d;
  Column<double>* h = c_.contacts.h + rules_.has.law_columns;
  const auto slot = static_cast<std::size_t>(at);
  for (int m = 0; m < 3; ++m) {
    h[m][slot] = sign * n[m];
    h[3 + m][slot] = touch ? arm_a[m] + arm_o[m] : 0;
  }
  if (!touch) return leave(k, at, buffers);
  kind_[k] = Kind::touch;
  c_.scratch->depth[slot] = r.overlap / fmin2(q.a->inner, q.o->inner);
  const Row i = c_.scratch->ci[slot], j = c_.scratch->cj[slot];
  judge_depth(at, i, j, r.overlap, fmin2(q.a->inner, q.o->inner));
  Vec3 mid_a = arm_a, mid_o = arm_o, c = n;
  if (norm2(q.sum) > 0) {
    const Vec3 d = q.d - dt * (q.o->v - q.a->v);
    mid_a = 0.5 * (arm_a + 0.5 * (q.sum + d));
    mid_o = 0.5 * (arm_o + 0.5 * (q.sum - d));
    c = n + q.before;
    c = (1 / norm(c)) * c;
  }
  const Vec3 v = (q.a->v + cross(q.a->w, mid_a)) - (q.o->v + cross(q.o->w, mid_o));
  const double along = dot(v, c);
  Vec3 t = v - along * c;
  t = t - dot(t, n) * n;
  const Vec3 relative = sign * (along * n + t), normal = -sign * n;
  const double answer_a = answer_of(*q.a, arm_a, n), answer_o = answer_of(*q.o, arm_o, n), both = answer_a + answer_o,
               ms = both > 0 ? both : 1;
  for (int m = 0; m < 3; ++m) {
    buffers.x[m][k] = k_far_away * normal[m];
    buffers.r[m][k] = relative[m];
    buffers.r[4 + m][k] = 0;
  }
  buffers.x[3][k] = r.overlap;
  buffers.r[3][k] = 0;
  buffers.r[7][k] = ms;
  const double g[4] = {0, k_far_inverse, 1 / ms, 0};
  for (int m = 0; m < 4; ++m) buffers.g[m][k] = g[m];
  if (rules_.has.reff) {
    const double ra = hertz_radius_of(*q.a, n), ro = hertz_radius_of(*q.o, -n);
    buffers.reff[k] = (ra * ro) / (ra + ro);
  }
  arm_i_[k] = q.swapped ? arm_o : arm_a;
  arm_j_[k] = q.swapped ? arm_a : arm_o;
  const double weight_a = weight_of(*q.a, answer_a), weight_o = weight_of(*q.o, answer_o);
  weight_i_[k] = q.swapped ? weight_o : weight_a;
  weight_j_[k] = q.swapped ? weight_a : weight_o;
}

void ShapedContacts::prepare(std::int64_t k0, Block& b, BlockBuffers& buffers) {
  ShapedLanes& lanes = *c_.scratch->lanes;
  lanes.quick.n = lanes.hard.n = lanes.gaps = 0;
  const Column<double>* h = c_.contacts.h + rules_.has.law_columns;
  for (int k = 0; k < b.n; ++k) {
    const auto at = static_cast<std::size_t>(k0 + k);
    const Row i = c_.scratch->ci[at], j = c_.scratch->cj[at];
    kind_[k] = Kind::spheres;
    lanes.outside_row[k] = -1;
    c_.scratch->depth[at] = -1;
    if (!between_spheres(i, j)) {
      kind_[k] = Kind::touch;
      if (!(norm2({h[3][at], h[4][at], h[5][at]}) > 0)) guess(k, k0 + k, i, j, b, lanes);
      if (lanes.gaps == ShapedBatch::k_width) part(k0, b, lanes, buffers);
      continue;
    }
    const double ri = rows_.p[4L * i + 3], rj = rows_.p[4L * j + 3];
    judge_depth(k0 + k, i, j, b.w[k] - b.g[0][k], fmin2(ri, rj));
  }
  part(k0, b, lanes, buffers);
  for (int k = 0; k < b.n; ++k) {
    if (kind_[k] != Kind::touch) continue;
    const auto at = static_cast<std::size_t>(k0 + k);
    queue(k, k0 + k, c_.scratch->ci[at], c_.scratch->cj[at], b, lanes);
    if (lanes.quick.full()) solve_quick(k0, lanes, buffers);
    if (lanes.hard.full()) solve_hard(k0, lanes.hard, buffers);
  }
  solve_quick(k0, lanes, buffers);
  solve_hard(k0, lanes.hard, buffers);
}

void ShapedContacts::solve_quick(std::int64_t k0, ShapedLanes& lanes, BlockBuffers& buffers) {
  ShapedBatch &quick = lanes.quick, &hard = lanes.hard;
  solve(rules_, quick, k_quick);
  for (int lane = 0; lane < quick.n; ++lane) {
    if (solved(quick, lane)) {
      give(lane, k0, quick, buffers);
      continue;
    }
    hard.lane[hard.n] = quick.lane[lane];
    fill_lane(hard, hard.n++, shapes::k_warm_eta);
    if (hard.full()) solve_hard(k0, hard, buffers);
  }
  quick.n = 0;
}

void ShapedContacts::solve_hard(std::int64_t k0, ShapedBatch& hard, BlockBuffers& buffers) {
  solve(rules_, hard, k_most);
  for (int lane = 0; lane < hard.n; ++lane) give(lane, k0, hard, buffers);
  hard.n = 0;
}

void ShapedContacts::settle(const Block& b) const {
  const auto clear = [&](double* column) {  // without branches: about every other pair is apart
    for (int k = 0; k < b.n; ++k) column[k] = touches(k) ? column[k] : 0.0;
  };
  for (int q = 0; q < 8; ++q) clear(b.r[q]);
  for (int q = 0; q < rules_.has.law_columns; ++q) clear(b.h[q]);
  for (int q = 0; q < 3; ++q) clear(b.e[q]);
}

void ShapedContacts::scatter(const ScatterArgs& to, const Block& b) const {
  const auto add = [&](Row row, Vec3 force, double stiffness, Vec3 torque, double press) {
    double* f = to.f + 8L * row;
    for (int q = 0; q < 3; ++q) f[q] = f[q] + force[q], f[4 + q] = f[4 + q] + torque[q];
    f[3] = f[3] + stiffness;
    f[7] = f[7] + press;
  };
  for (int k = 0; k < to.n; ++k) {
    if (!touches(k)) continue;
    const Row i = to.i[k], j = to.j[k];
    const bool both = k >= to.both_from && k < to.both_to;
    const Vec3 force{b.r[0][k], b.r[1][k], b.r[2][k]};
    if (!shaped(k)) {
      const Vec3 turn{b.r[4][k], b.r[5][k], b.r[6][k]};
      add(i, force, b.r[3][k], turn, b.r[7][k]);
      if (both) add(j, -force, b.r[3][k], turn, b.r[7][k]);
      continue;
    }
    const auto over_radius = [&](Row row, Vec3 torque) { return (1 / rows_.p[4L * row + 3]) * torque; };
    add(i, force, weight_i_[k] * b.r[3][k], over_radius(i, cross(arm_i_[k], force)), b.r[7][k]);
    if (both) add(j, -force, weight_j_[k] * b.r[3][k], over_radius(j, cross(arm_j_[k], -force)), b.r[7][k]);
  }
}

}  // namespace talus
