// Bodies of initial files: what a row says of them, and their spheres. Who calls it: core/grains/insertion_file.cpp.
#include <fmt/format.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/grains/insertion.hpp"
#include "core/grains/occupied.hpp"
#include "core/tables/particle_file.hpp"

namespace talus {

/// Rows of the file become particles; those that are bodies, their spheres.
void Insertion::take_rows(std::size_t s, const std::string& path, ParticleFile& file) {
  NewParticles& p = files_[s];
  std::vector<std::int64_t>& line = rows_[s];
  if (file.shape.empty()) {
    p.x = std::move(file.x);
    p.v = std::move(file.v);
    p.w = std::move(file.w);
    p.r = std::move(file.r);
    line = std::move(file.row);
    return;
  }
  NewParticles all;
  for (std::size_t i = 0; i < file.size(); ++i) {
    std::size_t count = 1;
    if (file.shape[i] >= 0) {
      NewBody b = body_of_row(path, file, i, p.material[i]);
      b.first = static_cast<std::int32_t>(all.size());
      b.fixed = p.fixed[i] != 0;
      count = static_cast<std::size_t>(b.count);
      for (const shapes::SubSphere& part : shape_of(b).spheres) all.r.push_back(b.scale * part.r);
      all.bodies.push_back(b);
    } else {
      all.r.push_back(file.r[i]);
    }
    const auto append = [count](auto& to, const auto& value) { to.insert(to.end(), count, value); };
    append(all.x, file.x[i]);
    append(all.v, file.v[i]);
    append(all.w, file.w[i]);
    append(all.material, p.material[i]);
    append(all.fixed, p.fixed[i]);
    append(all.group, p.group[i]);
    append(line, file.row[i]);
    if (all.size() > (std::size_t{1} << 30))
      throw Error(ErrorCode::scene, "more than 2^30 particles", fmt::format("{}:{}", path, file.row[i]));
    if (file.shape[i] >= 0) place_spheres(all.bodies.back(), all);
  }
  p = std::move(all);
}

NewBody Insertion::body_of_row(const std::string& path, const ParticleFile& file, std::size_t i, int material) const {
  NewBody b;
  b.shape = file.shape[i];
  const BodyShape& shape = shape_of(b);
  const double by_radius = file.r[i] / shape.equal_radius;
  b.scale = file.scale[i] > 0 ? file.scale[i] : by_radius;
  if (file.scale[i] > 0 && by_radius > 0 && !(std::fabs(by_radius - b.scale) <= 2e-4 * b.scale))
    throw Error(ErrorCode::scene,
                fmt::format("scale {} is not that of radius {}, which is {:.6g}", b.scale, file.r[i], by_radius),
                fmt::format("{}:{}", path, file.row[i]),
                "give one of them; radius is that of the sphere of equal volume");
  b.count = static_cast<std::int32_t>(shape.spheres.size());
  b.mass = shape.mass(scene_.materials[static_cast<std::size_t>(material)], b.scale);
  b.x = file.x[i];
  b.v = file.v[i];
  b.w = file.w[i];
  const auto& q = file.turn[i];
  b.turn = shapes::normalised(shapes::Quaternion{q[0], q[1], q[2], q[3]} * shape.turn);
  const shapes::Rotation to = shapes::rotation(b.turn);
  for (const shapes::SubSphere& part : shape.spheres) {
    const Vec3 x = b.x + shapes::to_space(to, b.scale * part.x);
    for (int k = 0; k < 3; ++k) {
      const auto& sides = scene_.domain.boundary[static_cast<std::size_t>(k)];
      const bool below = sides[0] == Boundary::wall && x[k] < scene_.domain.lower[k],
                 above = sides[1] == Boundary::wall && x[k] > scene_.domain.upper[k];
      if (!below && !above) continue;
      throw Error(ErrorCode::scene,
                  fmt::format("the body reaches through a side of the domain, to {} = {}", "xyz"[k], x[k]),
                  fmt::format("{}:{}", path, file.row[i]),
                  fmt::format("allowed: {} to {}", scene_.domain.lower[k], scene_.domain.upper[k]));
    }
  }
  return b;
}

void Insertion::place_spheres(const NewBody& b, NewParticles& p) const {
  const shapes::Rotation to = shapes::rotation(b.turn);
  auto i = static_cast<std::size_t>(b.first);
  for (const shapes::SubSphere& part : shape_of(b).spheres)
    p.x[i++] = wrapped(scene_.domain, b.x + shapes::to_space(to, b.scale * part.x));
}

}  // namespace talus
