// Free rotation, kicks and elastic collisions of rigid bodies.
#include "core/shapes/rigid_motion.hpp"

#include <gtest/gtest.h>

#include "tests/shapes/shape_support.hpp"

namespace talus::shapes {
namespace {
using testing::Draw;

double distance(Quaternion a, Quaternion b) {  // q and -q are one orientation
  const double d = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
  return std::sqrt(std::max(0.0, 2 - 2 * std::fabs(d)));
}

RigidState spinning(Vec3 moments, Vec3 w) {
  RigidState s;
  s.turn = normalised({0.3, -0.5, 0.2, 0.7});
  s.l = {moments.x * w.x, moments.y * w.y, moments.z * w.z};
  return s;
}

RigidState after(RigidState s, const Rotor& rotor, double time, int steps) {
  for (int k = 0; k < steps; ++k) drift(s, rotor, time / steps);
  return s;
}

TEST(RigidMotion, FreeRotationIsOfOrderTwo) {
  const Vec3 moments{1, 2, 2.7};
  const Rotor rotor = make_rotor(moments);
  const RigidState s = spinning(moments, {0.4, 3, 0.1});
  const RigidState exact = after(s, rotor, 10, 1 << 16);
  double last = 0;
  for (int steps = 256; steps <= 2048; steps *= 2) {
    const double error = distance(after(s, rotor, 10, steps).turn, exact.turn);
    EXPECT_TRUE(last == 0 || std::fabs(std::log2(last / error) - 2) < 0.1) << steps;
    last = error;
  }
}

TEST(RigidMotion, AnAxisymmetricBodyTurnsWithoutError) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 moments{2, 2, 2};
    moments[axis] = 0.5;
    const Rotor rotor = make_rotor(moments);
    const RigidState s = spinning(moments, {1, -2, 3});
    EXPECT_LT(distance(after(s, rotor, 7, 3).turn, after(s, rotor, 7, 1000).turn), 1e-7) << axis;
    EXPECT_LT(norm(after(s, rotor, 7, 3).l - after(s, rotor, 7, 1000).l), 1e-12);
  }
}

TEST(RigidMotion, AThrownTBarFlipsAndKeepsEnergyAndAngularMomentumOverAMillionSteps) {
  const Vec3 moments{1, 2, 2.7};
  const Rotor rotor = make_rotor(moments);
  RigidState s = spinning(moments, {1e-3, 5, 1e-3});  // about the middle axis: unstable
  const Vec3 l0 = angular_momentum(s);
  const double e0 = rotation_energy(s, rotor);
  double de = 0;
  int flips = 0;
  bool up = true;
  for (int k = 0; k < 1000000; ++k) {
    drift(s, rotor, 1e-2);
    de = std::max(de, std::fabs(rotation_energy(s, rotor) / e0 - 1));
    if (up ? s.l.y < -9 : s.l.y > 9) up = !up, ++flips;
  }
  std::printf("T-bar: %d flips, |dE|/E %.1e, |dL|/L %.1e\n", flips, de, norm(angular_momentum(s) - l0) / norm(l0));
  EXPECT_GT(flips, 100);
  EXPECT_LT(de, 1e-3);  // bounded, of order dt^2
  EXPECT_LT(norm(angular_momentum(s) - l0), 1e-10 * norm(l0));
}

TEST(RigidMotion, RunsBackwardsToWhereItCameFrom) {
  const Vec3 moments{1, 2, 2.7};
  const Rotor rotor = make_rotor(moments);
  const RigidState s = spinning(moments, {3, 5, -2});
  RigidState t = s;
  for (int k = 0; k < 1000; ++k) drift(t, rotor, 0.03);
  for (int k = 0; k < 1000; ++k) drift(t, rotor, -0.03);
  EXPECT_LT(distance(t.turn, s.turn), 1e-7);
  EXPECT_LT(norm(t.l - s.l), 1e-11);
}

TEST(RigidMotion, SpinningAt100000RadiansPerSecondKeepsEnergyAndAngularMomentum) {
  const Vec3 moments{1e-9, 2e-9, 2.7e-9};
  const Rotor rotor = make_rotor(moments);
  RigidState s = spinning(moments, {4e4, 8e4, 4.5e4});
  const double e0 = rotation_energy(s, rotor);
  const Vec3 l0 = angular_momentum(s);
  double de = 0;
  for (int k = 0; k < 200000; ++k) {
    drift(s, rotor, 1e-6);  // 0.1 rad a step
    de = std::max(de, std::fabs(rotation_energy(s, rotor) / e0 - 1));
  }
  std::printf("1e5 rad/s: |dE|/E %.1e, |dL|/L %.1e\n", de, norm(angular_momentum(s) - l0) / norm(l0));
  EXPECT_LT(de, 2e-3);
  EXPECT_LT(norm(angular_momentum(s) - l0), 1e-11 * norm(l0));
}

/// Impulse of a frictionless contact in one point, e = 1, against integration through a stiff spring.
TEST(RigidMotion, AnEllipsoidLeavesAPlaneAsItsImpulseSays) {
  const Superquadric shape{{2, 1, 1}, 2, 2};  // long along x; turned about y
  const double mass = volume(shape);
  const Vec3 i = inertia(shape);
  const Rotor rotor = make_rotor(i);
  RigidState s;
  s.turn = normalised({std::cos(M_PI / 8), 0, std::sin(M_PI / 8), 0});
  const auto depth = [&] { return support_point(shape, to_body(rotation(s.turn), {0, 0, -1})).h - s.x.z; };
  s.x.z = depth() + 1e-9;
  s.v = {0, 0, -1};
  const double k = 1e8, dt = 1e-7;
  const auto force = [&](double share) {
    const double d = depth();
    if (!(d > 0)) return;
    const SupportPoint p = support_point(shape, to_body(rotation(s.turn), {0, 0, -1}));
    const Vec3 arm = to_space(rotation(s.turn), p.point), f{0, 0, k * d};
    kick(s, 1 / mass, f, cross(arm, f), share * dt);
  };
  for (int step = 0; step < 40000 && !(step > 100 && depth() < 0); ++step) {
    force(0.5);
    drift(s, rotor, dt);
    force(0.5);
  }
  EXPECT_NEAR(s.v.z, 0.052632, 3e-4);  // - 1 + J / m, J = 2 / (1 / m + (r x n)^2 / I), arm 0.948683, I = m
  EXPECT_NEAR(std::fabs(angular_velocity(s, rotor).y), 0.998614, 3e-4);
  EXPECT_NEAR(0.5 * mass * norm2(s.v) + rotation_energy(s, rotor), 0.5 * mass, 1e-6 * mass);
}

struct Collision {
  bool touched = false;
  double momentum, angular, energy;  ///< relative errors
};

/// Two superquadrics collide elastically with a constant stiffness; t_c / dt steps in the contact.
Collision collide(std::uint64_t seed, int steps_per_contact) {
  Draw draw(seed);
  Superquadric shape[2];
  RigidState s[2];
  Rotor rotor[2];
  double mass[2], round[2];
  for (int b = 0; b < 2; ++b) {
    shape[b] = draw.shape(2, 4, 2);
    mass[b] = volume(shape[b]);
    rotor[b] = make_rotor(inertia(shape[b]));
    round[b] = smallest_radius(shape[b]);
    s[b].turn = draw.turn();
  }
  const Vec3 aim = draw.direction();
  const double reach = bounding_radius(shape[0]) + bounding_radius(shape[1]);
  s[1].x = (reach + 0.31) * aim + 0.3 * draw.direction();
  s[0].v = aim;
  s[0].l = 0.1 * mass[0] * draw.direction();
  const double effective = mass[0] * mass[1] / (mass[0] + mass[1]), tc = 1e-3 * M_PI, k = effective / 1e-6;
  const double dt = tc / steps_per_contact;
  PairMemory memory;
  PairCount count;
  PairContact c;
  Collision result;
  const auto force = [&](double share) {
    const double d = fmax2(c.overlap, 0);
    const Vec3 f = (k * d) * c.normal;
    kick(s[0], 1 / mass[0], -f, cross(c.point - s[0].x, -f), share * dt);
    kick(s[1], 1 / mass[1], f, cross(c.point - s[1].x, f), share * dt);
  };
  const auto look = [&] {
    c = solve_pair(make_body(shape[0], round[0], s[0].x, s[0].turn), make_body(shape[1], round[1], s[1].x, s[1].turn),
                   memory, count);
  };
  const auto momentum = [&] { return mass[0] * s[0].v + mass[1] * s[1].v; };
  const auto angular = [&] {
    return (cross(s[0].x, mass[0] * s[0].v) + angular_momentum(s[0])) +
           (cross(s[1].x, mass[1] * s[1].v) + angular_momentum(s[1]));
  };
  const auto energy = [&] {
    double e = 0;
    for (int b = 0; b < 2; ++b) e += 0.5 * mass[b] * norm2(s[b].v) + rotation_energy(s[b], rotor[b]);
    return e;
  };
  const Vec3 p0 = momentum(), l0 = angular();
  const double e0 = energy();
  look();
  while (dot(s[1].x - s[0].x, aim) > 0) {
    const double stride = c.overlap < -0.02 ? 0.004 : dt;  // nothing moves faster than 2
    force(0.5);
    for (int b = 0; b < 2; ++b) drift(s[b], rotor[b], stride);
    look();
    force(0.5);
    if (result.touched && !(c.overlap > 0)) break;
    result.touched = result.touched || c.overlap > 0;
  }
  result.momentum = norm(momentum() - p0) / norm(p0);
  result.angular = norm(angular() - l0) / (norm(l0) + reach * norm(p0));
  result.energy = std::fabs(energy() / e0 - 1);
  return result;
}

TEST(RigidMotion, ElasticCollisionsOfRandomPairsConserveMomentumAndEnergyToOrderTwo) {
  double energy[2] = {0, 0}, momentum = 0, angular = 0;
  int collisions = 0;
  const int steps[2] = {300, 1200};
  for (int pair = 0; pair < 25; ++pair)
    for (int fine = 0; fine < 2; ++fine) {
      const Collision c = collide(100 + pair, steps[fine]);
      if (!c.touched) continue;
      collisions += fine;
      momentum = std::max(momentum, c.momentum);
      angular = std::max(angular, c.angular);
      energy[fine] = std::max(energy[fine], c.energy);
    }
  std::printf(
      "%d elastic collisions: momentum %.1e, angular momentum %.1e, energy %.1e at t_c/dt = 300, %.1e at 1200\n",
      collisions, momentum, angular, energy[0], energy[1]);
  EXPECT_GT(collisions, 15);
  EXPECT_LT(momentum, 1e-12);
  EXPECT_LT(angular, 1e-12);
  // A linear spring that begins within a step leaves up to (pi dt / t_c)^2 / 4, as it does between spheres.
  EXPECT_LT(energy[0], std::pow(M_PI / 300, 2) / 4);
  EXPECT_LT(energy[1], std::pow(M_PI / 1200, 2) / 4);
}

}  // namespace
}  // namespace talus::shapes
