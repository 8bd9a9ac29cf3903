// Frames as PolyData; see poly_data.hpp.
#include "core/io/poly_data.hpp"

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"

namespace talus {

namespace {

std::vector<double> flat(const std::vector<Vec3>& v) {
  std::vector<double> out;
  out.reserve(3 * v.size());
  for (const Vec3& a : v) out.insert(out.end(), {a.x, a.y, a.z});
  return out;
}

template <class T>
void require(const std::vector<T>& column, std::size_t n, const char* name) {
  if (column.size() != n)
    throw Error(ErrorCode::io,
                std::string("frame has ") + std::to_string(column.size()) + " values of '" + name + "' for " +
                    std::to_string(n) + " particles",
                "output", "request this column from the simulation");
}

}  // namespace

ParticleColumns ParticleColumns::of(const Scene& scene) {
  ParticleColumns c;
  c.omega = scene.contact.friction;
  c.material = scene.materials.size() > 1;
  for (const Event& e : scene.events)
    c.fixed = c.fixed || e.action == Event::Action::freeze || e.action == Event::Action::drive;
  for (const GroupSpec& g : scene.groups) c.fixed = c.fixed || g.fixed_in_file;
  c.coordination = scene.output.coordination;
  c.stress = scene.output.stress;
  return c;
}

PolyData particle_poly(const Frame& frame, const ParticleColumns& columns) {
  const std::size_t n = frame.x.size();
  require(frame.id, n, "id");
  require(frame.v, n, "velocity");
  require(frame.r, n, "radius");
  PolyData p;
  p.points = frame.x;
  p.vertices = true;
  p.point_data.push_back({"id", 1, std::vector<std::int64_t>(frame.id.begin(), frame.id.end())});
  p.point_data.push_back({"velocity", 3, flat(frame.v)});
  p.point_data.push_back({"radius", 1, frame.r});
  std::vector<double> diameter(frame.r);
  for (double& d : diameter) d *= 2;
  p.point_data.push_back({"diameter", 1, std::move(diameter)});
  if (columns.omega) {
    require(frame.w, n, "omega");
    p.point_data.push_back({"omega", 3, flat(frame.w)});
  }
  if (columns.material) {
    require(frame.material, n, "material");
    p.point_data.push_back({"material", 1, frame.material});
  }
  if (columns.fixed) {
    // A frame in which nothing is fixed at present has no such column: all free.
    if (!frame.fixed.empty()) require(frame.fixed, n, "fixed");
    p.point_data.push_back({"fixed", 1, frame.fixed.empty() ? std::vector<std::uint8_t>(n, 0) : frame.fixed});
  }
  if (columns.coordination) {
    require(frame.coordination, n, "coordination");
    p.point_data.push_back({"coordination", 1, frame.coordination});
  }
  if (columns.stress) {
    require(frame.stress, n, "stress");
    std::vector<double> s;
    s.reserve(6 * n);
    for (const auto& a : frame.stress) s.insert(s.end(), {a[0], a[1], a[2], a[3], a[5], a[4]});
    p.point_data.push_back({"stress", 6, std::move(s)});
  }
  return p;
}

PolyData wall_poly(const Frame& frame) {
  PolyData p;
  std::vector<std::int32_t> wall;
  for (std::size_t w = 0; w < frame.walls.size(); ++w) {
    const auto base = static_cast<std::int32_t>(p.points.size());
    p.points.insert(p.points.end(), frame.walls[w].points.begin(), frame.walls[w].points.end());
    for (const auto& t : frame.walls[w].triangles) {
      p.triangles.push_back({base + t[0], base + t[1], base + t[2]});
      wall.push_back(static_cast<std::int32_t>(w));
    }
  }
  p.cell_data.push_back({"wall", 1, std::move(wall)});
  return p;
}

PolyData contact_poly(const Frame& frame) {
  PolyData p;
  p.vertices = true;
  std::vector<std::int64_t> a, b;
  std::vector<double> normal, tangential, overlap;
  for (const ContactRecord& c : frame.contacts) {
    p.points.push_back(c.point);
    a.push_back(c.a);
    b.push_back(c.b);
    normal.insert(normal.end(), {c.normal_force.x, c.normal_force.y, c.normal_force.z});
    tangential.insert(tangential.end(), {c.tangential_force.x, c.tangential_force.y, c.tangential_force.z});
    overlap.push_back(c.overlap);
  }
  p.point_data.push_back({"particle_a", 1, std::move(a)});
  p.point_data.push_back({"particle_b", 1, std::move(b)});
  p.point_data.push_back({"normal_force", 3, std::move(normal)});
  p.point_data.push_back({"tangential_force", 3, std::move(tangential)});
  p.point_data.push_back({"overlap", 1, std::move(overlap)});
  return p;
}

}  // namespace talus
