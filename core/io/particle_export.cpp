// See particle_export.hpp.
#include "core/io/particle_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "core/base/error.hpp"
#include "core/frame/quantities.hpp"

namespace talus {
namespace {

/// The given box, or the one around all particles.
Domain box_of(const Frame& f, const std::optional<Domain>& domain) {
  if (domain) return *domain;
  Domain box;
  for (auto& axis : box.boundary) axis = {Boundary::open, Boundary::open};
  if (f.x.empty()) return box;
  box.lower = box.upper = f.x.front();
  for (std::size_t i = 0; i < f.x.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      box.lower[k] = std::min(box.lower[k], f.x[i][k] - f.r[i]);
      box.upper[k] = std::max(box.upper[k], f.x[i][k] + f.r[i]);
    }
  return box;
}

using Out = std::back_insert_iterator<std::string>;

void put(Out out, Vec3 v, char separator) {
  fmt::format_to(out, "{}{}{}{}{}{}", separator, v.x, separator, v.y, separator, v.z);
}

/// An optional column of a table.
struct Held {
  std::size_t components;
  ColumnValues values;
};

void put_row(Out out, const Held& column, std::size_t i) {
  std::visit(
      [&](const auto& v) {
        // unary plus: small integers are numbers, not characters
        for (std::size_t k = 0; k < column.components; ++k) fmt::format_to(out, ",{}", +v[column.components * i + k]);
      },
      column.values);
}

/// Columns of parts at the end of a table, which whoever does not know them passes over; which body a sphere belongs to
/// is said by the rows of bodies.
void put_extra_names(std::string& text, const Frame& f) {
  for (const ExtraColumn& e : f.extra)
    if (e.name != "body") text += "," + e.name;
}
void put_extra(Out out, const Frame& f, std::size_t i) {
  for (const ExtraColumn& e : f.extra)
    if (e.name != "body") fmt::format_to(out, ",{}", e.values[i]);
}

int material_of(const Frame& f, std::size_t i) { return f.material.empty() ? 0 : f.material[i]; }

/// A species is one word.
std::string species(int material, std::span<const Material> materials) {
  const auto k = static_cast<std::size_t>(material);
  const std::string name = k < materials.size() ? materials[k].name : "";
  const bool word = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return word ? name : fmt::format("M{}", material);
}

}  // namespace

namespace {

/// Rows that are spheres of bodies: the body whose first one it is, -1: another sphere of it; k_alone: none.
constexpr std::int64_t k_alone = -2;
std::vector<std::int64_t> bodies_of_rows(const Frame& f) {
  std::vector<std::int64_t> of(f.x.size(), k_alone);
  const auto column =
      std::find_if(f.extra.begin(), f.extra.end(), [](const ExtraColumn& e) { return e.name == "body"; });
  for (std::size_t i = 0; i < of.size() && column != f.extra.end(); ++i) {
    const auto id = static_cast<ParticleId>(column->values[i]);
    const auto body = std::lower_bound(f.bodies.begin(), f.bodies.end(), id,
                                       [](const BodyRecord& b, ParticleId wanted) { return b.id < wanted; });
    if (body == f.bodies.end() || body->id != id) continue;
    of[i] = f.id[i] == id ? body - f.bodies.begin() : -1;
  }
  return of;
}

/// A name that stands for itself in a table.
bool plain(std::string_view name) {
  return !name.empty() && name != "-" && name.find_first_of(",;|\t\"'#%/ ") == std::string_view::npos;
}

std::string text_with_bodies(const Frame& f, std::span<const ShapeSpec> shapes) {
  std::string text = "id,x,y,z,radius,vx,vy,vz,wx,wy,wz,shape,scale,qw,qx,qy,qz";
  if (!f.material.empty()) text += ",material";
  if (!f.fixed.empty()) text += ",fixed";
  put_extra_names(text, f);
  text += '\n';
  const Out out(text);
  const std::vector<std::int64_t> bodies = bodies_of_rows(f);
  for (std::size_t i = 0; i < f.x.size(); ++i) {
    if (bodies[i] == -1) continue;
    const BodyRecord* b = bodies[i] >= 0 ? &f.bodies[static_cast<std::size_t>(bodies[i])] : nullptr;
    fmt::format_to(out, "{}", f.id[i]);
    put(out, b != nullptr ? b->x : f.x[i], ',');
    fmt::format_to(out, ",{}", b != nullptr ? 0 : f.r[i]);
    put(out, b != nullptr ? b->v : f.v[i], ',');
    put(out, b != nullptr ? b->w : f.w.empty() ? Vec3{} : f.w[i], ',');
    if (b == nullptr) {
      text += ",-,1,1,0,0,0";
    } else {
      const auto k = static_cast<std::size_t>(b->shape);
      const auto& q = b->orientation;
      const bool named = k < shapes.size() && plain(shapes[k].name);
      fmt::format_to(out, ",{},{},{},{},{},{}", named ? shapes[k].name : std::to_string(k), b->scale, q[0], q[1], q[2],
                     q[3]);
    }
    if (!f.material.empty()) fmt::format_to(out, ",{}", +f.material[i]);
    if (!f.fixed.empty()) fmt::format_to(out, ",{}", +f.fixed[i]);
    put_extra(out, f, i);
    text += '\n';
  }
  return text;
}

}  // namespace

std::string csv_text(const Frame& f, std::span<const ShapeSpec> shapes) {
  if (f.bodies_missing)
    throw Error(ErrorCode::io, "its particles belong to bodies that are no spheres, which stand in no file beside it",
                "", "convert the run folder or a checkpoint");
  if (!f.bodies.empty()) return text_with_bodies(f, shapes);
  std::string text = "id,x,y,z,radius,vx,vy,vz";
  std::vector<Held> held;
  for (const ParticleQuantity& q : particle_quantities()) {
    if (q.csv.empty() || !q.held(f)) continue;
    text += "," + std::string(q.csv);
    held.push_back({static_cast<std::size_t>(q.components), q.values(f)});
  }
  put_extra_names(text, f);
  text += '\n';
  const Out out(text);
  for (std::size_t i = 0; i < f.x.size(); ++i) {
    fmt::format_to(out, "{}", f.id[i]);
    put(out, f.x[i], ',');
    fmt::format_to(out, ",{}", f.r[i]);
    put(out, f.v[i], ',');
    for (const Held& column : held) put_row(out, column, i);
    put_extra(out, f, i);
    text += '\n';
  }
  return text;
}

std::string lammps_dump_text(const Frame& f, const std::optional<Domain>& domain) {
  const Domain box = box_of(f, domain);
  std::string text = fmt::format("ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS", f.step, f.x.size());
  for (int k = 0; k < 3; ++k) text += box.periodic(k) ? " pp" : " ff";
  text += '\n';
  const Out out(text);
  for (int k = 0; k < 3; ++k) fmt::format_to(out, "{} {}\n", box.lower[k], box.upper[k]);
  text += "ITEM: ATOMS id type x y z vx vy vz radius";
  text += f.w.empty() ? "\n" : " omegax omegay omegaz\n";
  for (std::size_t i = 0; i < f.x.size(); ++i) {
    fmt::format_to(out, "{} {}", f.id[i], material_of(f, i) + 1);
    put(out, f.x[i], ' ');
    put(out, f.v[i], ' ');
    fmt::format_to(out, " {}", f.r[i]);
    if (!f.w.empty()) put(out, f.w[i], ' ');
    text += '\n';
  }
  return text;
}

std::string extended_xyz_text(const Frame& f, const std::optional<Domain>& domain,
                              std::span<const Material> materials) {
  const Domain box = box_of(f, domain);
  const Vec3 size = box.upper - box.lower;
  std::string text = fmt::format(
      "{}\nLattice=\"{} 0 0 0 {} 0 0 0 {}\" Origin=\"{} {} {}\" pbc=\"{} {} {}\" Time={} Step={} "
      "Properties=species:S:1:id:I:1:pos:R:3:radius:R:1:velo:R:3{}\n",
      f.x.size(), size.x, size.y, size.z, box.lower.x, box.lower.y, box.lower.z, box.periodic(0) ? 'T' : 'F',
      box.periodic(1) ? 'T' : 'F', box.periodic(2) ? 'T' : 'F', f.time, f.step,
      f.w.empty() ? "" : ":angular_velocity:R:3");
  const Out out(text);
  for (std::size_t i = 0; i < f.x.size(); ++i) {
    fmt::format_to(out, "{} {}", species(material_of(f, i), materials), f.id[i]);
    put(out, f.x[i], ' ');
    fmt::format_to(out, " {}", f.r[i]);
    put(out, f.v[i], ' ');
    if (!f.w.empty()) put(out, f.w[i], ' ');
    text += '\n';
  }
  return text;
}

}  // namespace talus
