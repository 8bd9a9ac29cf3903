// The one way in which files of users are opened for reading. Who calls it: readers of scenes, particles, meshes,
// checkpoints and run folders. Invariants: only regular files are opened (a FIFO or a device is refused and never
// waited for); nothing larger than its kind may be, or than the memory that is left, is read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.hpp"

namespace talus {

/// What a file is to the reader that asks for it.
struct InputKind {
  ErrorCode code = ErrorCode::io;  ///< of every error about it
  std::string_view name = "file";  ///< for messages: "scene file", "mesh"
  std::uint64_t most_bytes = std::uint64_t{1} << 40;
  std::string_view cure = "give the path of a file";  ///< where there is no such file
};

/// A regular file open for reading.
class InputFile {
 public:
  /// Error{kind.code} in one line: empty name or one with a NUL byte, no such file, a folder, a FIFO, device or socket,
  /// no permission, too large.
  InputFile(const std::string& path, const InputKind& kind);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;
  std::uint64_t size() const noexcept { return size_; }  ///< [B] when it was opened
  /// Reads up to n bytes, fewer only at the end of the file. Error{kind.code}.
  std::size_t read(void* to, std::size_t n);
  int release() noexcept;  ///< the descriptor, which the caller closes

 private:
  std::string path_;
  InputKind kind_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

/// Whole content. Error{kind.code} as InputFile, and where it does not fit into the memory that is left.
std::string read_input_text(const std::string& path, const InputKind& kind);
std::vector<std::uint8_t> read_input_bytes(const std::string& path, const InputKind& kind);

}  // namespace talus
