// Batches of bodies: every instruction set gives the bits of one body that moves alone.
#include "kernels/bodies/motion_batch.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <memory>
#include <vector>

#include "core/shapes/rigid_motion.hpp"
#include "kernels/kernel_table.hpp"
#include "tests/shapes/shape_support.hpp"

namespace talus::shapes {
namespace {
using testing::Draw;

constexpr double k_step = 1e-4;
const Vec3 k_gravity{0.3, -0.2, -9.81};

/// A body and what acts on it; `expected` is what the motion leaves, number by number.
struct Body {
  RigidState s;
  Rotor rotor;
  double scale = 1, mass = 1;
  std::vector<Vec3> place, force, torque;
  std::vector<double> radius;

  std::vector<double> expected() const {
    RigidState now = s;
    const double inertia = 1 / (mass * (scale * scale));
    const Vec3 inverse = inertia * rotor.inverse;
    const Rotation before = rotation(s.turn);
    Vec3 sum, moment;
    double stiffness = 0;
    for (std::size_t k = 0; k < place.size(); ++k) {
      sum = sum + force[k];
      moment = moment + cross(to_space(before, scale * place[k]), force[k]);
      moment = moment + (scale * radius[k]) * torque[k];
      stiffness = stiffness + radius[k];
    }
    const auto spin = [&](const Rotation& r) {
      return to_space(r, {now.l.x * inverse.x, now.l.y * inverse.y, now.l.z * inverse.z});
    };
    now.v = now.v + k_step * ((1 / mass) * sum) + k_step * k_gravity;
    now.l = now.l + k_step * to_body(before, moment);
    const Vec3 first = spin(before);
    rotate(now.turn, now.l, rotor, k_step * inertia);
    const Rotation after = rotation(now.turn);
    now.x = now.x + k_step * now.v;
    std::vector<double> out{now.turn.w, now.turn.x, now.turn.y, now.turn.z, stiffness * (1 / mass)};
    const auto put = [&out](Vec3 v) { out.insert(out.end(), {v.x, v.y, v.z}); };
    put(now.x), put(now.v), put(now.l), put(0.5 * (first + spin(after)));
    for (const Vec3 p : place) {
      const Vec3 arm = to_space(after, scale * p);
      put(now.x + arm);
      put(now.v + (1 / k_step) * (arm - to_space(before, scale * p)));
    }
    return out;
  }
};

/// Three kinds of inertia: all moments different (in every order of the axes), a body of revolution, a ball.
Body drawn(Draw& draw, int kind, double spin) {
  Body b;
  Vec3 moments{1, 1, 1};
  if (kind < 6)
    moments = {1 + 0.3 * (kind % 3), 1 + 0.3 * ((kind + 1 + kind / 3) % 3), 1 + 0.3 * ((kind + 2 - kind / 3) % 3)};
  if (kind == 6) moments = {1.7, 1.7, 0.9};
  b.rotor = make_rotor(1e-6 * moments);
  b.scale = draw.uniform(0.5, 2);
  b.mass = draw.uniform(1e-6, 1e-4);
  const auto any = [&](double size) {
    return Vec3{draw.uniform(-size, size), draw.uniform(-size, size), draw.uniform(-size, size)};
  };
  b.s.x = any(1), b.s.v = any(2);
  b.s.turn = normalised({draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(0.1, 1)});
  b.s.l = (b.mass * b.scale * b.scale * 1e-6) * any(spin);
  for (int k = 0; k < 1 + kind % 4; ++k) {
    b.place.push_back(any(1e-3)), b.force.push_back(any(1e-3)), b.torque.push_back(any(1e-3));
    b.radius.push_back(draw.uniform(1e-4, 1e-3));
  }
  return b;
}

void enter(MotionBatch& to, int lane, const Body& b) {
  const auto put = [lane](MotionBatch::Lane* at, Vec3 v) { at[0][lane] = v.x, at[1][lane] = v.y, at[2][lane] = v.z; };
  put(to.x, b.s.x), put(to.v, b.s.v), put(to.spin, b.s.l), put(to.inverse, b.rotor.inverse);
  to.turn[0][lane] = b.s.turn.w, to.turn[1][lane] = b.s.turn.x, to.turn[2][lane] = b.s.turn.y,
  to.turn[3][lane] = b.s.turn.z;
  to.scale[lane] = b.scale, to.mass[lane] = b.mass, to.inverse_mass[lane] = 1 / b.mass;
  to.reference[lane] = b.rotor.reference, to.extra_p[lane] = b.rotor.extra_p, to.extra_q[lane] = b.rotor.extra_q;
  to.axis_p[lane] = b.rotor.p, to.axis_q[lane] = b.rotor.q;
  for (std::size_t k = 0; k < b.place.size(); ++k) {
    MotionBatch::Sphere& one = to.sphere[k];
    put(one.place, b.place[k]), put(one.force, b.force[k]), put(one.torque, b.torque[k]);
    one.radius[lane] = one.stiffness[lane] = b.radius[k];
  }
  to.spheres = std::max(to.spheres, static_cast<std::int32_t>(b.place.size()));
}

std::vector<double> left(const MotionBatch& from, int lane, std::size_t spheres) {
  std::vector<double> out;
  for (const auto& q : from.turn) out.push_back(q[lane]);
  out.push_back(from.row[lane]);
  const auto take = [&](const MotionBatch::Lane* at) {
    for (int k = 0; k < 3; ++k) out.push_back(at[k][lane]);
  };
  take(from.x), take(from.v), take(from.spin), take(from.angular_velocity);
  for (std::size_t k = 0; k < spheres; ++k) take(from.sphere[k].at), take(from.sphere[k].velocity);
  return out;
}

std::unique_ptr<MotionBatch> moved(const std::vector<Body>& bodies, const char* isa) {
  auto batch = std::make_unique<MotionBatch>();
  batch->bodies = static_cast<std::int32_t>(bodies.size());
  batch->rotation = 1;
  batch->dt = batch->kick = k_step;
  batch->per_step = 1 / k_step;
  for (int k = 0; k < 3; ++k) batch->gravity[k] = k_gravity[k];
  for (std::size_t k = 0; k < bodies.size(); ++k) enter(*batch, static_cast<int>(k), bodies[k]);
  body_mover(isa)(*batch);
  return batch;
}

TEST(MotionBatch, EveryInstructionSetGivesTheBitsOfOneBodyAlone) {
  Draw draw(7);
  for (int round = 0; round < 60; ++round) {
    std::vector<Body> bodies;
    const int n = 1 + round % MotionBatch::k_bodies;  // not whole batches only
    for (int k = 0; k < n; ++k) bodies.push_back(drawn(draw, (round + k) % 8, 300));
    for (const Isa isa : available_isas()) {
      const auto batch = moved(bodies, isa_name(isa));
      for (int k = 0; k < n; ++k) {
        const Body& b = bodies[static_cast<std::size_t>(k)];
        const std::vector<double> want = b.expected(), is = left(*batch, k, b.place.size());
        ASSERT_EQ(batch->wide[k], 0) << isa_name(isa);
        ASSERT_EQ(want.size(), is.size());
        for (std::size_t q = 0; q < want.size(); ++q)
          ASSERT_EQ(std::bit_cast<std::uint64_t>(want[q]), std::bit_cast<std::uint64_t>(is[q]))
              << isa_name(isa) << ", number " << q << ", kind " << (round + k) % 8;
      }
    }
  }
}

TEST(MotionBatch, BodiesThatTurnFarAreHandedBack) {
  Draw draw(8);
  std::vector<Body> bodies;
  for (int k = 0; k < 8; ++k) bodies.push_back(drawn(draw, k, 10));
  bodies[2].s.l = 1e5 / 50 * bodies[2].s.l;        // more than 1/4 rad per step
  bodies[5].force[0].x = std::nan("");             // nothing is known of its turn
  bodies[6].s.turn.w = bodies[6].s.turn.w + 1e-3;  // not of length 1
  for (const Isa isa : available_isas()) {
    const auto batch = moved(bodies, isa_name(isa));
    for (int k = 0; k < 8; ++k)
      EXPECT_EQ(batch->wide[k], k == 2 || k == 5 || k == 6 ? 1 : 0) << isa_name(isa) << ", body " << k;
  }
}

}  // namespace
}  // namespace talus::shapes
