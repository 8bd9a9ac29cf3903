// series.csv writer; see series.hpp.
#include "core/io/series.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/base/error.hpp"
#include "core/io/atomic_file.hpp"
#include "core/scene/scene.hpp"

namespace talus {

namespace {

/// RFC 4180: quoted only where needed.
std::string quoted(const std::string& s) {
  if (s.find_first_of(",\"\r\n") == std::string::npos) return s;
  std::string out = "\"";
  for (char c : s) {
    if (c == '"') out += '"';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out + "\"";
}

std::string header_line(const SeriesLayout& layout) {
  std::string line;
  for (const std::string& c : layout.columns()) line += (line.empty() ? "" : ",") + quoted(c);
  return line + "\n";
}

/// Appends values separated by commas; doubles as the shortest text that reads back exactly.
class Line {
 public:
  void add(std::int64_t v) { put(fmt::format("{}", v)); }
  void add(double v) { put(fmt::format("{}", v)); }
  void add(Vec3 v) {
    add(v.x);
    add(v.y);
    add(v.z);
  }
  std::string take() { return std::move(text_) + "\n"; }

 private:
  void put(const std::string& s) {
    if (!text_.empty()) text_ += ',';
    text_ += s;
  }
  std::string text_;
};

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> out;
  for (;;) {
    const auto comma = line.find(',');
    out.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return out;
    line.remove_prefix(comma + 1);
  }
}

/// Number of columns that a header names; commas within quotes belong to a name.
std::size_t names_in(std::string_view header) {
  std::size_t n = 1;
  bool inside = false;
  for (const char c : header) {
    inside = inside != (c == '"');
    if (c == ',' && !inside) ++n;
  }
  return n;
}

template <class T>
bool parse(std::string_view s, T& out) {
  const auto r = std::from_chars(s.data(), s.data() + s.size(), out);
  return r.ec == std::errc() && r.ptr == s.data() + s.size();
}

constexpr const char* k_axes = "xyz";
constexpr const char* k_tensor[] = {"xx", "yy", "zz", "xy", "xz", "yz"};

}  // namespace

SeriesLayout SeriesLayout::of(const Scene& scene, std::vector<std::string> walls) {
  SeriesLayout l;
  l.inserted = !scene.sources.empty();
  l.energies = scene.output.energies;
  l.rotation = scene.contact.friction;
  l.wall_contacts = !walls.empty();
  l.walls = std::move(walls);
  l.region_stress = scene.output.stress;
  l.region_coordination = scene.output.coordination;
  for (const auto& p : scene.output.flux_planes) l.planes.push_back(p.name);
  for (const auto& r : scene.output.regions) l.regions.push_back(r.name);
  return l;
}

std::vector<std::string> SeriesLayout::columns() const {
  std::vector<std::string> c{"step", "time", "particles", "kinetic_energy", "contacts"};
  if (wall_contacts) c.push_back("wall_contacts");
  c.push_back("coordination_number");
  if (inserted) c.push_back("inserted");
  c.insert(c.end(), {"removed", "removed_mass", "mass_flow"});
  if (energies) {
    c.push_back("kinetic_translation");
    if (rotation) c.push_back("kinetic_rotation");
    c.insert(c.end(), {"potential", "elastic", "dissipated_damping"});
    if (rotation) c.push_back("dissipated_friction");
    c.insert(c.end(), {"dissipated_background", "wall_work", "inserted_energy", "balance_residual"});
  }
  const auto vector_of = [&](const std::string& base) {
    for (int k = 0; k < 3; ++k) c.push_back(base + k_axes[k]);
  };
  for (const std::string& w : walls) {
    vector_of("wall." + w + ".force_");
    vector_of("wall." + w + ".torque_");
  }
  for (const std::string& p : planes)
    for (const char* q : {".particles", ".mass", ".particle_flow", ".mass_flow"}) c.push_back("plane." + p + q);
  for (const std::string& r : regions) {
    const std::string base = "region." + r + ".";
    c.insert(c.end(), {base + "particles", base + "solid_fraction"});
    vector_of(base + "velocity_");
    c.push_back(base + "granular_temperature");
    if (region_coordination) c.push_back(base + "coordination");
    if (region_stress)
      for (const char* t : k_tensor) c.push_back(base + "stress_" + t);
  }
  return c;
}

SeriesWriter::SeriesWriter(const std::string& path, const SeriesLayout& layout) : path_(path), layout_(layout) {
  const std::string header = header_line(layout);
  write_file_atomic(path, header);
  file_ = WatchedFile(path);
  size_ = header.size();
}

SeriesWriter::~SeriesWriter() = default;
SeriesWriter::SeriesWriter(SeriesWriter&&) noexcept = default;
SeriesWriter& SeriesWriter::operator=(SeriesWriter&&) noexcept = default;
void SeriesWriter::check() const { file_.check(); }

SeriesWriter SeriesWriter::resume(const std::string& path, const SeriesLayout& layout, std::int64_t last_step) {
  if (!std::filesystem::exists(path)) return SeriesWriter(path, layout);
  const std::string text = read_file_text(path), header = header_line(layout);
  if (text.compare(0, header.size(), header) != 0)
    throw CannotContinue("it has other columns than this run writes", path);
  const std::size_t columns = layout.columns().size();
  SeriesWriter w;
  w.path_ = path;
  w.layout_ = layout;
  std::size_t at = header.size();
  std::string_view last;
  for (;;) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos) break;  // a row torn by a kill is dropped
    const std::string_view line(text.data() + at, end - at);
    std::int64_t step = -1;
    if (split(line).size() != columns || !parse(line.substr(0, line.find(',')), step) || step <= w.last_step_)
      throw CannotContinue(fmt::format("its row at byte {} is damaged", at), path);
    if (step > last_step) break;
    w.last_step_ = step;
    last = line;
    at = end + 1;
  }
  w.size_ = at;
  if (!last.empty()) {
    const auto values = split(last);
    const auto names = layout.columns();
    const auto number = [&](const std::string& name) {
      for (std::size_t c = 0; c < names.size(); ++c) {
        double v = 0;
        if (names[c] != name) continue;
        if (!parse(values[c], v)) break;
        return v;
      }
      throw Error(ErrorCode::io, "last row has no number for '" + name + "'", path, "delete that row, then resume");
    };
    Previous p{number("time"), number("removed_mass"), {}};
    for (const std::string& plane : layout.planes)
      p.planes.push_back(
          {static_cast<std::int64_t>(number("plane." + plane + ".particles")), 0, number("plane." + plane + ".mass")});
    w.previous_ = std::move(p);
  }
  w.file_ = WatchedFile(path);
  if (::ftruncate(w.file_.fd(), static_cast<off_t>(w.size_)) != 0)
    throw Error(ErrorCode::io, std::string("cannot cut: ") + std::strerror(errno), path);
  w.file_.mark();
  return w;
}

void SeriesWriter::start_from(const SeriesRow& row) {
  if (last_step_ < 0) previous_ = Previous{row.time, row.removed_mass, row.planes};
}

void SeriesWriter::append(const SeriesRow& row) {
  if (row.step <= last_step_)
    throw Error(ErrorCode::io,
                fmt::format("row of step {} does not come after the last one ({})", row.step, last_step_), path_,
                "each step is written once");
  if (row.walls.size() != layout_.walls.size() || row.planes.size() != layout_.planes.size() ||
      row.regions.size() != layout_.regions.size())
    throw Error(ErrorCode::io, "row does not fit the columns (walls, planes or regions)", path_,
                "request the wall loads from the simulation");
  const double interval = previous_ ? row.time - previous_->time : 0;
  const auto rate = [&](double now, double before) { return interval > 0 ? (now - before) / interval : 0.0; };
  Line line;
  line.add(row.step);
  line.add(row.time);
  line.add(row.particles);
  line.add(row.kinetic_energy);
  line.add(row.contacts);
  if (layout_.wall_contacts) line.add(row.wall_contacts);
  line.add(row.particles > 0 ? 2.0 * static_cast<double>(row.contacts) / static_cast<double>(row.particles) : 0.0);
  if (layout_.inserted) line.add(row.inserted);
  line.add(row.removed);
  line.add(row.removed_mass);
  line.add(previous_ ? rate(row.removed_mass, previous_->removed_mass) : 0.0);
  if (layout_.energies) {
    const Energies& e = row.energies;
    line.add(e.kinetic_translation);
    if (layout_.rotation) line.add(e.kinetic_rotation);
    line.add(e.potential);
    line.add(e.elastic);
    line.add(e.dissipated_damping);
    if (layout_.rotation) line.add(e.dissipated_friction);
    line.add(e.dissipated_background);
    line.add(e.wall_work);
    line.add(e.inserted);
    line.add(e.residual);
  }
  for (const WallLoad& w : row.walls) {
    line.add(w.force);
    line.add(w.torque);
  }
  for (std::size_t p = 0; p < row.planes.size(); ++p) {
    const PlaneTotal before = previous_ ? previous_->planes[p] : PlaneTotal{};
    line.add(row.planes[p].particles());
    line.add(row.planes[p].mass);
    line.add(rate(static_cast<double>(row.planes[p].particles()), static_cast<double>(before.particles())));
    line.add(rate(row.planes[p].mass, before.mass));
  }
  for (const RegionAverage& r : row.regions) {
    line.add(r.particles);
    line.add(r.solid_fraction);
    line.add(r.velocity);
    line.add(r.temperature);
    if (layout_.region_coordination) line.add(r.coordination);
    if (layout_.region_stress)
      for (double s : r.stress) line.add(s);
  }
  const std::string text = line.take();
  file_.check();
  if (!write_fully(file_.fd(), text.data(), text.size())) {
    const int error = errno;
    // Take back a part of a row, so that every reader finds whole rows; if even that fails, resume drops it.
    const int cut = ::ftruncate(file_.fd(), static_cast<off_t>(size_));
    file_.mark();
    throw Error(ErrorCode::io,
                std::string("cannot append a row: ") + std::strerror(error) + (cut == 0 ? "" : "; last row is torn"),
                path_, "free some space; rows written before stay valid");
  }
  file_.mark();
  size_ += text.size();
  last_step_ = row.step;
  previous_ = Previous{row.time, row.removed_mass, row.planes};
}

void check_series(const std::string& path) {
  const std::string text = read_file_text(path);
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::io, "time series is damaged: " + what, path,
                "delete the damaged rows, or resume the run from a checkpoint");
  };
  const std::size_t header = text.find('\n');
  if (header == std::string::npos || !text.starts_with("step,time,"))
    fail("it does not begin with the names of its columns");
  const std::size_t columns = names_in(std::string_view(text).substr(0, header));
  std::int64_t last = -1;
  for (std::size_t at = header + 1; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos) fail(fmt::format("the row at byte {} is cut off", at));
    const auto values = split(std::string_view(text).substr(at, end - at));
    std::int64_t step = -1;
    bool good = values.size() == columns && parse(values[0], step) && step > last;
    double number = 0;
    for (const std::string_view v : values) good = good && parse(v, number);
    if (!good) fail(fmt::format("the row at byte {}", at));
    last = step;
    at = end + 1;
  }
}

}  // namespace talus
