// VtkHdfWriter (and VtkHdfReader): particles, walls or contacts over time in one VTKHDF 2.0 temporal PolyData file
// (ParaView >= 5.12). Who calls it: cases/ (run), one object per file. Invariants: one part per step; NSteps is written
// last and the file is flushed before and after it, each time through core/io/hdf5_journal, so that a killed run or a
// failed write leaves a readable file that ends with a whole frame; times and bytes depend on the frames only.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/frame/quantities.hpp"

namespace talus {

class VtkHdfWriter {
 public:
  enum class Content { particles, walls, contacts };

  /// Creates the file, whole at once (an old one is replaced). `columns` matters for particles only. Error{io}.
  VtkHdfWriter(const std::string& path, const ParticleColumns& columns, Content content = Content::particles);
  /// Opens an existing file for appending and drops all frames later than `last_step` (the step of the checkpoint).
  /// A missing file is created. CannotContinue: not a file of this program, damaged, or other columns. Error{io}.
  static VtkHdfWriter resume(const std::string& path, const ParticleColumns& columns, Content content,
                             std::int64_t last_step);
  ~VtkHdfWriter();
  VtkHdfWriter(VtkHdfWriter&&) noexcept;
  VtkHdfWriter& operator=(VtkHdfWriter&&) noexcept;

  /// Appends one frame and flushes. Error{io}: no room (the file is as before), the file was deleted or changed by
  /// others, write failure, missing column, or a step not after last_step().
  void append(const Frame& frame);
  void check() const;                       ///< Error{io} if the file was deleted, replaced or truncated by others
  std::int64_t frames() const noexcept;     ///< in the file
  std::int64_t last_step() const noexcept;  ///< step of the last frame, -1 if none

 private:
  struct Impl;
  explicit VtkHdfWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Reads particle frames of a VtkHdfWriter back, for comparisons of two runs. Invariant: positions and velocities have
/// the bits that were written.
class VtkHdfReader {
 public:
  struct Step {
    std::int64_t step = 0;
    double time = 0;  ///< [s]
  };
  /// Error{io}: no such file, or not particles of this program.
  explicit VtkHdfReader(const std::string& path);
  ~VtkHdfReader();
  VtkHdfReader(VtkHdfReader&&) noexcept;
  const std::vector<Step>& steps() const noexcept;
  /// Frame k (0 <= k < steps().size()) with all particle columns that the file has.
  Frame frame(std::size_t k) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace talus
