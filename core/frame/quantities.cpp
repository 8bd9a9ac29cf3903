// The tables; see quantities.hpp.
#include "core/frame/quantities.hpp"

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"

namespace talus {
namespace {

using Tensors = std::vector<std::array<double, 6>>;

/// XX YY ZZ XY XZ YZ of a frame to VTK's XX YY ZZ XY YZ XZ, and back: the last two change places.
Tensors swapped(Tensors tensors) {
  for (auto& t : tensors) std::swap(t[4], t[5]);
  return tensors;
}

template <class T>
struct Flat {
  using Value = T;
  static std::vector<T> of(const std::vector<T>& column) { return column; }
  static std::vector<T> back(std::vector<T>&& column) { return std::move(column); }
};
template <>
struct Flat<Vec3> {
  using Value = double;
  static std::vector<double> of(const std::vector<Vec3>& column) { return flat_of(column); }
  static std::vector<Vec3> back(std::vector<double>&& column) { return vectors_of(column); }
};
template <>
struct Flat<std::array<double, 6>> {
  using Value = double;
  static std::vector<double> of(const Tensors& column) {
    std::vector<double> out;
    out.reserve(6 * column.size());
    for (const auto& t : swapped(column)) out.insert(out.end(), t.begin(), t.end());
    return out;
  }
  static Tensors back(std::vector<double>&& column) {
    Tensors out(column.size() / 6);
    for (std::size_t i = 0; i < out.size(); ++i)
      std::copy_n(column.begin() + 6 * static_cast<long>(i), 6, out[i].begin());
    return swapped(std::move(out));
  }
};

template <auto Member>
using ElementOf = typename std::remove_cvref_t<decltype(std::declval<Frame>().*Member)>::value_type;

template <auto Member>
ColumnValues values_of(const Frame& f) {
  return Flat<ElementOf<Member>>::of(f.*Member);
}
template <auto Member>
bool held_by(const Frame& f) {
  return !(f.*Member).empty();
}
template <auto Member>
void take_into(Frame& f, ColumnValues&& v) {
  using F = Flat<ElementOf<Member>>;
  f.*Member = F::back(std::get<std::vector<typename F::Value>>(std::move(v)));
}

ColumnValues diameters(const Frame& f) {
  std::vector<double> d(f.r);
  for (double& value : d) value *= 2;
  return d;
}
/// A frame in which nothing is fixed at present has no such column: all free.
ColumnValues held_grains(const Frame& f) {
  return f.fixed.empty() ? std::vector<std::uint8_t>(f.x.size(), 0) : f.fixed;
}

bool rotates(const Scene& s) { return s.contact.friction; }
bool several_materials(const Scene& s) { return s.materials.size() > 1; }
bool may_hold(const Scene& s) {
  return std::any_of(
             s.events.begin(), s.events.end(),
             [](const Event& e) { return e.action == Event::Action::freeze || e.action == Event::Action::drive; }) ||
         std::any_of(s.groups.begin(), s.groups.end(), [](const GroupSpec& g) { return g.fixed_in_file; });
}
bool wants_coordination(const Scene& s) { return s.output.coordination; }
bool wants_stress(const Scene& s) { return s.output.stress; }

// clang-format off
constexpr ParticleQuantity k_particles[] = {
    {"id", "-", "number of the grain, in the order of its creation; never used again",
     1, nullptr, nullptr, values_of<&Frame::id>, take_into<&Frame::id>, ""},
    {"velocity", "m/s", "half a step before the frame's time",
     3, nullptr, nullptr, values_of<&Frame::v>, take_into<&Frame::v>, ""},
    {"radius", "m", "of the grain",
     1, nullptr, nullptr, values_of<&Frame::r>, take_into<&Frame::r>, ""},
    {"diameter", "m", "twice the radius, for glyphs that want it",
     1, nullptr, nullptr, diameters, nullptr, ""},
    {"omega", "rad/s", "angular velocity; with friction only",
     3, rotates, held_by<&Frame::w>, values_of<&Frame::w>, take_into<&Frame::w>, "wx,wy,wz"},
    {"material", "-", "number of the material, from 0; with several only",
     1, several_materials, held_by<&Frame::material>, values_of<&Frame::material>, take_into<&Frame::material>, "material"},
    {"fixed", "-", "1 where the grain is held or driven; where groups or events can do so",
     1, may_hold, held_by<&Frame::fixed>, held_grains, take_into<&Frame::fixed>, "fixed"},
    {"coordination", "-", "contacts of the grain (output.coordination)",
     1, wants_coordination, held_by<&Frame::coordination>, values_of<&Frame::coordination>, take_into<&Frame::coordination>, "coordination", true},
    {"stress", "Pa", "XX YY ZZ XY YZ XZ, sum over contacts of force times branch / volume (output.stress); of a body on all its spheres",
     6, wants_stress, held_by<&Frame::stress>, values_of<&Frame::stress>, take_into<&Frame::stress>, "", true},
};

template <class T, auto Member>
void append_of(ColumnValues& to, const ContactRecord& c) {
  auto& out = std::get<std::vector<T>>(to);
  if constexpr (std::is_same_v<std::remove_cvref_t<decltype(c.*Member)>, Vec3>)
    out.insert(out.end(), {(c.*Member).x, (c.*Member).y, (c.*Member).z});
  else
    out.push_back(c.*Member);
}
template <class T>
ColumnValues none_of() { return std::vector<T>{}; }

constexpr ContactQuantity k_contacts[] = {
    {"particle_a", "-", "id of the grain on which the forces act", append_of<std::int64_t, &ContactRecord::a>, none_of<std::int64_t>, 1},
    {"particle_b", "-", "id of the other grain; -1 - n for wall number n", append_of<std::int64_t, &ContactRecord::b>, none_of<std::int64_t>, 1},
    {"normal_force", "N", "on particle_a, along the normal", append_of<double, &ContactRecord::normal_force>, none_of<double>, 3},
    {"tangential_force", "N", "on particle_a, across the normal", append_of<double, &ContactRecord::tangential_force>, none_of<double>, 3},
    {"overlap", "m", "depth of the contact", append_of<double, &ContactRecord::overlap>, none_of<double>, 1},
};
// clang-format on

[[noreturn]] void lacking(std::size_t given, std::string_view name, std::size_t n) {
  throw Error(ErrorCode::io,
              "frame has " + std::to_string(given) + " values of '" + std::string(name) + "' for " + std::to_string(n) +
                  " particles",
              "output", "request this column from the simulation");
}

template <class Choose>
std::uint64_t chosen_by(Choose choose) {
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < std::size(k_particles); ++k)
    if (choose(k_particles[k])) bits |= std::uint64_t{1} << k;
  return bits;
}

}  // namespace

std::span<const ParticleQuantity> particle_quantities() noexcept { return k_particles; }
bool is_part_column(std::string_view name) noexcept {
  return !name.empty() && name != "body" &&
         std::none_of(std::begin(k_particles), std::end(k_particles), [&](const auto& q) { return q.name == name; });
}
std::span<const ContactQuantity> contact_quantities() noexcept { return k_contacts; }

ParticleColumns ParticleColumns::of(const Scene& scene, const Frame& example) {
  ParticleColumns c;
  for (const ExtraColumn& e : example.extra) c.extra_.push_back(e.name);
  for (const ExtraColumn& e : example.contact_extra) c.contact_extra_.push_back(e.name);
  c.chosen_ = chosen_by([&](const ParticleQuantity& q) { return q.wanted != nullptr && q.wanted(scene); });
  return c;
}

ParticleColumns ParticleColumns::of(const Frame& frame) {
  ParticleColumns c;
  for (const ExtraColumn& e : frame.extra) c.extra_.push_back(e.name);
  for (const ExtraColumn& e : frame.contact_extra) c.contact_extra_.push_back(e.name);
  c.chosen_ = chosen_by([&](const ParticleQuantity& q) { return q.held != nullptr && q.held(frame); });
  return c;
}

ParticleColumns ParticleColumns::all() {
  ParticleColumns c;
  c.chosen_ = chosen_by([](const ParticleQuantity&) { return true; });
  return c;
}

ParticleColumns ParticleColumns::without_forces() const {
  ParticleColumns c = *this;
  c.chosen_ &= chosen_by([](const ParticleQuantity& q) { return !q.forces; });
  return c;
}

PolyData particle_poly(const Frame& frame, const ParticleColumns& columns) {
  const std::size_t n = frame.x.size();
  PolyData p;
  p.points = frame.x;
  p.vertices = true;
  for (std::size_t k = 0; k < std::size(k_particles); ++k) {
    const ParticleQuantity& q = k_particles[k];
    if (!columns.has(k)) continue;
    PolyColumn column{std::string(q.name), q.components, q.values(frame)};
    const std::size_t rows =
        std::visit([](const auto& v) { return v.size(); }, column.values) / static_cast<std::size_t>(q.components);
    if (rows != n) lacking(rows, q.name, n);
    p.point_data.push_back(std::move(column));
  }
  for (const std::string& name : columns.extra()) {
    const auto e = std::find_if(frame.extra.begin(), frame.extra.end(), [&](const auto& x) { return x.name == name; });
    std::vector<double> values = e == frame.extra.end() ? std::vector<double>{} : e->values;
    if (values.size() != n) lacking(values.size(), name, n);
    p.point_data.push_back({name, 1, std::move(values)});
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
  for (const ContactRecord& c : frame.contacts) p.points.push_back(c.point);
  for (const ContactQuantity& q : k_contacts) {
    ColumnValues values = q.none();
    for (const ContactRecord& c : frame.contacts) q.append(values, c);
    p.point_data.push_back({std::string(q.name), q.components, std::move(values)});
  }
  for (const ExtraColumn& e : frame.contact_extra) p.point_data.push_back({e.name, 1, e.values});
  return p;
}

PolyData body_poly(const Frame& frame) {
  PolyData p;
  p.vertices = true;
  std::vector<std::int64_t> id;
  std::vector<std::int32_t> shape;
  std::vector<double> scale, mass, turn, exponents;
  std::vector<Vec3> v, w, axes;
  bool superquadrics = false;
  for (const BodyRecord& b : frame.bodies) {
    p.points.push_back(b.x);
    id.push_back(b.id);
    shape.push_back(b.shape);
    scale.push_back(b.scale);
    mass.push_back(b.mass);
    v.push_back(b.v);
    w.push_back(b.w);
    turn.insert(turn.end(), b.orientation.begin(), b.orientation.end());
    axes.push_back(b.semi_axes);
    exponents.insert(exponents.end(), b.exponents.begin(), b.exponents.end());
    superquadrics = superquadrics || b.semi_axes.x > 0;
  }
  p.point_data = {{"id", 1, std::move(id)},           {"shape", 1, std::move(shape)},
                  {"scale", 1, std::move(scale)},     {"mass", 1, std::move(mass)},
                  {"velocity", 3, flat_of(v)},        {"angular_velocity", 3, flat_of(w)},
                  {"orientation", 4, std::move(turn)}};
  if (superquadrics) {
    p.point_data.push_back({"semi_axes", 3, flat_of(axes)});
    p.point_data.push_back({"exponents", 2, std::move(exponents)});
  }
  if (!frame.stress.empty()) {
    std::vector<std::array<double, 6>> stress;
    for (const BodyRecord& b : frame.bodies) {
      const auto at = std::lower_bound(frame.id.begin(), frame.id.end(), b.id) - frame.id.begin();
      stress.push_back(frame.stress[static_cast<std::size_t>(at)]);
    }
    p.point_data.push_back({"stress", 6, Flat<std::array<double, 6>>::of(stress)});
  }
  return p;
}

std::vector<Vec3> vectors_of(const std::vector<double>& flat) {
  std::vector<Vec3> out(flat.size() / 3);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = {flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]};
  return out;
}

std::vector<double> flat_of(const std::vector<Vec3>& vectors) {
  std::vector<double> out;
  out.reserve(3 * vectors.size());
  for (const Vec3& a : vectors) out.insert(out.end(), {a.x, a.y, a.z});
  return out;
}

}  // namespace talus
