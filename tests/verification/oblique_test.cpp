// Oblique impacts in three dimensions, slip and spins in all directions, against an integrator written apart from the
// engine (oblique_reference.hpp): the error falls with the step for every law, restitution, tangential damping and
// friction, between unequal spheres, on a plane and on a mesh, with rolling and twisting resistance. Planar impacts
// cannot see what a return map does to the direction of the stored spring.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "ladder.hpp"
#include "oblique_reference.hpp"

namespace talus::verification {
namespace {

enum class Partner { sphere, plane, mesh };

struct Setting {
  bool hertz = false;
  double e = 1, damping = 0, mu = 0.3;  ///< damping: ratio of the tangential dashpot (linear)
  Partner partner = Partner::sphere;
  bool moments = false;  ///< rolling (epsd) and twisting resistance
  bool partial_slip = false;
  double ratio = 0;           ///< radius of the partner over that of the grain; 0: random, near one
  double slip = 6, spin = 3;  ///< largest slip and surface speed by spins over mu times the closing speed
  bool balanced = false;      ///< contact.sliding
  double phase = -1;          ///< of all impacts; below zero: random
};

constexpr int k_impacts = 5;
constexpr double k_depth = 0.02;  ///< closing speed times contact time / sum of radii

std::string name_of(const Setting& q) {
  char text[160], unusual[60] = "";
  if (q.ratio != 0 || q.slip != 6 || q.spin != 3)
    std::snprintf(unusual, sizeof unusual, " radii 1:%.2g slip %.2g spin %.2g", q.ratio, q.slip, q.spin);
  std::snprintf(text, sizeof text, "%s%s%s%s e %.2g damping %.2g mu %.2g%s", q.hertz ? "Hertz" : "linear",
                q.partner == Partner::plane  ? " on plane"
                : q.partner == Partner::mesh ? " on mesh"
                                             : "",
                q.moments ? " rolling" : "", q.partial_slip ? " partial slip" : "", q.e, q.damping, q.mu, unusual);
  return text;
}

struct Shot {
  Body a, b;
  Vec3 n;        ///< from b to a
  double phase;  ///< share of a step that has passed at touch
};

Vec3 direction(int seed, int k) {
  const double z = 2 * uniform(seed, 2 * k) - 1, turn = 2 * k_pi * uniform(seed, 2 * k + 1), h = std::sqrt(1 - z * z);
  return {h * std::cos(turn), h * std::sin(turn), z};
}

/// Contacts of about one second; m_eff about 1/2.
std::vector<Shot> shots(const Setting& q, double density) {
  std::vector<Shot> out;
  for (int k = 0; k < k_impacts; ++k) {
    const auto u = [&](int draw) { return uniform(90 + k, draw); };
    Shot s;
    s.a.r = 0.4 + 0.2 * u(0);
    s.a.m = sphere_mass(density, s.a.r);
    s.n = {0, 0, 1};
    double sum = s.a.r;
    if (q.partner == Partner::sphere) {
      s.b.r = q.ratio > 0 ? q.ratio * s.a.r : 0.4 + 0.4 * u(1);
      s.b.m = sphere_mass(density, s.b.r);
      s.n = direction(50 + k, 0);
      sum = s.a.r + s.b.r;
    }
    const double vn = k_depth * sum, slip = q.slip * q.mu * vn, spin = q.spin * q.mu * vn;
    Vec3 t = direction(50 + k, 1);
    t = t - dot(t, s.n) * s.n;
    const Vec3 v = (-vn) * s.n + (slip * u(2) / norm(t)) * t;
    const double share = q.partner == Partner::sphere ? u(3) : 1;
    s.a.v = share * v;
    s.b.v = (share - 1) * v;
    s.a.w = (spin * u(4) / s.a.r) * direction(50 + k, 2);
    if (s.b.r > 0) s.b.w = (spin * u(5) / s.b.r) * direction(50 + k, 3);
    s.phase = q.phase < 0 ? u(6) : q.phase;
    out.push_back(s);
  }
  return out;
}

Scene scene_of(const Setting& q, double dt) {
  Scene s = open_scene({-8, -8, -8}, {8, 6.0 * k_impacts + 8, 8}, dt);
  const double r = 0.5, density = density_of(1, r), m = q.partner == Partner::sphere ? 0.5 : 1;
  s.materials[0].density = density;
  if (q.hertz) {
    const double vn = 2 * r * k_depth, depth = vn / 2.9432751, k = 1.25 * m * vn * vn / std::pow(depth, 2.5);
    s.materials[0].poisson = 0.25;
    s.materials[0].young = (q.partner == Partner::sphere ? 2 : 1) * 0.75 * k / std::sqrt(0.25) * (1 - 0.0625);
    s.materials.push_back(s.materials[0]);
    s.materials[1].name = "rigid";
    s.materials[1].young *= 1e9;
    hertz_law(s, q.e, q.mu);
    s.contact.partial_slip = q.partial_slip;
  } else {
    const double kn = m * k_pi * k_pi, kt = 2.0 / 7.0 * 0.8 * kn;
    linear_restitution(s, kn, q.e, kt, q.mu);
    s.contact.tangential_damping = 2 * q.damping * std::sqrt(kt / (3.5 * m));
  }
  s.contact.friction = true;
  if (q.balanced) s.contact.sliding = Sliding::balanced;
  s.allow_unstable_step = true;  // 20 steps are near the limit of a packing
  if (q.moments) {
    s.contact.rolling = Rolling::epsd;
    s.contact.twisting = true;
    for (PairCoefficients& p : s.pairs) {
      p.rolling_friction = 0.2;
      p.rolling_damping = 0.3;
      p.twisting_friction = 0.1;
      p.twisting_damping = 0.3;
    }
  }
  const int material = q.hertz ? 1 : 0;
  if (q.partner == Partner::plane) s.walls.push_back(plane("floor", {0, 0, 0}, {0, 0, 1}, material));
  if (q.partner == Partner::mesh) {
    WallSpec w;
    w.shape = WallShape::mesh;
    w.name = "floor";
    w.file = physics::flat_mesh(-7, 7, -7, 6.0 * k_impacts + 7, 31, 47);
    w.material = material;
    s.walls.push_back(w);
  }
  return s;
}

ObliqueLaw law_of(const Scene& s, const Setting& q, const Shot& shot) {
  ObliqueLaw law;
  law.hertz = q.hertz;
  law.partial_slip = q.partial_slip;
  const int other = q.partner == Partner::sphere ? 0 : q.hertz ? 1 : 0;
  const PairCoefficients& c = s.pair(0, other);
  law.mu = q.mu;
  const double m = shot.b.r > 0 ? shot.a.m * shot.b.m / (shot.a.m + shot.b.m) : shot.a.m;
  if (q.hertz) {
    const Material &a = s.materials[0], &b = s.materials[static_cast<std::size_t>(other)];
    const double star = (1 - a.poisson * a.poisson) / a.young + (1 - b.poisson * b.poisson) / b.young;
    const double shear =
        2 * (1 + a.poisson) * (2 - a.poisson) / a.young + 2 * (1 + b.poisson) * (2 - b.poisson) / b.young;
    law.kn = 4.0 / 3.0 / star;
    law.kt = 8 / shear;
    law.gn = -std::sqrt(5.0) * std::log(q.e) / std::sqrt(k_pi * k_pi + std::log(q.e) * std::log(q.e));
    law.gt = std::sqrt(2.0 / 3.0) * law.gn;
  } else {
    law.kn = s.contact.normal_stiffness;
    law.kt = s.contact.tangential_stiffness;
    law.gn = 2 * damping_ratio(q.e) * std::sqrt(law.kn / m);
    law.gt = s.contact.tangential_damping;
  }
  if (q.moments) {
    law.rolling = c.rolling_friction;
    law.viscous = c.rolling_damping;
    law.twisting = c.twisting_friction;
    law.torsion = c.twisting_damping;
  }
  return law;
}

/// Velocities and spins after the impacts; `sideways` [m/s] is added across the plane of normal and slip.
std::vector<ObliqueResult> run(const Setting& q, double steps, double sideways = 0, double mu = -1) {
  Scene s = scene_of(q, 1 / steps);
  if (mu >= 0)
    for (PairCoefficients& p : s.pairs) p.friction = mu;
  std::vector<Grain> grains;
  const std::vector<Shot> all = shots(q, s.materials[0].density);
  for (int k = 0; k < k_impacts; ++k) {
    const Shot& t = all[static_cast<std::size_t>(k)];
    const double back = (1 + t.phase) / steps;
    const Vec3 v = t.a.v - t.b.v, across = cross(t.n, v);
    const Vec3 kick = sideways > 0 ? (sideways / norm(across)) * across : Vec3{};
    if (q.partner == Partner::sphere) {
      const Vec3 centre{0, 6.0 * k, 0};
      grains.push_back({centre + t.a.r * t.n - back * t.a.v, t.a.v + kick, t.a.r, t.a.w});
      grains.push_back({centre - t.b.r * t.n - back * t.b.v, t.b.v, t.b.r, t.b.w});
    } else {
      grains.push_back({Vec3{0, 6.0 * k, t.a.r} - back * t.a.v, t.a.v + kick, t.a.r, t.a.w});
    }
  }
  add_grains(s, grains);
  Simulation sim(s, options());
  sim.run(std::llround(3 * steps));
  const Frame f = sim.frame({.contacts = true});
  EXPECT_TRUE(f.contacts.empty()) << name_of(q);
  std::vector<ObliqueResult> out;
  for (std::size_t k = 0; k < k_impacts; ++k) {
    if (q.partner == Partner::sphere)
      out.push_back({f.v[2 * k], f.w[2 * k], f.v[2 * k + 1], f.w[2 * k + 1]});
    else
      out.push_back({f.v[k], f.w[k], {}, {}});
  }
  return out;
}

/// Largest difference of velocities and surface speeds over the impact speed.
double difference(const Setting& q, const std::vector<ObliqueResult>& x, const std::vector<ObliqueResult>& y) {
  const std::vector<Shot> all = shots(q, scene_of(q, 1).materials[0].density);
  double worst = 0;
  for (std::size_t k = 0; k < k_impacts; ++k) {
    const Shot& t = all[k];
    worst = std::max(worst, std::max({norm(x[k].va - y[k].va), norm(x[k].vb - y[k].vb), t.a.r * norm(x[k].wa - y[k].wa),
                                      t.b.r * norm(x[k].wb - y[k].wb)}) /
                                norm(t.a.v - t.b.v));
  }
  return worst;
}

std::vector<ObliqueResult> exact(const Setting& q) {
  const Scene s = scene_of(q, 1);
  std::vector<ObliqueResult> out;
  for (const Shot& t : shots(q, s.materials[0].density))
    out.push_back(oblique_reference(law_of(s, q, t), t.a, t.b, t.n, 1, q.moments ? 60000 : 20000));
  return out;
}

double energy(const Shot& t, const ObliqueResult& r) {
  const auto of = [](const Body& b, Vec3 v, Vec3 w) {
    return b.r > 0 ? 0.5 * b.m * (dot(v, v) + 0.4 * b.r * b.r * dot(w, w)) : 0.0;
  };
  return of(t.a, r.va, r.wa) + of(t.b, r.vb, r.wb);
}

struct Errors {
  double n20, n50, n200, n1000, fine, slope;
};

/// `floor`: what the reference itself is worth.
Errors check(const Setting& q, double floor = 2e-6) {
  const std::vector<ObliqueResult> reference = exact(q);
  const std::vector<Shot> all = shots(q, scene_of(q, 1).materials[0].density);
  Errors e{};
  const double steps[] = {20, 50, 200, 1000, 10000};
  double* const to[] = {&e.n20, &e.n50, &e.n200, &e.n1000, &e.fine};
  std::vector<ObliqueResult> now;
  for (int k = 0; k < 5; ++k) {
    now = run(q, steps[k]);
    *to[k] = difference(q, now, reference);
    for (std::size_t p = 0; p < k_impacts; ++p) {
      const double before = energy(all[p], {all[p].a.v, all[p].a.w, all[p].b.v, all[p].b.w});
      // without damping the energy after an impact depends on the phase of the touch, by the square of the step
      EXPECT_LT(energy(all[p], now[p]) / before - 1, 0.5 / (steps[k] * steps[k]) + 1e-9) << name_of(q) << steps[k];
    }
  }
  e.slope = log_slope({1 / 20.0, 1 / 50.0, 1 / 200.0, 1e-3, 1e-4}, {e.n20, e.n50, e.n200, e.n1000, e.fine});
  const double moved = difference(q, run(q, 10000, 1e-12), now);
  std::printf(
      "figure: oblique, %-44s error at N = 20, 50, 200, 1000, 10000: %.1e %.1e %.1e %.1e %.1e order %.2f, "
      "sideways 1e-12 -> %.1e\n",
      name_of(q).c_str(), e.n20, e.n50, e.n200, e.n1000, e.fine, e.slope, moved * 0.02);
  EXPECT_LT(moved, 1e-9) << name_of(q);
  EXPECT_LT(e.n1000, e.n200) << name_of(q);
  EXPECT_LT(e.n200, std::max(e.n20, e.n50)) << name_of(q);
  // Weak damping: the first steps are better than their order, so the last decade counts. Rolling: the published law
  // cuts its dashpot off at the limit, a jump that no step resolves better than to first order.
  if (e.fine > floor) {
    EXPECT_GE(std::max(e.slope, std::log10(e.n1000 / e.fine)), 0.9) << name_of(q);
  }
  return e;
}

void sweep(bool hertz, Partner partner, bool moments, const std::vector<double>& restitution) {
  double n20 = 0, n50 = 0;
  for (const double e : restitution)
    for (const double damping : hertz     ? std::vector<double>{0}
                                : moments ? std::vector<double>{0.02, 0.3}
                                          : std::vector<double>{0, 0.02, 0.3, 1})
      for (const double mu : {0.05, 0.3, 1.0}) {
        const Errors r = check({hertz, e, damping, mu, partner, moments});
        n20 = std::max(n20, r.n20);
        n50 = std::max(n50, r.n50);
      }
  figure("oblique: largest error of these at N = 20", n20);
  figure("oblique: largest error of these at N = 50", n50);
  if (moments) {
    EXPECT_LT(n20, 0.02);
  }
}

TEST(Oblique, LinearSpheresConverge) { sweep(false, Partner::sphere, false, {1, 0.8, 0.5, 0.3}); }
TEST(Oblique, HertzSpheresConverge) { sweep(true, Partner::sphere, false, {1, 0.8, 0.5, 0.3}); }
TEST(Oblique, PartialSlipConverges) {
  for (const double e : {1.0, 0.5})
    for (const double mu : {0.05, 1.0}) check({true, e, 0, mu, Partner::sphere, false, true});
}
TEST(Oblique, UnusualImpactsConverge) {
  const Partner sphere = Partner::sphere, plane = Partner::plane;
  for (const bool hertz : {false, true}) {
    check({hertz, 0.8, 0.3, 0.3, sphere, false, false, 0.5});          // half the radius: half the contact time
    check({hertz, 0.1, 0.3, 0.3, sphere});                             // hardly any rebound
    check({hertz, 0.5, 0.3, 0.3, sphere, false, false, 0, 0.01, 30});  // head-on, spinning fast
    check({hertz, 0.8, 0.3, 0.3, plane, false, false, 0, 0.5, 0});     // sticks nearly all the time
    check({hertz, 0.5, 0.3, 0.3, sphere, true, false, 0, 6, 30});      // rolls, twists and slides
  }
  check({false, 0.5, 5, 0.3, sphere});  // a tangential dashpot far above critical
  check({true, 0.3, 0, 0.3, sphere, false, true, 0.5, 2, 10});
}
TEST(Oblique, WithoutFrictionSpinsAndSlipKeepTheirBits) {
  for (const bool hertz : {false, true})
    for (const double e : {1.0, 0.5}) {
      Setting q{hertz, e, 0.3, 0.3, Partner::plane};
      const std::vector<Shot> all = shots(q, scene_of(q, 1).materials[0].density);
      const std::vector<ObliqueResult> now = run(q, 20, 0, 0);
      for (std::size_t k = 0; k < k_impacts; ++k) {
        EXPECT_EQ(now[k].wa.x, all[k].a.w.x) << name_of(q);
        EXPECT_EQ(now[k].wa.z, all[k].a.w.z) << name_of(q);
        EXPECT_EQ(now[k].va.x, all[k].a.v.x) << name_of(q);
        EXPECT_NEAR(now[k].va.z, -e * all[k].a.v.z, 2e-3 * std::fabs(all[k].a.v.z)) << name_of(q);
      }
    }
}
TEST(Oblique, AContactThatSlidesForPartOfAStepSticksWithWhatItHasMoved) {
  // A weak dashpot makes a contact slide at touch for less than a step: the error did not fall from N = 20 to 50.
  double weak = 0;
  for (const double mu : {0.05, 0.3, 1.0}) weak = std::max(weak, check({false, 0.8, 0.02, mu}).n50);
  figure("oblique: weak tangential damping, largest error at N = 50", weak);
  EXPECT_LT(weak, 1.5e-3);
}
TEST(Oblique, TheBalancedSliderDoesNotDependOnThePhase) {
  // There is no limit at touch, so the spring takes the dashpot at once. Without that it does so at the first step, if
  // it still slides there.
  double worst = 0;
  for (const double e : {1.0, 0.8})
    for (const double mu : {0.3, 1.0}) {
      Setting q{false, e, 0.3, mu};
      q.balanced = true;
      const std::vector<ObliqueResult> limit = run(q, 10000);
      for (int k = 0; k < 20; ++k) {
        q.phase = (k + 0.5) / 20;
        worst = std::max(worst, difference(q, run(q, 50), limit));
      }
    }
  figure("oblique: balanced slider, largest error over phases at N = 50", worst);
  EXPECT_LT(worst, 2e-3);
}
TEST(Oblique, ElasticImpactsAtTwentyStepsHardlyDependOnThePhase) {
  // They slide from touch to parting: the error is that of the normal impulse. 3e-3 without weighing its ends.
  double worst = 0;
  Setting q{false, 1, 0, 0.02};
  const std::vector<ObliqueResult> reference = exact(q);
  for (int k = 0; k < 20; ++k) {
    q.phase = (k + 0.5) / 20;
    worst = std::max(worst, difference(q, run(q, 20.5), reference));
  }
  figure("oblique: elastic and sliding, largest error over phases at N = 20.5", worst);
  EXPECT_LT(worst, 3e-4);
}
TEST(Oblique, SphereOnPlaneConverges) {
  sweep(false, Partner::plane, false, {0.5});
  sweep(true, Partner::plane, false, {0.5});
}
TEST(Oblique, SphereOnMeshReboundsAsOnThePlane) {
  for (const bool hertz : {false, true})
    for (const double mu : {0.05, 1.0}) {
      const Setting plane{hertz, 0.5, 0.3, mu, Partner::plane, false}, mesh{hertz, 0.5, 0.3, mu, Partner::mesh, false};
      for (const double steps : {20.0, 200.0, 10000.0})
        EXPECT_LT(difference(plane, run(mesh, steps), run(plane, steps)), 1e-12) << name_of(mesh) << steps;
    }
}
TEST(Oblique, RollingAndTwistingConverge) {
  sweep(false, Partner::sphere, true, {0.5});
  sweep(true, Partner::sphere, true, {0.5});
}

}  // namespace
}  // namespace talus::verification
