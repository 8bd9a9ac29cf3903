// VTK XML files (.vtp polygons and points, .vti grids) with raw appended data, and the .pvd list of frames over time.
// Who calls it: cases/ (run). ParaView of any age, VTK 9 and OVITO read them. Invariant: every file appears whole
// (atomic_file), a .pvd never names a file that is not there yet.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/frame/columns.hpp"

namespace talus {

/// Writes one .vtp file of the frame at `time` [s]. Error{io}.
void write_vtp(const std::string& path, const PolyData& data, double time);

/// Writes one .vti file of the grid at `time` [s]. Error{io}.
void write_vti(const std::string& path, const GridData& data, double time);

/// Frames over time: FOLDER/STEM.pvd lists FOLDER/vtp/STEM-000000001200.EXT. Use: write path(step), then add(step,
/// time).
class PvdCollection {
 public:
  /// Starts an empty list; creates FOLDER/vtp. Error{io}.
  PvdCollection(std::string folder, std::string stem, std::string extension = "vtp");
  /// Continues a list after --resume: keeps frames up to `last_step`, deletes later files. A missing list is empty.
  static PvdCollection resume(const std::string& folder, const std::string& stem, std::int64_t last_step,
                              const std::string& extension = "vtp");
  std::string path(std::int64_t step) const;  ///< of the frame's file
  /// Lists a file that has been written; replaces the .pvd atomically. Error{io} if step is not after last_step().
  void add(std::int64_t step, double time);
  void check() const;  ///< Error{io} if the list or a frame's file was deleted or emptied by others
  std::int64_t last_step() const noexcept { return entries_.empty() ? -1 : entries_.back().step; }
  std::size_t size() const noexcept { return entries_.size(); }

 private:
  struct Entry {
    std::int64_t step;
    std::string time;  ///< as printed, so that a continued list keeps its bytes
  };
  std::string file_name(std::int64_t step) const;
  void write() const;
  std::string folder_, stem_, extension_;
  std::vector<Entry> entries_;
};

}  // namespace talus
