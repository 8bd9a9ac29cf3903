// See body_shape.hpp.
#include "core/grains/body_shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/base/det_math.hpp"
#include "core/base/error.hpp"
#include "core/base/rng.hpp"

namespace talus {
namespace {

using shapes::Quaternion;

std::vector<shapes::SubSphere> spheres_of(const ShapeSpec& spec, const std::string& directory) {
  if (spec.spheres.empty()) {
    const std::filesystem::path file(spec.file);
    return shapes::read_clump((file.is_absolute() ? file : std::filesystem::path(directory) / file).string());
  }
  std::vector<shapes::SubSphere> all;
  for (std::size_t k = 0; k + 3 < spec.spheres.size(); k += 4)
    all.push_back({{spec.spheres[k], spec.spheres[k + 1], spec.spheres[k + 2]}, spec.spheres[k + 3]});
  return all;
}

/// Bodies have positive moments, none of which exceeds the sum of the others.
void check_moments(Vec3 m, const std::string& where) {
  const double most = fmax2(m.x, fmax2(m.y, m.z)), sum = (m.x + m.y) + m.z;
  if (fmin2(m.x, fmin2(m.y, m.z)) > 0 && most <= (sum - most) * (1 + 1e-9)) return;
  throw Error(ErrorCode::scene,
              fmt::format("no body has the principal moments of inertia {:g}, {:g}, {:g} kg m2", m.x, m.y, m.z), where,
              "all are positive, and none exceeds the sum of the others");
}

/// All mass lies within the body, so that (Ixx + Iyy + Izz) / 2 is at most m R2, and its centre within the spheres.
void check_loading(const ShapeSpec& spec, const BodyShape& body, const std::string& where) {
  if (spec.inertia.empty()) return;
  Vec3 low{k_never, k_never, k_never}, high{-k_never, -k_never, -k_never};
  const shapes::Rotation r = shapes::rotation(body.turn);
  for (const shapes::SubSphere& s : body.spheres) {
    const Vec3 x = shapes::to_space(r, s.x);
    for (int k = 0; k < 3; ++k) low[k] = fmin2(low[k], x[k] - s.r), high[k] = fmax2(high[k], x[k] + s.r);
  }
  for (int k = 0; k < 3; ++k)
    if (!(low[k] <= 0 && high[k] >= 0))
      throw Error(ErrorCode::scene,
                  fmt::format("centre ({:g}, {:g}, {:g}) lies outside of its spheres", spec.centre.x, spec.centre.y,
                              spec.centre.z),
                  where, "in the coordinates of the spheres, before any turn");
  const double sum = (body.moments.x + body.moments.y) + body.moments.z, most = body.bound * body.bound;
  if (0.5 * sum <= most * (1 + 1e-9)) return;
  throw Error(
      ErrorCode::scene,
      fmt::format("inertia: {:g} kg and all within {:g} m of the centre have moments whose sum is at most {:g} kg "
                  "m2, not {:g}",
                  spec.mass, body.bound, 2 * spec.mass * most, spec.mass * sum),
      where, "kg and m");
}

/// Without spheres that lie within others: they add no shape, but a second force wherever both are met.
std::vector<shapes::SubSphere> without_hidden(std::span<const shapes::SubSphere> all) {
  std::vector<shapes::SubSphere> seen;
  for (std::size_t j = 0; j < all.size(); ++j) {
    bool hidden = false;
    for (std::size_t i = 0; i < all.size() && !hidden; ++i) {
      const double room = all[i].r - all[j].r;
      hidden = i != j && room >= 0 && norm2(all[i].x - all[j].x) <= room * room && (room > 0 || i < j);
    }
    if (!hidden) seen.push_back(all[j]);
  }
  return seen;
}

/// Largest (x x n) I^-1 (x x n) over unit n: the largest eigenvalue of [x]^T I^-1 [x].
double lever_of(Vec3 x, Vec3 inverse) {
  const Vec3 a{0, x.z, -x.y}, b{-x.z, 0, x.x}, c{x.y, -x.x, 0};  // columns of [x]
  const auto times = [&](Vec3 p, Vec3 q) {
    return (p.x * inverse.x * q.x + p.y * inverse.y * q.y) + p.z * inverse.z * q.z;
  };
  const shapes::PrincipalAxes axes =
      shapes::principal_axes({times(a, a), times(b, b), times(c, c), times(a, b), times(a, c), times(b, c)});
  return fmax2(axes.moments.x, fmax2(axes.moments.y, axes.moments.z));
}

/// The shortest turn from the z axis to n.
Quaternion upright_to(Vec3 n) {
  if (!(n.z > -1 + 1e-14)) return {0, 1, 0, 0};
  return shapes::normalised({1 + n.z, -n.y, n.x, 0});
}

}  // namespace

namespace {

/// m times the largest 1/m + (r x n) I^-1 (r x n) over points of the surface and directions. The points are those of a
/// grid in one octant; what lies between them is within the margin.
double lightness_of(const shapes::Superquadric& s, Vec3 inverse) {
  constexpr int k_grid = 64;
  double most = 0;
  for (int i = 0; i <= k_grid; ++i) {
    const auto polar = det::sincos_turns(0.25 * i / k_grid);
    for (int j = 0; j <= k_grid; ++j) {
      const auto turn = det::sincos_turns(0.25 * j / k_grid);
      const Vec3 along{s.axes.x * (polar.sin * turn.cos), s.axes.y * (polar.sin * turn.sin), s.axes.z * polar.cos};
      // F + 1 is homogeneous of degree n1
      const double reach = det::exp(-det::log(shapes::inside_outside(s, along) + 1) / s.n1);
      most = fmax2(most, lever_of(reach * along, inverse));
    }
  }
  return 1 + 1.02 * most;
}

void load_superquadric(ShapeSpec& spec) {
  const std::string where = fmt::format("shape '{}'", spec.name);
  shapes::Superquadric s;
  s.axes = spec.axes;
  if (spec.exponents.size() == 2) s.n1 = spec.exponents[0], s.n2 = spec.exponents[1];
  shapes::check(s, where.c_str());
  BodyShape c;
  c.volume = shapes::volume(s);
  c.density = spec.mass > 0 ? spec.mass / c.volume : spec.density;
  c.equal_radius = det::cbrt(c.volume / (4.0 / 3.0 * det::k_pi));
  c.moments = (1 / c.volume) * shapes::inertia(s);
  c.rotor = shapes::make_rotor(c.moments);
  c.bound = c.largest = shapes::bounding_radius(s) * (1 + 8 * shapes::k_eta);  // the body as contacts see it
  c.spheres.push_back({{}, c.bound});
  c.smallest = fmin2(s.axes.x, fmin2(s.axes.y, s.axes.z));
  c.lightness = lightness_of(s, c.rotor.inverse);
  QuadricShape q;
  q.surface = s;
  q.form = shapes::dual_form(s);
  q.size = fmax2(s.axes.x, fmax2(s.axes.y, s.axes.z));
  q.roundness = shapes::smallest_radius(s);
  q.flat = 2 * c.equal_radius;
  c.roundest = 5 * q.flat;
  q.ball = s.n1 == 2 && s.n2 == 2 && s.axes.x == s.axes.y && s.axes.y == s.axes.z;
  if (q.ball) {
    c.bound = c.largest = c.roundest = c.spheres[0].r = s.axes.x;
    c.lightness = 1;
  } else if (s.n1 == 2 && s.n2 == 2) {  // of an ellipsoid: where the shortest axis ends
    const double most = (c.volume / (4.0 / 3.0 * det::k_pi)) / (c.smallest * c.smallest);
    c.roundest = shapes::hertz_radius({most, most}, q.flat);
  }
  c.quadric = q;
  spec.body = std::make_shared<const BodyShape>(std::move(c));
}

}  // namespace

void load_shape(ShapeSpec& spec, const std::string& directory) {
  if (spec.body != nullptr) return;
  if (spec.kind == ShapeSpec::Kind::superquadric) return load_superquadric(spec);
  const std::string where =
      spec.file.empty() ? fmt::format("shape '{}'", spec.name) : fmt::format("shape '{}', {}", spec.name, spec.file);
  const std::vector<shapes::SubSphere> all = spheres_of(spec, directory), given = without_hidden(all);
  const shapes::MassProperties whole = shapes::union_properties(given, where);
  BodyShape c;
  c.hidden = static_cast<int>(all.size() - given.size());
  c.volume = whole.volume;
  c.density = spec.mass > 0 ? spec.mass / whole.volume : spec.density;
  c.equal_radius = det::cbrt(whole.volume / (4.0 / 3.0 * det::k_pi));
  const bool loaded = !spec.inertia.empty();
  std::array<double, 6> inertia = whole.inertia;
  for (std::size_t k = 0; k < 6 && loaded; ++k) inertia[k] = spec.inertia[k];
  const Vec3 centre = spec.off_centre ? spec.centre : whole.centre;
  const shapes::PrincipalAxes axes = shapes::principal_axes(inertia);
  c.moments = (1 / (loaded ? spec.mass : whole.volume)) * axes.moments;
  check_moments(loaded ? axes.moments : c.moments, where);
  c.rotor = shapes::make_rotor(c.moments);
  c.turn = axes.turn;
  const shapes::Rotation r = shapes::rotation(axes.turn);
  c.smallest = k_never;
  for (const shapes::SubSphere& s : given) {
    c.spheres.push_back({shapes::to_body(r, s.x - centre), s.r});
    c.smallest = fmin2(c.smallest, s.r);
    c.largest = fmax2(c.largest, s.r);
    c.lightness = fmax2(c.lightness, 1 + lever_of(c.spheres.back().x, c.rotor.inverse));
  }
  c.bound = shapes::clump_radius(c.spheres, {});
  check_loading(spec, c, where);
  c.roundest = c.largest;
  spec.body = std::make_shared<const BodyShape>(std::move(c));
}

void set_natural_sizes(Scene& scene) {
  for (Source& s : scene.sources) {
    if (s.shape < 0 || s.kind == Source::Kind::file || s.size.largest() > 0) continue;
    if (const auto& body = scene.shapes[static_cast<std::size_t>(s.shape)].body)
      s.size.diameter = 2 * body->equal_radius;
  }
}

double smallest_share(const Scene& scene, std::size_t source) {
  const int k = scene.sources[source].shape;
  if (k < 0) return 1;
  const BodyShape& c = *scene.shapes[static_cast<std::size_t>(k)].body;
  return c.smallest / c.equal_radius;
}

double largest_share(const Scene& scene, std::size_t source) {
  const int k = scene.sources[source].shape;
  if (k < 0) return 1;
  const BodyShape& c = *scene.shapes[static_cast<std::size_t>(k)].body;
  return c.largest / c.equal_radius;
}

namespace {

/// Some shape of which grains may be made is one of these.
template <class Test>
bool makes(const Scene& scene, Test&& test) {
  for (const Source& s : scene.sources) {
    if (s.shape >= 0 && test(scene.shapes[static_cast<std::size_t>(s.shape)])) return true;
    if (s.kind == Source::Kind::file && std::any_of(scene.shapes.begin(), scene.shapes.end(), test)) return true;
  }
  return false;
}

}  // namespace

bool makes_bodies(const Scene& scene) {
  return makes(scene, [](const ShapeSpec&) { return true; });
}

bool makes_superquadrics(const Scene& scene) {
  return makes(scene, [](const ShapeSpec& s) { return s.kind == ShapeSpec::Kind::superquadric; });
}

Quaternion first_turn(const Scene& scene, std::size_t source, std::int64_t number) {
  const Source& s = scene.sources[source];
  const BodyShape& shape = *scene.shapes[static_cast<std::size_t>(s.shape)].body;
  const CounterRng rng(scene.seed, source, 0x7475726e);  // a substream of its own: sizes and places stay as they are
  const auto draw = [&](std::uint64_t k) { return rng.uniform(3 * static_cast<std::uint64_t>(number) + k); };
  if (s.orientation == Source::Orientation::random) {  // Shoemake (1992)
    const double u = draw(0), a = __builtin_sqrt(1 - u), b = __builtin_sqrt(u);
    const auto p = det::sincos_turns(draw(1)), q = det::sincos_turns(draw(2));
    return shapes::normalised(Quaternion{b * q.cos, a * p.sin, a * p.cos, b * q.sin} * shape.turn);
  }
  Quaternion turn = upright_to(s.orientation_axis);
  if (s.orientation == Source::Orientation::axis) {
    const auto t = det::sincos_turns(draw(0));  // of half the angle: two turns cover all angles twice
    turn = turn * Quaternion{t.cos, 0, 0, t.sin};
  }
  return shapes::normalised(turn * shape.turn);
}

}  // namespace talus
