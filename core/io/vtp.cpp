// VTK XML writers; see vtp.hpp. Data blocks are raw: uint64 byte count, then little-endian values.
#include "core/io/vtp.hpp"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <filesystem>

#include "core/base/error.hpp"
#include "core/io/atomic_file.hpp"
#include "core/io/watched_file.hpp"

namespace talus {

namespace {

static_assert(std::endian::native == std::endian::little, "appended data is declared little endian");

/// Collects blocks while the XML is composed, then writes both.
class XmlFile {
 public:
  explicit XmlFile(const char* type) {
    xml_ = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{0}\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n",
        type);
  }
  void text(const std::string& s) { xml_ += s; }
  /// A DataArray element whose values lie in the appended section; `data` must live until write().
  void array(const char* type, const std::string& name, int components, const void* data, std::size_t bytes) {
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
        name, components, offset_);
    blocks_.push_back({data, bytes});
    offset_ += bytes + sizeof(std::uint64_t);
  }
  void column(const PolyColumn& c) {
    static constexpr const char* names[] = {"Float64", "Int64", "Int32", "UInt8"};
    std::visit(
        [&](const auto& v) { array(names[c.values.index()], c.name, c.components, v.data(), v.size() * sizeof(v[0])); },
        c.values);
  }
  void write(const std::string& path) {
    AtomicFile out(path);
    xml_ += "<AppendedData encoding=\"raw\">\n_";
    out.write(xml_);
    for (const Block& b : blocks_) {
      const std::uint64_t n = b.bytes;
      out.write(&n, sizeof n);
      if (n != 0) out.write(b.data, b.bytes);
    }
    out.write("\n</AppendedData>\n</VTKFile>\n");
    out.commit();
  }

 private:
  struct Block {
    const void* data;
    std::size_t bytes;
  };
  std::string xml_;
  std::vector<Block> blocks_;
  std::size_t offset_ = 0;
};

std::string time_field(double time) {
  return fmt::format(
      "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}"
      "</DataArray></FieldData>\n",
      time);
}

}  // namespace

void write_vtp(const std::string& path, const PolyData& data, double time) {
  const std::size_t n = data.points.size(), verts = data.vertices ? n : 0, polys = data.triangles.size();
  std::vector<std::int64_t> vert_ids(verts), vert_ends(verts), poly_ids, poly_ends(polys);
  for (std::size_t i = 0; i < verts; ++i) {
    vert_ids[i] = static_cast<std::int64_t>(i);
    vert_ends[i] = static_cast<std::int64_t>(i) + 1;
  }
  poly_ids.reserve(3 * polys);
  for (std::size_t t = 0; t < polys; ++t) {
    poly_ids.insert(poly_ids.end(), data.triangles[t].begin(), data.triangles[t].end());
    poly_ends[t] = 3 * static_cast<std::int64_t>(t) + 3;
  }
  XmlFile f("PolyData");
  f.text("<PolyData>\n" + time_field(time));
  f.text(
      fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
                  "NumberOfPolys=\"{}\">\n<PointData>\n",
                  n, verts, polys));
  for (const PolyColumn& c : data.point_data) f.column(c);
  f.text("</PointData>\n<CellData>\n");
  for (const PolyColumn& c : data.cell_data) f.column(c);
  f.text("</CellData>\n<Points>\n");
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  f.array("Float64", "Points", 3, data.points.data(), n * sizeof(Vec3));
  const auto cells = [&](const char* kind, const std::vector<std::int64_t>& ids,
                         const std::vector<std::int64_t>& ends) {
    f.text(fmt::format("<{}>\n", kind));
    f.array("Int64", "connectivity", 1, ids.data(), ids.size() * sizeof(ids[0]));
    f.array("Int64", "offsets", 1, ends.data(), ends.size() * sizeof(ends[0]));
    f.text(fmt::format("</{}>\n", kind));
  };
  f.text("</Points>\n");
  cells("Verts", vert_ids, vert_ends);
  cells("Polys", poly_ids, poly_ends);
  f.text("</Piece>\n</PolyData>\n");
  f.write(path);
}

void write_vti(const std::string& path, const GridData& g, double time) {
  const std::string extent = fmt::format("0 {} 0 {} 0 {}", g.cells[0], g.cells[1], g.cells[2]);
  XmlFile f("ImageData");
  f.text(fmt::format("<ImageData WholeExtent=\"{}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\">\n", extent, g.lower.x,
                     g.lower.y, g.lower.z, g.spacing.x, g.spacing.y, g.spacing.z));
  f.text(time_field(time));
  f.text(fmt::format("<Piece Extent=\"{}\">\n<PointData/>\n<CellData>\n", extent));
  for (const PolyColumn& c : g.cell_data) f.column(c);
  f.text("</CellData>\n</Piece>\n</ImageData>\n");
  f.write(path);
}

PvdCollection::PvdCollection(std::string folder, std::string stem, std::string extension)
    : folder_(std::move(folder)), stem_(std::move(stem)), extension_(std::move(extension)) {
  std::error_code error;
  std::filesystem::create_directories(folder_ + "/vtp", error);
  if (error) throw Error(ErrorCode::io, "cannot create folder: " + error.message(), folder_ + "/vtp");
}

std::string PvdCollection::file_name(std::int64_t step) const {
  return fmt::format("vtp/{}-{:012}.{}", stem_, step, extension_);
}

void PvdCollection::check() const {
  const auto there = [](const std::string& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error) || std::filesystem::file_size(path, error) == 0 || error)
      throw Error(ErrorCode::io, "was deleted or emptied during the run", path,
                  "leave the files of a run alone until it has ended; --resume continues it");
  };
  if (entries_.empty()) return;
  there(folder_ + "/" + stem_ + ".pvd");
  for (const Entry& e : entries_) there(folder_ + "/" + file_name(e.step));
}

std::string PvdCollection::path(std::int64_t step) const { return folder_ + "/" + file_name(step); }

void PvdCollection::write() const {
  std::string s =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (const Entry& e : entries_)
    s += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", e.time, file_name(e.step));
  s += "</Collection>\n</VTKFile>\n";
  write_file_atomic(folder_ + "/" + stem_ + ".pvd", s);
}

void PvdCollection::add(std::int64_t step, double time) {
  if (step <= last_step())
    throw Error(ErrorCode::io, fmt::format("frame of step {} does not come after the last one ({})", step, last_step()),
                folder_ + "/" + stem_ + ".pvd", "each step is written once");
  entries_.push_back({step, fmt::format("{}", time)});
  write();
}

PvdCollection PvdCollection::resume(const std::string& folder, const std::string& stem, std::int64_t last_step,
                                    const std::string& extension) {
  PvdCollection c(folder, stem, extension);
  const std::string list = folder + "/" + stem + ".pvd";
  if (!std::filesystem::exists(list)) return c;
  const std::string text = read_file_text(list);
  // Only lines of the form that write() produces count: step and time stand between fixed words.
  const std::string open = "<DataSet timestep=\"", middle = "\" part=\"0\" file=\"vtp/" + stem + "-";
  bool dropped = false;
  for (std::size_t at = text.find(open); at != std::string::npos; at = text.find(open, at + 1)) {
    const std::size_t begin = at + open.size(), end = text.find(middle, begin);
    if (end == std::string::npos) break;
    const char* digits = text.data() + end + middle.size();
    std::int64_t step = -1;
    const auto parsed = std::from_chars(digits, text.data() + text.size(), step);
    if (parsed.ec != std::errc() || step <= c.last_step()) throw CannotContinue("the list of frames is damaged", list);
    if (step <= last_step) {
      c.entries_.push_back({step, text.substr(begin, end - begin)});
    } else {
      dropped = true;
    }
  }
  if (dropped) c.write();
  // After the list no longer names them: files of later frames, also one whose listing a kill prevented.
  std::error_code error;
  for (const auto& file : std::filesystem::directory_iterator(folder + "/vtp", error)) {
    const std::string name = file.path().filename().string(), prefix = stem + "-";
    std::int64_t step = -1;
    if (name.compare(0, prefix.size(), prefix) != 0 || file.path().extension() != "." + extension) continue;
    const auto parsed = std::from_chars(name.data() + prefix.size(), name.data() + name.size(), step);
    if (parsed.ec == std::errc() && step > last_step) std::filesystem::remove(file.path(), error);
  }
  return c;
}

}  // namespace talus
