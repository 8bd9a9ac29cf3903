// VTKHDF writer; see vtkhdf.hpp. How VTK finds frame k (one part per step, so PartOffsets[k] = k): points at
// PointOffsets[k]; the cell offsets of a kind at CellOffsets[k] + (number of parts before k), since every part stores
// NumberOfCells + 1 of them; connectivity at ConnectivityIdOffsets[k]. VTK up to 9.3 counts all parts before k; later
// ones count parts only until the cells before the frame are reached, which skips empty parts directly before it. A
// spare entry where a kind has cells right after an empty frame (CellOffsets then runs one ahead) makes both agree.
#include "core/io/vtkhdf.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/base/error.hpp"
#include "core/io/hdf5_handle.hpp"
#include "core/io/hdf5_journal.hpp"
#include "core/io/hdf5_rows.hpp"
#include "core/io/scratch.hpp"
#include "core/io/watched_file.hpp"

namespace talus {

namespace {

constexpr std::array<const char*, 4> k_kinds{"Vertices", "Lines", "Polygons", "Strips"};
constexpr hsize_t k_chunk_rows = 4096,
                  k_chunk_steps = 64;  ///< of columns that grow with the particles, with the frames
// Of the library's own blocks: what a new file takes, and what any frame may.
constexpr std::uint64_t k_room_file = 256 << 10, k_room_frame = 16 << 10;

}  // namespace

struct VtkHdfWriter::Impl : Hdf5RowsFile {
  ParticleColumns columns;
  Content content = Content::particles;
  Handle steps_group;
  Hdf5Rows number_of_points, points;
  struct Kind {
    Hdf5Rows cells, ids, offsets, connectivity;
    hsize_t cell_base = 0;  ///< next CellOffsets entry (cells written, plus one after a spare entry)
    bool spare = false, empty_before = false;
  };
  std::array<Kind, 4> kinds;
  Hdf5Rows values, part_offsets, number_of_parts, point_offsets, cell_offsets, connectivity_offsets, step_numbers;
  std::vector<Hdf5Rows> point_data, point_data_offsets, cell_data, cell_data_offsets;
  std::int64_t frames = 0, last_step = -1;
  WatchedFile watched;

  PolyData poly(const Frame& frame) const {
    return content == Content::walls      ? wall_poly(frame)
           : content == Content::contacts ? contact_poly(frame)
                                          : particle_poly(frame, columns);
  }

  void group(const char* name) {
    Handle g(check(H5Gcreate2(file, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), "create a group"));
  }
  void write_n_steps() {
    Handle a(check(H5Aopen(steps_group, "NSteps", H5P_DEFAULT), "open NSteps"));
    check(H5Awrite(a, H5T_NATIVE_INT64, &frames), "write NSteps");
  }
  /// What was written so far is the file from now on.
  void flush() {
    check(H5Fflush(file, H5F_SCOPE_LOCAL), "flush");
    if (commit_journal(file)) return;
    broken = true;
    throw Error(ErrorCode::io, std::string("cannot write: ") + std::strerror(errno), path,
                "check free space and permissions; frames written before stay readable");
  }

  /// All datasets of the file, created or opened.
  void datasets(bool create) {
    if (create) {
      for (const char* g : {"/VTKHDF", "/VTKHDF/PointData", "/VTKHDF/CellData", "/VTKHDF/FieldData", "/VTKHDF/Steps",
                            "/VTKHDF/Steps/PointDataOffsets", "/VTKHDF/Steps/CellDataOffsets", "/talus"})
        group(g);
      for (const char* k : k_kinds) group((std::string("/VTKHDF/") + k).c_str());
    }
    const auto i64 = H5T_NATIVE_INT64;
    const std::string root = "/VTKHDF/", steps = "/VTKHDF/Steps/";
    const auto per_frame = [&](Hdf5Rows& r, const std::string& name, hsize_t width = 1) {
      dataset(r, name, i64, width, false, create, k_chunk_steps);
    };
    per_frame(number_of_points, root + "NumberOfPoints");
    dataset(points, root + "Points", H5T_NATIVE_DOUBLE, 3, true, create, k_chunk_rows);
    for (int k = 0; k < 4; ++k) {
      const std::string base = root + k_kinds[k] + "/";
      per_frame(kinds[k].cells, base + "NumberOfCells");
      per_frame(kinds[k].ids, base + "NumberOfConnectivityIds");
      dataset(kinds[k].offsets, base + "Offsets", i64, 1, false, create, k_chunk_rows);
      dataset(kinds[k].connectivity, base + "Connectivity", i64, 1, false, create, k_chunk_rows);
    }
    dataset(values, steps + "Values", H5T_NATIVE_DOUBLE, 1, false, create, k_chunk_steps);
    per_frame(part_offsets, steps + "PartOffsets");
    per_frame(number_of_parts, steps + "NumberOfParts");
    per_frame(point_offsets, steps + "PointOffsets");
    per_frame(cell_offsets, steps + "CellOffsets", 4);
    per_frame(connectivity_offsets, steps + "ConnectivityIdOffsets", 4);
    // Step numbers are no VTK concept: readers ignore groups outside /VTKHDF.
    per_frame(step_numbers, "/talus/step");

    Frame none;  // shows the columns
    for (const std::string& name : columns.contact_extra()) none.contact_extra.push_back({name, "", {}});
    const PolyData p = poly(none);
    const auto fields = [&](const std::vector<PolyColumn>& columns_of, const std::string& place,
                            std::vector<Hdf5Rows>& data, std::vector<Hdf5Rows>& offsets) {
      data.resize(columns_of.size());
      offsets.resize(columns_of.size());
      for (std::size_t c = 0; c < columns_of.size(); ++c) {
        const PolyColumn& col = columns_of[c];
        dataset(data[c], root + place + "/" + col.name, native_type(col.values), static_cast<hsize_t>(col.components),
                false, create, k_chunk_rows);
        per_frame(offsets[c], steps + place + "Offsets/" + col.name);
      }
      Handle g(check(H5Gopen2(file, (root + place).c_str(), H5P_DEFAULT), "open a group"));
      H5G_info_t info{};
      check(H5Gget_info(g, &info), "read a group");
      if (info.nlinks != columns_of.size()) throw_other_layout("it has other columns than this run");
    };
    fields(p.point_data, "PointData", point_data, point_data_offsets);
    fields(p.cell_data, "CellData", cell_data, cell_data_offsets);
  }

  void attributes() {
    Handle root(check(H5Gopen2(file, "/VTKHDF", H5P_DEFAULT), "open a group"));
    // VTK compares this attribute byte by byte: a fixed ASCII string of exactly 8 bytes.
    Handle text(check(H5Tcopy(H5T_C_S1), "create a type"));
    check(H5Tset_size(text, 8), "create a type");
    check(H5Tset_strpad(text, H5T_STR_NULLPAD), "create a type");
    check(H5Tset_cset(text, H5T_CSET_ASCII), "create a type");
    Handle scalar(check(H5Screate(H5S_SCALAR), "create a dataspace"));
    Handle type(check(H5Acreate2(root, "Type", text, scalar, H5P_DEFAULT, H5P_DEFAULT), "create Type"));
    check(H5Awrite(type, text, "PolyData"), "write Type");
    const hsize_t two = 2;
    const std::int64_t version[2] = {2, 0};
    Handle pair(check(H5Screate_simple(1, &two, nullptr), "create a dataspace"));
    Handle v(check(H5Acreate2(root, "Version", H5T_STD_I64LE, pair, H5P_DEFAULT, H5P_DEFAULT), "create Version"));
    check(H5Awrite(v, H5T_NATIVE_INT64, version), "write Version");
    Handle n(
        check(H5Acreate2(steps_group, "NSteps", H5T_STD_I64LE, scalar, H5P_DEFAULT, H5P_DEFAULT), "create NSteps"));
    check(H5Awrite(n, H5T_NATIVE_INT64, &frames), "write NSteps");
  }

  Handle access() const {
    Handle p(check(H5Pcreate(H5P_FILE_ACCESS), "prepare the file"));
    // Viewers may look at a running simulation: take no exclusive lock.
    check(H5Pset_file_locking(p, false, true), "prepare the file");
    check(use_journal(p) ? 0 : -1, "prepare the file");
    return p;
  }

  /// A file that others have changed is left to them: closing it would write into it.
  void check_untouched(void (WatchedFile::*check_of)() const = &WatchedFile::check) const {
    try {
      (watched.*check_of)();
    } catch (...) {
      broken = true;
      throw;
    }
  }
  std::uint64_t library_size() const {
    hsize_t size = 0;
    check(H5Fget_filesize(file, &size), "get the size");
    return size;
  }
  void reserve(std::uint64_t bytes) { watched.reserve(bytes); }
  /// After a flush: cuts the room that was not needed.
  void settle() {
    check_untouched(&WatchedFile::check_room);
    const std::uint64_t size = library_size();
    watched.release(size);
    watched.mark(size);
  }

  /// The file appears under its name when it is whole: readers, and a run that is killed here, never leave a torso.
  void create() {
    const std::string scratch = scratch_beside(path);
    try {
      const int fd = ::open(scratch.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (fd < 0)
        throw Error(ErrorCode::io, std::string("cannot create: ") + std::strerror(errno), path,
                    "choose a folder that you may write to");
      ::close(fd);
      Handle fapl = access();
      file = Handle(check(H5Fcreate(scratch.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, fapl), "create"));
      watched = WatchedFile(scratch);
      watched.renamed(path);
      reserve(k_room_file);
      datasets(true);
      steps_group = Handle(check(H5Gopen2(file, "/VTKHDF/Steps", H5P_DEFAULT), "open a group"));
      attributes();
      flush();
      settle();
      if (std::rename(scratch.c_str(), path.c_str()) != 0)
        throw Error(ErrorCode::io, std::string("cannot create: ") + std::strerror(errno), path);
    } catch (...) {
      static_cast<void>(std::remove(scratch.c_str()));
      throw;
    }
  }

  void open(std::int64_t resume_step) {
    watched = WatchedFile(path);
    Handle fapl = access();
    file = Handle(H5Fopen(path.c_str(), H5F_ACC_RDWR, fapl));
    if (file < 0) throw_other_layout("it cannot be read as HDF5");
    reserve(k_room_file);
    datasets(false);
    steps_group = Handle(H5Gopen2(file, "/VTKHDF/Steps", H5P_DEFAULT));
    if (steps_group < 0) throw_other_layout("it has no steps");
    Handle a(H5Aopen(steps_group, "NSteps", H5P_DEFAULT));
    if (a < 0) throw_other_layout("it has no NSteps");
    check(H5Aread(a, H5T_NATIVE_INT64, &frames), "read NSteps");
    if (frames < 0) throw_other_layout("NSteps is negative");
    const std::int64_t before = frames;
    while (frames > 0 && read_value(step_numbers, static_cast<hsize_t>(frames - 1)) > resume_step) --frames;
    last_step = frames > 0 ? read_value(step_numbers, static_cast<hsize_t>(frames - 1)) : -1;
    // First forget the frames, then cut their data: a kill in between leaves unused rows, which append overwrites.
    if (frames != before) write_n_steps();
    flush();
    cut();
    flush();
    settle();
  }
  void cut() {
    const auto n = static_cast<hsize_t>(frames);
    hsize_t n_points = 0, n_cells = 0;
    std::array<hsize_t, 4> n_offsets{}, n_ids{};
    if (n > 0) {
      n_points = static_cast<hsize_t>(read_value(point_offsets, n - 1) + read_value(number_of_points, n - 1));
      const auto cell_row = read_row(cell_offsets, n - 1), id_row = read_row(connectivity_offsets, n - 1);
      for (int k = 0; k < 4; ++k) {
        const std::int64_t cells = read_value(kinds[k].cells, n - 1);
        kinds[k].cell_base = static_cast<hsize_t>(cell_row[k] + cells);
        kinds[k].empty_before = cells == 0;
        n_offsets[k] = kinds[k].cell_base + n;
        n_ids[k] = static_cast<hsize_t>(id_row[k] + read_value(kinds[k].ids, n - 1));
        hsize_t cells_written = 0;
        for (hsize_t f = 0; f < n; ++f) cells_written += static_cast<hsize_t>(read_value(kinds[k].cells, f));
        kinds[k].spare = kinds[k].cell_base != cells_written;
        n_cells += cells_written;
      }
    }
    for (Hdf5Rows* r : {&number_of_points, &values, &part_offsets, &number_of_parts, &point_offsets, &cell_offsets,
                        &connectivity_offsets, &step_numbers})
      shrink(*r, n);
    shrink(points, n_points);
    for (int k = 0; k < 4; ++k) {
      shrink(kinds[k].cells, n);
      shrink(kinds[k].ids, n);
      shrink(kinds[k].offsets, n_offsets[k]);
      shrink(kinds[k].connectivity, n_ids[k]);
    }
    for (Hdf5Rows& r : point_data) shrink(r, n_points);
    for (Hdf5Rows& r : cell_data) shrink(r, n_cells);
    for (auto* group_of : {&point_data_offsets, &cell_data_offsets})
      for (Hdf5Rows& r : *group_of) shrink(r, n);
  }

  void append_columns(const std::vector<PolyColumn>& from, std::vector<Hdf5Rows>& to, std::vector<Hdf5Rows>& offsets) {
    for (std::size_t c = 0; c < from.size(); ++c) {
      append_value(offsets[c], static_cast<std::int64_t>(to[c].rows));
      std::visit([&](const auto& v) { append_rows(to[c], v.data(), v.size() / to[c].width); }, from[c].values);
    }
  }

  void append_kind(int k, std::int64_t n_cells, std::int64_t per_cell, const std::vector<std::int64_t>& connectivity,
                   std::array<std::int64_t, 4>& cell_row, std::array<std::int64_t, 4>& id_row) {
    Kind& kind = kinds[k];
    if (n_cells > 0 && kind.empty_before && !kind.spare) {
      append_value(kind.offsets, 0);
      kind.spare = true;
      ++kind.cell_base;
    }
    cell_row[k] = static_cast<std::int64_t>(kind.cell_base);
    id_row[k] = static_cast<std::int64_t>(kind.connectivity.rows);
    append_value(kind.cells, n_cells);
    append_value(kind.ids, static_cast<std::int64_t>(connectivity.size()));
    std::vector<std::int64_t> ends(static_cast<std::size_t>(n_cells) + 1);
    for (std::size_t c = 0; c < ends.size(); ++c) ends[c] = static_cast<std::int64_t>(c) * per_cell;
    append_rows(kind.offsets, ends.data(), ends.size());
    append_rows(kind.connectivity, connectivity.data(), connectivity.size());
    kind.cell_base += static_cast<hsize_t>(n_cells);
    kind.empty_before = n_cells == 0;
  }

  void append(const Frame& frame) {
    if (frame.step <= last_step)
      throw Error(ErrorCode::io,
                  "frame of step " + std::to_string(frame.step) + " does not come after the last one (" +
                      std::to_string(last_step) + ")",
                  path, "each step is written once");
    if (broken)
      throw Error(ErrorCode::io, "was given up after a failed write", path, "resume from the newest checkpoint");
    check_untouched();
    const PolyData p = poly(frame);
    reserve(room(p));
    const auto n_points = static_cast<std::int64_t>(p.points.size());
    append_rows(values, &frame.time, 1);
    append_value(step_numbers, frame.step);
    append_value(part_offsets, frames);
    append_value(number_of_parts, 1);
    append_value(point_offsets, static_cast<std::int64_t>(points.rows));
    append_value(number_of_points, n_points);
    static_assert(sizeof(Vec3) == 3 * sizeof(double));
    append_rows(points, p.points.data(), p.points.size());
    std::array<std::int64_t, 4> cell_row{}, id_row{};
    std::vector<std::int64_t> ids;
    if (p.vertices) {
      ids.resize(p.points.size());
      for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = static_cast<std::int64_t>(i);
    }
    append_kind(0, p.vertices ? n_points : 0, 1, ids, cell_row, id_row);
    append_kind(1, 0, 1, {}, cell_row, id_row);
    ids.clear();
    for (const auto& t : p.triangles) ids.insert(ids.end(), t.begin(), t.end());
    append_kind(2, static_cast<std::int64_t>(p.triangles.size()), 3, ids, cell_row, id_row);
    append_kind(3, 0, 1, {}, cell_row, id_row);
    append_rows(cell_offsets, cell_row.data(), 1);
    append_rows(connectivity_offsets, id_row.data(), 1);
    append_columns(p.point_data, point_data, point_data_offsets);
    append_columns(p.cell_data, cell_data, cell_data_offsets);
    flush();
    ++frames;
    last_step = frame.step;
    write_n_steps();
    flush();
    settle();
  }

  /// Upper bound of what a frame adds to the file, so that a full disk is seen before the library begins to write.
  std::uint64_t room(const PolyData& p) const {
    const hsize_t n = p.points.size(), verts = p.vertices ? n : 0, polys = p.triangles.size();
    std::uint64_t bytes = k_room_frame + points.room(n);
    for (const Hdf5Rows* r : {&number_of_points, &values, &part_offsets, &number_of_parts, &point_offsets,
                              &cell_offsets, &connectivity_offsets, &step_numbers})
      bytes += r->room(1);
    for (std::size_t k = 0; k < kinds.size(); ++k) {
      const hsize_t cells = k == 0 ? verts : k == 2 ? polys : 0;
      bytes += kinds[k].cells.room(1) + kinds[k].ids.room(1) + kinds[k].offsets.room(cells + 2);
      bytes += kinds[k].connectivity.room(k == 2 ? 3 * cells : cells);
    }
    for (const auto* columns_of : {&point_data_offsets, &cell_data_offsets})
      for (const Hdf5Rows& r : *columns_of) bytes += r.room(1);
    for (const Hdf5Rows& r : point_data) bytes += r.room(n);
    for (const Hdf5Rows& r : cell_data) bytes += r.room(verts + polys);
    return bytes;
  }
};

VtkHdfWriter::VtkHdfWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VtkHdfWriter::VtkHdfWriter(VtkHdfWriter&&) noexcept = default;
VtkHdfWriter& VtkHdfWriter::operator=(VtkHdfWriter&&) noexcept = default;
VtkHdfWriter::~VtkHdfWriter() {
  if (!impl_ || !impl_->broken) return;
  static auto* const abandoned = new std::vector<Impl*>;  // still known, so that no tool takes them for lost
  abandoned->push_back(impl_.release());
}

VtkHdfWriter::VtkHdfWriter(const std::string& path, const ParticleColumns& columns, Content content)
    : VtkHdfWriter(std::make_unique<Impl>()) {
  quiet_library();
  impl_->path = path;
  impl_->columns = columns;
  impl_->content = content;
  impl_->create();  // the object exists already: its destructor runs if this throws
}

VtkHdfWriter VtkHdfWriter::resume(const std::string& path, const ParticleColumns& columns, Content content,
                                  std::int64_t last_step) {
  if (!std::filesystem::exists(path)) return VtkHdfWriter(path, columns, content);
  quiet_library();
  VtkHdfWriter writer(std::make_unique<Impl>());
  Impl& m = *writer.impl_;
  m.path = path;
  m.columns = columns;
  m.content = content;
  try {
    m.open(last_step);
  } catch (const CannotContinue&) {
    if (m.file >= 0) m.settle();  // as it was found
    throw;
  } catch (const Error&) {
    if (m.broken) throw CannotContinue("it is damaged", path);
    throw;
  }
  return writer;
}

void VtkHdfWriter::append(const Frame& frame) { impl_->append(frame); }
void VtkHdfWriter::check() const { impl_->check_untouched(); }
std::int64_t VtkHdfWriter::frames() const noexcept { return impl_->frames; }
std::int64_t VtkHdfWriter::last_step() const noexcept { return impl_->last_step; }

}  // namespace talus
