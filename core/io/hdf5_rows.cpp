// See hdf5_rows.hpp.
#include "core/io/hdf5_rows.hpp"

#include "core/base/error.hpp"
#include "core/io/watched_file.hpp"

namespace talus {
namespace {

herr_t innermost(unsigned n, const H5E_error2_t* e, void* out) {
  if (n == 0 && e->desc != nullptr) *static_cast<std::string*>(out) = e->desc;
  return 0;
}

hid_t file_type(hid_t native) {
  if (H5Tequal(native, H5T_NATIVE_DOUBLE) > 0) return H5T_IEEE_F64LE;
  if (H5Tequal(native, H5T_NATIVE_INT64) > 0) return H5T_STD_I64LE;
  if (H5Tequal(native, H5T_NATIVE_INT32) > 0) return H5T_STD_I32LE;
  return H5T_STD_U8LE;
}

}  // namespace

void Hdf5RowsFile::fail(const std::string& action) const {
  broken = true;
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, innermost, &reason);
  throw Error(ErrorCode::io, "cannot " + action + (reason.empty() ? "" : ": " + reason), path,
              "check free space and permissions; frames written before stay readable");
}

void Hdf5RowsFile::throw_other_layout(const std::string& why) const { throw CannotContinue(why, path); }

void Hdf5RowsFile::dataset(Hdf5Rows& r, const std::string& name, hid_t memory, hsize_t width, bool matrix, bool create,
                           hsize_t chunk) const {
  r.name = name;
  r.memory = memory;
  r.width = width;
  r.chunk = chunk;
  r.matrix = matrix || width > 1;
  const int rank = r.matrix ? 2 : 1;
  if (create) {
    const hsize_t size[2] = {0, width}, most[2] = {H5S_UNLIMITED, width}, chunks[2] = {chunk, width};
    Handle space(check(H5Screate_simple(rank, size, most), "create a dataspace"));
    Handle plist(check(H5Pcreate(H5P_DATASET_CREATE), "create a dataset"));
    check(H5Pset_chunk(plist, rank, chunks), "create a dataset");
    // Same frames, same bytes: no creation dates. Not compressed: rewriting a compressed chunk moves it, and a kill
    // between two flushes could then lose frames that were safe before.
    check(H5Pset_obj_track_times(plist, false), "create a dataset");
    r.id = Handle(check(H5Dcreate2(file, name.c_str(), file_type(memory), space, H5P_DEFAULT, plist, H5P_DEFAULT),
                        "create a dataset"));
    r.rows = 0;
    return;
  }
  r.id = Handle(H5Dopen2(file, name.c_str(), H5P_DEFAULT));
  if (r.id < 0) throw_other_layout("it has no '" + name + "'");
  Handle space(check(H5Dget_space(r.id), "read a dataspace"));
  hsize_t size[2] = {0, 1};
  if (H5Sget_simple_extent_ndims(space) != rank || H5Sget_simple_extent_dims(space, size, nullptr) < 0 ||
      (rank == 2 && size[1] != width))
    throw_other_layout("'" + name + "' has another shape");
  r.rows = size[0];
}

void Hdf5RowsFile::append_rows(Hdf5Rows& r, const void* data, hsize_t n) const {
  if (n == 0) return;
  const int rank = r.matrix ? 2 : 1;
  const hsize_t total[2] = {r.rows + n, r.width}, start[2] = {r.rows, 0}, count[2] = {n, r.width};
  check(H5Dset_extent(r.id, total), "extend a dataset");
  Handle space(check(H5Dget_space(r.id), "write"));
  check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr), "write");
  Handle memory(check(H5Screate_simple(rank, count, nullptr), "write"));
  check(H5Dwrite(r.id, r.memory, memory, space, H5P_DEFAULT, data), "write");
  r.rows += n;
}

std::vector<std::int64_t> Hdf5RowsFile::read_row(const Hdf5Rows& r, hsize_t row) const {
  if (row >= r.rows) throw_other_layout("'" + r.name + "' is shorter than its number of steps");
  std::vector<std::int64_t> out(r.width);
  const hsize_t start[2] = {row, 0}, count[2] = {1, r.width};
  Handle space(check(H5Dget_space(r.id), "read"));
  check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr), "read");
  Handle memory(check(H5Screate_simple(r.matrix ? 2 : 1, count, nullptr), "read"));
  check(H5Dread(r.id, H5T_NATIVE_INT64, memory, space, H5P_DEFAULT, out.data()), "read");
  return out;
}

void Hdf5RowsFile::shrink(Hdf5Rows& r, hsize_t rows) const {
  if (rows > r.rows) throw_other_layout("'" + r.name + "' is shorter than its steps say");
  const hsize_t size[2] = {rows, r.width};
  check(H5Dset_extent(r.id, size), "cut a dataset");
  r.rows = rows;
}

}  // namespace talus
