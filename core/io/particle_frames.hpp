// Particle frames over time, whatever the format of the files. Who calls it: cases/ (compare, convert, info, report).
// Invariant: positions and velocities have the bits that were written.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/frame/frame.hpp"
#include "core/io/vtp_reader.hpp"

namespace talus {

class ParticleFrames {
 public:
  /// `path`: a .pvd, .vtp or .vtkhdf file. Error{io}: it cannot be read; Error{usage}: another kind of file.
  explicit ParticleFrames(const std::string& path);
  ~ParticleFrames();
  ParticleFrames(ParticleFrames&&) noexcept;

  /// The file with the frames of a run folder (of two, the one that goes on longer); nothing where there is none.
  /// Error{io}: one of them cannot be read.
  static std::optional<std::string> find(const std::string& folder);

  const std::string& path() const noexcept { return path_; }
  const std::vector<FrameTime>& steps() const noexcept { return steps_; }
  Frame frame(std::size_t k) const;

 private:
  struct Source;
  std::string path_;
  std::vector<FrameTime> steps_;
  std::unique_ptr<Source> source_;
};

}  // namespace talus
