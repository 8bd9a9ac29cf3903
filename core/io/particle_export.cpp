// See particle_export.hpp.
#include "core/io/particle_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

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

std::string csv_text(const Frame& f) {
  std::string text = "id,x,y,z,radius,vx,vy,vz";
  std::vector<Held> held;
  for (const ParticleQuantity& q : particle_quantities()) {
    if (q.csv.empty() || !q.held(f)) continue;
    text += "," + std::string(q.csv);
    held.push_back({static_cast<std::size_t>(q.components), q.values(f)});
  }
  text += '\n';
  const Out out(text);
  for (std::size_t i = 0; i < f.x.size(); ++i) {
    fmt::format_to(out, "{}", f.id[i]);
    put(out, f.x[i], ',');
    fmt::format_to(out, ",{}", f.r[i]);
    put(out, f.v[i], ',');
    for (const Held& column : held) put_row(out, column, i);
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
