// See output_tables.hpp. The columns stand where they are made: core/frame/quantities.cpp, core/io/series_columns.cpp.
#include "core/io/output_tables.hpp"

#include <algorithm>
#include <vector>

#include "core/frame/quantities.hpp"
#include "core/io/series_columns.hpp"

namespace talus {
namespace {

constexpr OutputFile k_files[] = {
    {"scene.toml", "", "copy of the scene; comments at its end say how it was run"},
    {"summary.json", "", "figures of the run: status, sizes, rate, warnings, meshes, state_hash"},
    {"checkpoint-<N>.tcp", "output.checkpoint_wall",
     "state after step N, for --resume; the newest two are kept, and a run ends with one"},
    {"series.csv", "output.csv_every", "the time series, a row per interval"},
    {"particles.pvd", "output.particles_every",
     "list of the particle frames: open this one in ParaView; with [[shape]] a row per sphere of a body, and a column "
     "body: id of the first of them, of a sphere that is no body's its own"},
    {"walls.pvd", "output.particles_every", "the same for walls; cell column wall: number of the wall, from 0"},
    {"contacts.pvd", "output.contacts", "the same for contacts, a point each"},
    {"bodies.pvd", "source.shape",
     "the same for bodies that are no spheres, a point each: id, shape, scale, mass, velocity, angular_velocity, "
     "orientation (quaternion w, x, y, z from the axes of the [[shape]]); with superquadrics semi_axes and exponents "
     "(n1, n2); with output.stress stress"},
    {"grid.pvd", "output.grid", "the same for averages on a grid"},
    {"vtp/{particles,walls,contacts,bodies}-<N>.vtp", "output.vtp", "frame of step N"},
    {"vtp/grid-<N>.vti", "output.grid", "averages on a grid at step N"},
    {"gas.pvd", "gas.cells", "the same for the cells of the gas, at the times of output.particles_every"},
    {"vtp/gas-<N>.vti", "gas.cells",
     "gas at step N: porosity, superficial velocity [m/s], pressure [Pa] and its gradient [Pa/m], temperature [K], "
     "density [kg/m3], mass fractions"},
    {"{particles,walls,contacts}.vtkhdf", "output.vtkhdf", "all frames in one file, for ParaView 5.12 or newer"},
    {"report.html", "", "what `talus report` makes of the folder"},
    {"trace.json", "", "where --trace names it: steps for ui.perfetto.dev"},
    {"failed.tcp", "", "the last state of a run that the physics ended (exit code 4)"},
    {"failed.vtp", "", "its particles"},
    {"failed_near.csv", "", "those near the ones that the failure names, with what each touches"},
    {"run.lock", "", "marks the folder while a run writes into it, and as one of a run"},
    {"{scene,series,particles,walls,contacts,bodies,grid,gas}-until-<N>.{toml,csv,vtkhdf,pvd}", "",
     "what was written before a resume at step N with another scene"},
};

template <class T>
void add_rows(std::vector<OutputColumn>& rows, std::span<const SeriesQuantity<T>> table) {
  for (const SeriesQuantity<T>& q : table) rows.push_back({std::string(q.name), q.unit, q.kind, q.doc});
}

bool is_digits(std::string_view s) {
  return !s.empty() && std::all_of(s.begin(), s.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::span<const OutputFile> output_files() noexcept { return k_files; }
std::span<const OutputColumn> series_columns() {
  static const std::vector<OutputColumn> rows = [] {
    std::vector<OutputColumn> all;
    add_rows(all, run_quantities());
    add_rows(all, wall_quantities());
    add_rows(all, plane_quantities());
    for (const AverageQuantity& q : average_quantities()) all.push_back({pattern_of(q), q.unit, "moment", q.doc});
    return all;
  }();
  return rows;
}

std::span<const OutputColumn> frame_columns() {
  static const std::vector<OutputColumn> rows = [] {
    std::vector<OutputColumn> all;
    for (const ParticleQuantity& q : particle_quantities()) all.push_back({std::string(q.name), q.unit, "", q.doc});
    return all;
  }();
  return rows;
}

std::span<const OutputColumn> contact_columns() {
  static const std::vector<OutputColumn> rows = [] {
    std::vector<OutputColumn> all;
    for (const ContactQuantity& q : contact_quantities()) all.push_back({std::string(q.name), q.unit, "", q.doc});
    return all;
  }();
  return rows;
}

bool fits(std::string_view pattern, std::string_view name) {
  if (pattern.empty()) return name.empty();
  if (pattern.front() == '<') {
    const std::size_t close = pattern.find('>');
    const std::string_view rest = pattern.substr(close + 1);
    const bool number = pattern.substr(0, close + 1) == "<N>";
    for (std::size_t n = name.size(); n > 0; --n)  // names of users may hold anything
      if ((!number || is_digits(name.substr(0, n))) && fits(rest, name.substr(n))) return true;
    return false;
  }
  if (pattern.front() == '{') {
    const std::size_t close = pattern.find('}');
    const std::string_view rest = pattern.substr(close + 1);
    for (std::string_view words = pattern.substr(1, close - 1);;) {
      const std::size_t comma = words.find(',');
      const std::string_view word = words.substr(0, comma);
      if (name.starts_with(word) && fits(rest, name.substr(word.size()))) return true;
      if (comma == std::string_view::npos) return false;
      words.remove_prefix(comma + 1);
    }
  }
  return !name.empty() && name.front() == pattern.front() && fits(pattern.substr(1), name.substr(1));
}

}  // namespace talus
