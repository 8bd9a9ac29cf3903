// What the VTKHDF writer and reader share of HDF5. Included by core/io/vtkhdf*.cpp only: no header shows hdf5.h.
#pragma once

#include <hdf5.h>

#include <utility>

#include "core/frame/columns.hpp"

namespace talus {

/// The library prints nothing (reasons go into Error) and does not clean up at exit: its clean-up writes what a full
/// disk has refused before, and crashes when that fails again.
inline void quiet_library() {
  static const bool once = H5dont_atexit() >= 0;
  static_cast<void>(once);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// Owns one HDF5 handle of any kind.
class Handle {
 public:
  Handle() = default;
  explicit Handle(hid_t id) : id_(id) {}
  Handle(Handle&& o) noexcept : id_(std::exchange(o.id_, -1)) {}
  Handle& operator=(Handle&& o) noexcept {
    std::swap(id_, o.id_);
    return *this;
  }
  ~Handle() { close(); }
  void close() noexcept {
    if (id_ >= 0) {
      switch (H5Iget_type(id_)) {
        case H5I_FILE:
          H5Fclose(id_);
          break;
        case H5I_GROUP:
          H5Gclose(id_);
          break;
        case H5I_DATASET:
          H5Dclose(id_);
          break;
        case H5I_DATASPACE:
          H5Sclose(id_);
          break;
        case H5I_DATATYPE:
          H5Tclose(id_);
          break;
        case H5I_ATTR:
          H5Aclose(id_);
          break;
        default:
          H5Pclose(id_);
          break;
      }
    }
    id_ = -1;
  }
  operator hid_t() const noexcept { return id_; }

 private:
  hid_t id_ = -1;
};

/// Type of a column's values in memory.
inline hid_t native_type(const ColumnValues& values) {
  switch (values.index()) {
    case 0:
      return H5T_NATIVE_DOUBLE;
    case 1:
      return H5T_NATIVE_INT64;
    case 2:
      return H5T_NATIVE_INT32;
    default:
      return H5T_NATIVE_UINT8;
  }
}

}  // namespace talus
