// Datasets of an HDF5 file that grow row by row: created or opened, appended to, read, cut. Included by
// core/io/vtkhdf.cpp only: no header shows hdf5.h.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/io/hdf5_handle.hpp"

namespace talus {

/// Hdf5Rows of one chunked dataset that grows along its first axis.
struct Hdf5Rows {
  std::string name;
  Handle id;
  hid_t memory = -1;  ///< native type of the values
  hsize_t width = 1;
  bool matrix = false;  ///< rank 2 even when width is 1
  hsize_t rows = 0;
  hsize_t chunk = 0;                                       ///< rows per chunk
  static constexpr std::uint64_t k_room_index = 12 << 10;  ///< of a chunk, if all nodes of the index split
  /// Bytes that `n` more rows can take in the file: whole chunks, and their entries in the index.
  std::uint64_t room(hsize_t n) const {
    const hsize_t before = (rows + chunk - 1) / chunk, after = (rows + n + chunk - 1) / chunk;
    return (after - before) * (chunk * width * H5Tget_size(memory) + k_room_index);
  }
};

/// The file that has them. Errors name it; after one its handles are not to be closed, that would write again.
struct Hdf5RowsFile {
  std::string path;
  Handle file;
  mutable bool broken = false;  ///< the library failed: its handles stay open for good

  /// Error{io} with the library's own reason.
  [[noreturn]] void fail(const std::string& action) const;
  /// CannotContinue: the file is not laid out as this run would.
  [[noreturn]] void throw_other_layout(const std::string& why) const;
  template <class T>
  T check(T r, const char* action) const {
    if (r < 0) fail(action);
    return r;
  }
  /// Creates the dataset, or opens it when the file is resumed.
  void dataset(Hdf5Rows& r, const std::string& name, hid_t memory, hsize_t width, bool matrix, bool create,
               hsize_t chunk) const;
  void append_rows(Hdf5Rows& r, const void* data, hsize_t n) const;
  void append_value(Hdf5Rows& r, std::int64_t v) const { append_rows(r, &v, 1); }
  std::vector<std::int64_t> read_row(const Hdf5Rows& r, hsize_t row) const;
  std::int64_t read_value(const Hdf5Rows& r, hsize_t row) const { return read_row(r, row)[0]; }
  /// Leaves the first `rows`.
  void shrink(Hdf5Rows& r, hsize_t rows) const;
};

}  // namespace talus
