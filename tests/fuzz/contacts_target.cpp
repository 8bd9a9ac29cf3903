// The scalar kernels against the oracle of kernels/reference.hpp, on ordinary contacts made from bytes. Both round
// differently: a result may be off by rounding of the largest term, and near a switch of the law (touched just now,
// sliding) the oracle on either side of it counts.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "core/base/det_math.hpp"
#include "kernels/kernel_table.hpp"
#include "kernels/reference.hpp"
#include "tests/fuzz/values.hpp"

namespace talus::fuzz {

namespace {

constexpr int k_size = k_block + k_pad;
constexpr double k_switch = 1e-7;  ///< relative distance from a switch at which both sides count

/// One pair in rows 0 and 1, its histories and the block that a law reads.
struct Contact {
  reference::Pair pair;
  Vec3 history, rolling;
  double last_radius, predicted, twisting, stiffness;
  alignas(64) double p[4 * k_pad] = {}, v[8 * k_pad] = {};
  alignas(64) std::int32_t i[k_size], j[k_size], material[k_size] = {};
  alignas(64) double x[4][k_size] = {}, g[4][k_size] = {}, r[8][k_size] = {}, e[3][k_size] = {}, s[4][k_size] = {},
                     reff[k_size] = {}, h[k_max_columns][k_size] = {};

  /// `least`, `most`: overlap over the sum of radii.
  Contact(Values& s, double least, double most) {
    reference::Pair& t = pair;
    const auto vector = [&](double size) {
      return Vec3{s.between(-size, size), s.between(-size, size), s.between(-size, size)};
    };
    t.ri = s.between(0.25, 0.75);
    t.rj = s.between(0.25, 0.75);
    Vec3 n = vector(1);
    n = (1 / norm(n)) * n;  // no component is 0
    t.xj = vector(1);
    t.xi = t.xj + ((t.ri + t.rj) * (1 - s.between(least, most))) * n;
    t.vi = vector(1);
    t.vj = s.flag() != 0 ? t.vi + 1e-3 * vector(1) : vector(1);
    t.wi = vector(1);
    t.wj = s.flag() != 0 ? t.wi : vector(1);
    t.mi = s.between(0.5, 1.5);
    t.mj = s.flag() != 0 ? HUGE_VAL : s.between(0.5, 1.5);
    history = (s.flag() != 0 ? 1e-3 : 0.0) * vector(1);
    last_radius = s.flag() != 0 ? s.between(0.01, 0.2) : 0;
    predicted = s.flag() != 0 ? s.between(0.01, 1) * (s.flag() != 0 ? 1 : -1) : 0;
    rolling = 0.05 * vector(1);
    twisting = s.between(-0.05, 0.05);
    stiffness = s.flag() != 0 ? s.between(50, 200) : 0;
    put(0, t.xi, t.ri, t.vi, t.wi, t.mi);
    put(1, t.xj, t.rj, t.vj, t.wj, t.mj);
    for (int k = 2; k < k_pad; ++k) {
      for (int q = 0; q < 3; ++q) p[4 * k + q] = 1e150;
      v[8 * k + 7] = 1;
    }
    std::fill(i, i + k_size, 2);
    std::fill(j, j + k_size, 2);
    i[0] = 0;
    j[0] = 1;
  }
  Contact(const Contact&) = delete;

  void put(int row, Vec3 centre, double radius, Vec3 velocity, Vec3 spin, double mass) {
    for (int q = 0; q < 3; ++q) {
      p[4 * row + q] = centre[q];
      v[8 * row + q] = velocity[q];
      v[8 * row + 4 + q] = radius * spin[q];
    }
    p[4 * row + 3] = radius;
    v[8 * row + 7] = 1 / mass;
  }

  /// Gathers with the rows of a scene with friction or (four doubles each) without.
  Block gathered(const KernelTable& k, bool friction) {
    alignas(64) double narrow[4 * k_pad];
    for (int row = 0; row < k_pad; ++row)
      for (int q = 0; q < 4; ++q) narrow[4 * row + q] = v[8 * row + (q < 3 ? q : 7)];
    GatherArgs a{};
    a.v = friction ? v : narrow;
    a.p = p;
    a.i = i;
    a.j = j;
    a.n = 1;
    a.x = x;
    a.r = r;
    a.g = g;
    a.reff = reff;
    k.gather[friction ? 1 : 0](a);
    Block b{};
    b.n = 1;
    b.x = x[0];
    b.y = x[1];
    b.z = x[2];
    b.w = x[3];
    b.g = g;
    b.r = r;
    for (int q = 0; q < k_max_history; ++q) b.h_in[q] = b.h[q] = h[q];
    b.reff = reff;
    b.pair = material;
    b.e = e;
    return b;
  }
};

bool near(Vec3 a, Vec3 b, double tolerance) { return norm(a - b) <= tolerance; }

struct Expected {
  reference::Result result;
  Vec3 history;
  double radius, predicted;
};

Expected oracle(ContactModel model, const Contact& c, const reference::Pair& pair, const PairParameters& one,
                const LawArgs& a, bool friction) {
  Expected e{{}, c.history, c.last_radius, c.predicted};
  e.result = model == ContactModel::linear
                 ? reference::linear(pair, one, a, friction, e.history, e.predicted)
                 : reference::hertz_mindlin(pair, one, a, friction, e.history, e.radius, e.predicted);
  return e;
}

/// What a law left for one contact.
struct Found {
  Vec3 force, turn, history;
  double radius, predicted;
};

bool agree(const Found& f, const Expected& e, const reference::Pair& p, ContactModel model, const LawArgs& a,
           bool friction, double force, double spring) {
  if (!near(f.force, e.result.force, force)) return false;
  if (a.recall != 0 && std::fabs(f.predicted - e.predicted) > 1e-10 + a.dt * 4 * force) return false;
  if (!friction) return true;
  if (model != ContactModel::linear && std::fabs(f.radius - e.radius) > 1e-9 * e.radius) return false;
  return near(p.ri * f.turn, e.result.torque_i, force) && near(p.rj * f.turn, e.result.torque_j, force) &&
         near(f.history, e.history, spring);
}

LawArgs law_args(Values& s, ContactModel model) {
  LawArgs a{};
  a.by_restitution = model == ContactModel::linear ? s.flag() : 0;
  if (model == ContactModel::linear)
    a.one = {
        s.between(500, 4e3), s.between(100, 2e3),        a.by_restitution != 0 ? s.between(0, 1) : s.between(0, 60),
        s.between(0, 30),    s.flag() * s.between(0, 1), 0};
  else
    a.one = {s.between(1e4, 2e5), s.between(1e4, 1e5), s.between(0, 1), s.between(0, 1), s.flag() * s.between(0, 1), 0};
  a.dt = 1e-3;
  a.centred = s.flag();
  a.onset = a.centred & s.flag();
  a.recall = a.centred & s.flag();
  a.synchronised = s.flag();
  a.contact_lever = s.flag();
  a.clip = s.flag();
  a.total = s.flag();
  a.start = s.flag();
  a.balanced = model == ContactModel::linear ? s.flag() : 0;
  return a;
}

void check_law(Values& s, ContactModel model) {
  const LawArgs a = law_args(s, model);
  const bool friction = s.flag() != 0;
  const auto c = std::make_unique<Contact>(s, 1e-6, s.flag() != 0 ? 1e-4 : 2e-2);
  const KernelTable& k = select_kernels(Isa::scalar);
  const LawInfo& law = law_info(model);
  Block b = c->gathered(k, friction);
  const int recalled = friction ? law.history : 0;
  for (int q = 0; q < 3 && friction; ++q) c->h[q][0] = c->history[q];
  if (friction && model != ContactModel::linear) c->h[3][0] = c->last_radius;
  if (a.recall != 0) c->h[recalled][0] = c->predicted;
  k.law[law_index(law, friction, false, false)](b, a);
  const Found f{{c->r[0][0], c->r[1][0], c->r[2][0]},
                {c->r[4][0], c->r[5][0], c->r[6][0]},
                {c->h[0][0], c->h[1][0], c->h[2][0]},
                c->h[3][0],
                c->h[recalled][0]};
  // The largest terms that forces are made of: stiffness times the rounded overlap, dashpots, the stored spring.
  const double stiff = model == ContactModel::linear ? a.one.kn + a.one.kt : a.one.kn + a.one.kt;
  const double meff = 1 / (1 / c->pair.mi + 1 / c->pair.mj);
  const double rate = model == ContactModel::linear
                          ? a.one.gn * (a.by_restitution != 0 ? std::sqrt(a.one.kn / meff) : 1) + 4 * a.one.gt
                          : 2 * std::sqrt(stiff / meff);
  const double top = stiff * 0.05 + rate * meff * 8;
  // The synchronised form expands 1/|c|^2 and leaves (v dt / 2 d)^2 of the velocities.
  const double tolerance = (a.synchronised != 0 ? 2e-5 : 1e-10) * top;
  const double spring = model == ContactModel::linear ? tolerance / a.one.kt * 4 : tolerance;
  const auto sides = {0.0, -k_switch, k_switch};
  for (const double touch : sides)
    for (const double slide : sides) {
      reference::Pair p = c->pair;
      const Vec3 along = p.xi - p.xj;
      const double overlap = p.ri + p.rj - norm(along);
      p.xi = p.xi + (-touch * overlap / norm(along)) * along;
      PairParameters one = a.one;
      one.mu *= 1 + slide;
      const double slack = touch == 0 && slide == 0 ? 0 : 4 * k_switch * top;
      const Expected e = oracle(model, *c, p, one, a, friction);
      if (agree(f, e, p, model, a, friction, tolerance + slack,
                spring + slack / (model == ContactModel::linear ? a.one.kt : 1)))
        return;
    }
  claim(false, model == ContactModel::linear ? "the linear law is not that of the oracle"
                                             : "the Hertz law is not that of the oracle");
}

void check_moments(Values& s) {
  MomentArgs a{};
  a.one = {s.between(0.01, 0.5), s.between(0, 0.5), s.between(0.01, 0.5), s.between(0, 0.5), 0};
  a.dt = 1e-3;
  a.rolling = s.below(3);
  a.twisting = s.flag();
  a.rescale = a.rolling != 1 ? s.flag() : 0;
  a.centred = s.flag();
  const auto c = std::make_unique<Contact>(s, 1e-4, 2e-2);
  const KernelTable& k = select_kernels(Isa::scalar);
  const Block b = c->gathered(k, true);
  const double slid = s.flag() != 0 ? a.dt : s.flag() * s.between(0.01, 0.99) * a.dt;
  const double pressing = s.flag() * s.between(0, 5), stiffness = s.between(50, 150);
  c->r[3][0] = stiffness;
  c->r[7][0] = pressing;
  k.spin({c->p, c->v, c->i, c->j, 1, c->s});
  alignas(64) double slid_of[8];
  std::fill_n(slid_of, 8, slid);
  MomentBlock m{};
  m.n = 1;
  m.x = b.x;
  m.y = b.y;
  m.z = b.z;
  m.r = c->r;
  m.reff = c->reff;
  m.slid = slid_of;
  m.pair = c->material;
  m.s = c->s;
  const int twist = a.rolling == 2 ? 3 : 0, last = twist + a.twisting;
  for (int q = 0; q < k_max_moment; ++q) m.h[q] = c->h[q];
  for (int q = 0; q < 3 && a.rolling == 2; ++q) c->h[q][0] = c->rolling[q];
  if (a.twisting != 0) c->h[twist][0] = c->twisting;
  if (a.rescale != 0) c->h[last][0] = c->stiffness;
  k.moments(m, a);
  const Vec3 found{c->s[0][0], c->s[1][0], c->s[2][0]};
  const auto sides = {0.0, -k_switch, k_switch};
  for (const double press : sides) {
    reference::MomentHistory h{c->rolling, c->twisting, c->stiffness};
    const Vec3 wanted = reference::moments(c->pair, (1 + press) * pressing, stiffness, slid, a.one, a, h);
    const double tolerance = press == 0 ? 1e-11 : 100 * k_switch;
    bool same = near(found, wanted, tolerance);
    if (a.rolling == 2) same = same && near({c->h[0][0], c->h[1][0], c->h[2][0]}, h.rolling, tolerance);
    if (a.twisting != 0) same = same && std::fabs(c->h[twist][0] - h.twisting) <= tolerance;
    if (a.rescale != 0) same = same && c->h[last][0] == stiffness;
    if (same) return;
  }
  claim(false, "rolling or twisting is not that of the oracle");
}

/// Frictionless JKR without dashpot, from the rupture of the neck to deep overlap.
void check_jkr(Values& s) {
  const double e_star = std::pow(10.0, s.between(4, 9)), radius = std::pow(10.0, s.between(-6, 0));
  const double w = std::pow(10.0, s.between(-4, 1)), reff = 0.5 * radius;
  const double kappa = det::k_pi * w / (8 * e_star), unit = std::cbrt(kappa * kappa * reff);
  if (unit > 0.05 * reff || unit < 1e-12 * reff) return;  // no neck of a stiff grain
  const double wanted = s.flag() != 0 ? unit * s.between(-2.999, 3) : s.between(0, 0.4 * reff);
  const double distance = 2 * radius - wanted, delta = 2 * radius - distance;
  const auto c = std::make_unique<Contact>(s, 1e-4, 2e-2);
  const KernelTable& k = select_kernels(Isa::scalar);
  Block b = c->gathered(k, false);
  for (int q = 0; q < k_size; ++q) {
    c->x[0][q] = q == 0 ? distance : 2 * radius;
    c->x[1][q] = c->x[2][q] = 0;
    c->x[3][q] = 2 * radius;
    c->reff[q] = reff;
    for (int t = 0; t < 3; ++t) c->r[t][q] = 0;
    c->r[3][q] = 1;
  }
  k.geometry(GeometryArgs{1, c->x[0], c->x[1], c->x[2], c->x[3], c->r[3], c->g});
  LawArgs a{};
  a.one.kn = 4.0 / 3.0 * e_star;
  a.one.w = w;
  a.dt = 1e-6;
  k.law[law_index(law_info(ContactModel::jkr), false, false, false)](b, a);
  const reference::JkrState o = reference::jkr(delta, reff, e_star, w);
  // the root of the neck's equation opens like a square root at rupture; the distance is rounded
  const double noise = 4e-16 * radius / unit;
  const double tolerance = 1e-10 + 40 * std::sqrt(noise);
  claim(std::fabs(c->r[0][0] - o.force) <= tolerance * (det::k_pi * w * reff + std::fabs(o.force)),
        "the force of JKR is not that of the oracle");
  claim(std::fabs(c->r[3][0] / (2 * e_star * o.radius) - 1) <= tolerance,
        "the contact of JKR is not that of the oracle");
}

void check_cohesion(Values& s) {
  const bool wall = s.flag() != 0;
  const auto c = std::make_unique<Contact>(s, 1e-6, 0.3);
  const KernelTable& k = select_kernels(Isa::scalar);
  const Block gathered = c->gathered(k, true);
  Block b = gathered;
  const Vec3 x = c->pair.xi - c->pair.xj;
  const double d = norm(x), density = s.between(0, 10), ri = wall ? c->x[3][0] : c->pair.ri;
  Vec3 before{c->r[0][0], c->r[1][0], c->r[2][0]};
  CohesionArgs a{density, nullptr, wall ? nullptr : c->p, c->i, c->j, 0};
  k.cohesion(b, a);
  const Vec3 added = Vec3{c->r[0][0], c->r[1][0], c->r[2][0]} - before;
  const double pull = reference::sjkr(d, ri, c->pair.rj, wall, density);
  claim(near(added, (-pull / d) * x, 1e-11 * (1 + density)), "cohesion is not that of the oracle");
}

}  // namespace

void contacts(Bytes input) {
  Values s(input);
  switch (s.below(6)) {
    case 0:
    case 1:
      return check_law(s, ContactModel::linear);
    case 2:
    case 3:
      return check_law(s, ContactModel::hertz_mindlin);
    case 4:
      return s.flag() != 0 ? check_moments(s) : check_cohesion(s);
    default:
      return check_jkr(s);
  }
}

}  // namespace talus::fuzz
