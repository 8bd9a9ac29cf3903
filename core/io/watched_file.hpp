// A file that a run keeps open and appends to: was it taken away or changed by others, and is there room for more?
// Who calls it: core/io (series, vtkhdf). Invariant: only looks at the file and reserves space behind its end.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

#include "core/base/error.hpp"

namespace talus {

/// A file of an earlier run that this one cannot append to: it has another layout or is damaged.
class CannotContinue : public Error {
 public:
  CannotContinue(const std::string& reason, const std::string& path)
      : Error(ErrorCode::io, "cannot be continued: " + reason, path,
              "resume with the scene that wrote it, or write to another folder"),
        why_(path + " cannot be continued: " + reason) {}
  const std::string& why() const noexcept { return why_; }  ///< without the cure

 private:
  std::string why_;
};

class WatchedFile {
 public:
  WatchedFile() = default;
  /// Opens `path`, which exists. Error{io}.
  explicit WatchedFile(std::string path);
  ~WatchedFile();
  WatchedFile(WatchedFile&& o) noexcept { *this = static_cast<WatchedFile&&>(o); }
  WatchedFile& operator=(WatchedFile&& o) noexcept;

  int fd() const noexcept { return fd_; }
  const std::string& path() const noexcept { return path_; }
  void renamed(std::string path) { path_ = std::move(path); }
  /// The given size is the right one from now on. Never ask the file for it: others may have changed it by then.
  void mark(std::uint64_t size) {
    size_ = static_cast<off_t>(size);
    room_end_ = 0;
  }
  /// Error{io} if the file has been deleted, replaced, or has another size than at mark().
  void check() const;
  /// Makes room for `bytes` behind the end, or Error{io} with the system's reason and nothing changed. The file may be
  /// longer afterwards; release() cuts it.
  void reserve(std::uint64_t bytes);
  /// Error{io} if the room of reserve() is not there any more: somebody cut the file while it was written.
  void check_room() const;
  void release(std::uint64_t size);

 private:
  [[noreturn]] void fail(const char* what) const;

  std::string path_;
  int fd_ = -1;
  off_t size_ = 0;      ///< at mark()
  off_t room_end_ = 0;  ///< of reserve() until mark(); 0: none
};

}  // namespace talus
