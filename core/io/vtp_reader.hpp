// Reads particle frames of write_vtp back: single .vtp files and the .pvd list of a run. Who calls it:
// core/io/particle_frames. Invariants: values have the bits that were written; a file that is cut, damaged or of
// another program is an error that says so, never a frame with fewer particles.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/frame/frame.hpp"

namespace talus {

struct FrameTime {
  std::int64_t step = 0;
  double time = 0;  ///< [s]
};

/// One frame with all columns that the file has; step: the number at the end of its name, else 0. Of a run with bodies
/// also the file of bodies beside it. Error{io}.
Frame read_vtp(const std::string& path);

/// The frames that a .pvd lists, ascending.
class PvdReader {
 public:
  /// Error{io}: no such file, not a list of this program, or a listed file is not there.
  explicit PvdReader(const std::string& path);
  const std::vector<FrameTime>& steps() const noexcept { return steps_; }
  Frame frame(std::size_t k) const;

 private:
  std::vector<FrameTime> steps_;
  std::vector<std::string> files_;
};

}  // namespace talus
