// See file_bodies.hpp.
#include "core/grains/file_bodies.hpp"

#include "core/grains/body_shape.hpp"

namespace talus {

FileBodies::FileBodies(const Scene& scene, const NewParticles& p) : scene_(scene), p_(p) {
  if (p.bodies.empty()) return;
  owner_.assign(p.size(), -1);
  for (std::size_t k = 0; k < p.bodies.size(); ++k)
    for (std::int32_t i = 0; i < p.bodies[k].count; ++i)
      owner_[static_cast<std::size_t>(p.bodies[k].first + i)] = static_cast<std::int32_t>(k);
}

const QuadricShape* FileBodies::quadric(std::int32_t i) const {
  const std::int32_t b = owner_[static_cast<std::size_t>(i)];
  if (b < 0) return nullptr;
  const NewBody& body = p_.bodies[static_cast<std::size_t>(b)];
  const BodyShape& shape = *scene_.shapes[static_cast<std::size_t>(body.shape)].body;
  return shape.quadric && !shape.quadric->ball ? &*shape.quadric : nullptr;
}

shapes::Body FileBodies::body(std::int32_t i, Vec3 x) const {
  const QuadricShape* q = quadric(i);
  const double r = p_.r[static_cast<std::size_t>(i)];
  if (q == nullptr) return shapes::make_body({{r, r, r}, 2, 2}, r, x, {});
  const NewBody& b = p_.bodies[static_cast<std::size_t>(owner_[static_cast<std::size_t>(i)])];
  shapes::Superquadric s = q->surface;
  s.axes = b.scale * s.axes;
  return shapes::make_body(s, b.scale * q->roundness, x, b.turn);
}

const shapes::Body* FileBodies::surface(std::int32_t i, Vec3 x) const {
  if (!any() || quadric(i) == nullptr) return nullptr;
  body_ = body(i, x);
  return &body_;
}

double FileBodies::thickness(std::int32_t i) const {
  const std::int32_t b = owner_[static_cast<std::size_t>(i)];
  if (b < 0) return p_.r[static_cast<std::size_t>(i)];
  const NewBody& body = p_.bodies[static_cast<std::size_t>(b)];
  return body.scale * scene_.shapes[static_cast<std::size_t>(body.shape)].body->smallest;
}

bool FileBodies::meet(std::int32_t i, Vec3 x, std::int32_t j, Vec3 y, double& depth, double& share) const {
  const auto a = owner_[static_cast<std::size_t>(i)], b = owner_[static_cast<std::size_t>(j)];
  if (a >= 0 && a == b) return false;
  const bool first = quadric(i) != nullptr, second = quadric(j) != nullptr;
  if (!first && !second) return true;
  shapes::PairMemory memory;
  shapes::PairCount count;
  depth = shapes::solve_pair(body(i, x), body(j, y), memory, count).overlap;
  const auto thin = [&](bool shaped, std::int32_t k) {
    return shaped ? thickness(k) : p_.r[static_cast<std::size_t>(k)];
  };
  share = depth / fmin2(thin(first, i), thin(second, j));
  return depth > 0;
}

}  // namespace talus
