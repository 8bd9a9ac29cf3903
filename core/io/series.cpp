// series.csv writer; see series.hpp.
#include "core/io/series.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <span>
#include <utility>

#include "core/base/error.hpp"
#include "core/grains/body_shape.hpp"
#include "core/io/atomic_file.hpp"
#include "core/io/series_columns.hpp"

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
  void add(const SeriesValue& value) {
    std::visit([this](const auto& v) { add(v); }, value);
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

template <class T>
void add_names(std::vector<std::string>& to, std::span<const SeriesQuantity<T>> table, const SeriesLayout& layout,
               std::string_view name = "") {
  for (const SeriesQuantity<T>& q : table) {
    if (q.wanted != nullptr && !q.wanted(layout)) continue;
    for (std::string& column : column_names(q.name, name)) to.push_back(std::move(column));
  }
}

template <class T>
void add_values(Line& line, std::span<const SeriesQuantity<T>> table, const SeriesLayout& layout,
                const SeriesAt<T>& at) {
  for (const SeriesQuantity<T>& q : table)
    if (q.wanted == nullptr || q.wanted(layout)) line.add(q.value(at));
}

}  // namespace

SeriesLayout SeriesLayout::of(const Scene& scene, std::vector<std::string> walls) {
  SeriesLayout l;
  l.inserted = !scene.sources.empty();
  l.energies = scene.output.energies;
  l.friction = scene.contact.friction;
  // normal forces turn bodies that are no spheres
  l.rotation = l.friction || makes_bodies(scene);
  l.sizes = changes_sizes(scene);
  l.wall_contacts = !walls.empty();
  l.superquadrics = makes_superquadrics(scene);
  l.walls = std::move(walls);
  l.averages = averages_of(scene);
  for (const auto& p : scene.output.flux_planes) l.planes.push_back(p.name);
  for (const auto& r : scene.output.regions) l.regions.push_back(r.name);
  return l;
}

std::vector<std::string> SeriesLayout::columns() const {
  std::vector<std::string> c;
  add_names(c, run_quantities(), *this);
  for (const std::string& w : walls) add_names(c, wall_quantities(), *this, w);
  for (const std::string& p : planes) add_names(c, plane_quantities(), *this, p);
  for (const std::string& r : regions)
    for (const AverageQuantity* q : averages)
      for (std::string& column : column_names(pattern_of(*q), r)) c.push_back(std::move(column));
  c.insert(c.end(), parts.begin(), parts.end());
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
    SeriesRow p;
    p.time = number("time");
    p.removed_mass = number("removed_mass");
    for (const std::string& plane : layout.planes)
      p.planes.push_back(
          {static_cast<std::int64_t>(number("plane." + plane + ".particles")), 0, number("plane." + plane + ".mass")});
    w.previous_ = std::move(p);
  }
  w.file_ = WatchedFile(path);
  if (::ftruncate(w.file_.fd(), static_cast<off_t>(w.size_)) != 0)
    throw Error(ErrorCode::io, std::string("cannot cut: ") + std::strerror(errno), path);
  w.file_.mark(w.size_);
  return w;
}

void SeriesWriter::start_from(const SeriesRow& row) {
  if (last_step_ < 0) previous_ = row;
}

void SeriesWriter::append(const SeriesRow& row) {
  if (row.step <= last_step_)
    throw Error(ErrorCode::io,
                fmt::format("row of step {} does not come after the last one ({})", row.step, last_step_), path_,
                "each step is written once");
  if (row.walls.size() != layout_.walls.size() || row.planes.size() != layout_.planes.size() ||
      row.regions.size() != layout_.regions.size() || row.parts.size() != layout_.parts.size())
    throw Error(ErrorCode::io, "row does not fit the columns (walls, planes, regions or parts)", path_,
                "request the wall loads from the simulation");
  // In the first row nothing lies before: the interval is 0, and with it all means.
  const SeriesRow& before = previous_ ? *previous_ : row;
  const double interval = row.time - before.time;
  Line line;
  add_values(line, run_quantities(), layout_, {row, before, interval});
  for (const WallLoad& w : row.walls) add_values(line, wall_quantities(), layout_, {w, w, interval});
  for (std::size_t p = 0; p < row.planes.size(); ++p)
    add_values(line, plane_quantities(), layout_, {row.planes[p], before.planes[p], interval});
  for (const RegionAverage& r : row.regions)
    for (const AverageQuantity* q : layout_.averages) {
      double values[6];
      q->value(r, values);
      for (int k = 0; k < q->components; ++k) line.add(values[k]);
    }
  for (const double value : row.parts) line.add(value);
  const std::string text = line.take();
  file_.check();
  if (!write_fully(file_.fd(), text.data(), text.size())) {
    const int error = errno;
    // Take back a part of a row, so that every reader finds whole rows; if even that fails, resume drops it.
    const int cut = ::ftruncate(file_.fd(), static_cast<off_t>(size_));
    file_.mark(size_);
    throw Error(ErrorCode::io,
                std::string("cannot append a row: ") + std::strerror(error) + (cut == 0 ? "" : "; last row is torn"),
                path_, "free some space; rows written before stay valid");
  }
  // What was written, not what is there: somebody may have cut the file since check().
  size_ += text.size();
  file_.mark(size_);
  last_step_ = row.step;
  previous_ = row;
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
