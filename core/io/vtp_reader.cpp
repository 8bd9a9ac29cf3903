// See vtp_reader.hpp. Only the form that core/io/vtp.cpp writes is read: raw appended blocks with 64-bit byte counts.
#include "core/io/vtp_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string_view>

#include "core/base/error.hpp"
#include "core/frame/quantities.hpp"
#include "core/io/atomic_file.hpp"

namespace talus {
namespace {

/// The value of an attribute within one XML tag; nothing where it is not there.
std::string_view attribute(std::string_view tag, std::string_view name) {
  const std::string mark = " " + std::string(name) + "=\"";
  const std::size_t at = tag.find(mark);
  if (at == std::string_view::npos) return {};
  const std::size_t begin = at + mark.size(), end = tag.find('"', begin);
  return end == std::string_view::npos ? std::string_view{} : tag.substr(begin, end - begin);
}

template <class T>
bool parse(std::string_view text, T& value) {
  const auto r = std::from_chars(text.data(), text.data() + text.size(), value);
  return !text.empty() && r.ec == std::errc() && r.ptr == text.data() + text.size();
}

std::int64_t step_of_name(const std::string& path) {
  const std::string stem = std::filesystem::path(path).stem().string();
  const std::size_t dash = stem.rfind('-');
  std::int64_t step = 0;
  return dash != std::string::npos && parse(std::string_view(stem).substr(dash + 1), step) ? step : 0;
}

/// A file in memory: the XML up to the blocks, and the blocks.
class VtpFile {
 public:
  explicit VtpFile(const std::string& path) : path_(path), bytes_(read_file_bytes(path)) {
    const std::string_view text(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
    constexpr std::string_view mark = "<AppendedData encoding=\"raw\">\n_", end = "\n</AppendedData>\n</VTKFile>\n";
    if (!text.starts_with("<?xml") || text.find("<PolyData>") == std::string_view::npos) fail("it is no .vtp file");
    const std::size_t at = text.find(mark);
    if (at == std::string_view::npos || text.find("header_type=\"UInt64\"") > at)
      fail("another program wrote it: its values are not appended raw with 64-bit counts");
    if (!text.ends_with(end)) fail("it is cut off");
    xml_ = text.substr(0, at);
    begin_ = at + mark.size();
    end_ = text.size() - end.size();
    if (!parse(attribute(element("<Piece"), "NumberOfPoints"), points_) || points_ > bytes_.size())
      fail("it does not say how many points it has");
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::io, "cannot be read: " + what, path_, "a particle frame of a run is expected");
  }
  std::size_t points() const noexcept { return points_; }
  double time() const {
    const std::size_t at = xml_.find("Name=\"TimeValue\"");
    if (at == std::string_view::npos) return 0;
    const std::size_t open = xml_.find('>', at), close = xml_.find('<', open);
    double value = 0;
    if (close == std::string_view::npos || !parse(xml_.substr(open + 1, close - open - 1), value))
      fail("its time is damaged");
    return value;
  }
  bool has(std::string_view name) const { return !tag_of(name).empty(); }

  /// Columns of points that hold one double for each: those of parts among them, whose names no table here knows.
  std::vector<std::string> scalars() const {
    const std::size_t begin = std::min(xml_.find("<PointData"), xml_.size());
    const std::string_view data = xml_.substr(begin, xml_.find("</PointData>") - begin);
    std::vector<std::string> names;
    for (std::size_t at = data.find("<DataArray"); at != std::string_view::npos; at = data.find("<DataArray", at + 1)) {
      const std::string_view tag = data.substr(at, data.find('>', at) - at);
      if (attribute(tag, "type") == "Float64" && attribute(tag, "NumberOfComponents") == "1")
        names.emplace_back(attribute(tag, "Name"));
    }
    return names;
  }

  /// The block of a column: points() rows of `components` values.
  template <class T>
  std::vector<T> column(std::string_view name, std::size_t components) const {
    static constexpr std::string_view type = std::is_same_v<T, double>         ? "Float64"
                                             : std::is_same_v<T, std::int64_t> ? "Int64"
                                             : std::is_same_v<T, std::int32_t> ? "Int32"
                                                                               : "UInt8";
    const std::string_view tag = tag_of(name);
    if (tag.empty()) fail(fmt::format("it has no column '{}'", name));
    std::size_t offset = 0, given = 0;
    if (attribute(tag, "type") != type || !parse(attribute(tag, "NumberOfComponents"), given) || given != components)
      fail(fmt::format("its column '{}' has another type", name));
    const std::size_t bytes = points_ * components * sizeof(T), room = end_ - begin_;
    std::uint64_t stated = 0;
    if (!parse(attribute(tag, "offset"), offset) || offset > room || room - offset < sizeof stated)
      fail(fmt::format("its column '{}' lies outside of the file", name));
    std::memcpy(&stated, bytes_.data() + begin_ + offset, sizeof stated);
    if (stated != bytes || room - offset - sizeof stated < bytes)
      fail(fmt::format("its column '{}' has another length", name));
    std::vector<T> values(points_ * components);
    if (bytes != 0) std::memcpy(values.data(), bytes_.data() + begin_ + offset + sizeof stated, bytes);
    return values;
  }

 private:
  std::string_view element(std::string_view begin) const {
    const std::size_t at = xml_.find(begin);
    if (at == std::string_view::npos) return {};
    return xml_.substr(at, xml_.find('>', at) - at);
  }
  std::string_view tag_of(std::string_view name) const {
    for (std::size_t at = xml_.find("<DataArray"); at != std::string_view::npos; at = xml_.find("<DataArray", at + 1)) {
      const std::string_view tag = xml_.substr(at, xml_.find('>', at) - at);
      if (attribute(tag, "Name") == name && attribute(tag, "format") == "appended") return tag;
    }
    return {};
  }

  std::string path_;
  std::vector<std::uint8_t> bytes_;
  std::string_view xml_;
  std::size_t begin_ = 0, end_ = 0, points_ = 0;
};

/// Bodies of the frame `path`, from the file beside it.
void read_bodies(const std::string& path, const VtpFile& particles, Frame& f) {
  f.extra.push_back({"body", "", {}});
  for (const double id : particles.column<double>("body", 1)) f.extra.back().values.push_back(id);
  const std::filesystem::path file(path);
  const std::string name = file.filename().string();
  constexpr std::string_view mark = "particles-";
  const auto beside = file.parent_path() / ("bodies-" + name.substr(std::min(mark.size(), name.size())));
  std::error_code ignored;
  f.bodies_missing = !name.starts_with(mark) || !std::filesystem::is_regular_file(beside, ignored);
  if (f.bodies_missing) return;
  const VtpFile bodies(beside.string());
  const auto id = bodies.column<std::int64_t>("id", 1);
  const auto shape = bodies.column<std::int32_t>("shape", 1);
  const auto scale = bodies.column<double>("scale", 1), mass = bodies.column<double>("mass", 1),
             turn = bodies.column<double>("orientation", 4);
  const auto x = vectors_of(bodies.column<double>("Points", 3)), v = vectors_of(bodies.column<double>("velocity", 3)),
             w = vectors_of(bodies.column<double>("angular_velocity", 3));
  for (std::size_t k = 0; k < id.size(); ++k)
    f.bodies.push_back({id[k],
                        shape[k],
                        scale[k],
                        mass[k],
                        x[k],
                        v[k],
                        w[k],
                        {turn[4 * k], turn[4 * k + 1], turn[4 * k + 2], turn[4 * k + 3]},
                        {},
                        {}});
}

}  // namespace

Frame read_vtp(const std::string& path) {
  const VtpFile file(path);
  Frame f;
  f.step = step_of_name(path);
  f.time = file.time();
  f.x = vectors_of(file.column<double>("Points", 3));
  for (const ParticleQuantity& q : particle_quantities()) {
    if (q.take == nullptr || (q.wanted != nullptr && !file.has(q.name))) continue;
    ColumnValues values = q.values(Frame{});  // none, of the right type
    std::visit(
        [&](auto& v) {
          using T = typename std::remove_reference_t<decltype(v)>::value_type;
          v = file.column<T>(q.name, static_cast<std::size_t>(q.components));
        },
        values);
    q.take(f, std::move(values));
  }
  if (file.has("body")) read_bodies(path, file, f);
  for (const std::string& name : file.scalars())
    if (is_part_column(name)) f.extra.push_back({name, "", file.column<double>(name, 1)});
  return f;
}

PvdReader::PvdReader(const std::string& path) {
  const std::string text = read_file_text(path);
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::io, "cannot be read: " + what, path, "the list of particle frames of a run is expected");
  };
  if (text.find("<Collection>") == std::string::npos) fail("it is no .pvd list");
  if (!text.ends_with("</VTKFile>\n")) fail("it is cut off");
  const std::string folder = std::filesystem::path(path).parent_path().string();
  for (std::size_t at = text.find("<DataSet"); at != std::string::npos; at = text.find("<DataSet", at + 1)) {
    const std::string_view tag = std::string_view(text).substr(at, text.find('>', at) - at);
    const std::string name(attribute(tag, "file"));
    FrameTime entry;
    if (name.empty() || !parse(attribute(tag, "timestep"), entry.time)) fail("an entry is damaged");
    entry.step = step_of_name(name);
    if (!steps_.empty() && entry.step <= steps_.back().step) fail("its entries do not ascend");
    files_.push_back(name.front() == '/' || folder.empty() ? name : folder + "/" + name);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(files_.back(), ignored)) fail("'" + name + "' is not there");
    steps_.push_back(entry);
  }
}

Frame PvdReader::frame(std::size_t k) const {
  Frame f = read_vtp(files_.at(k));
  f.step = steps_[k].step;
  return f;
}

}  // namespace talus
