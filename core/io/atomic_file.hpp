// Durable replacement of a file: scratch file beside it -> write -> fsync -> rename -> fsync(directory). Who calls it:
// checkpoints, .vtp/.pvd, summary.json, the run folder. Invariant: at every instant PATH is the whole old file or the
// whole new one; after an error the old file is untouched and the scratch file is gone.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace talus {

/// The system calls below this module; tests replace them to make any call fail. Same contracts as POSIX (-1 and
/// errno).
class FileCalls {
 public:
  virtual ~FileCalls() = default;
  virtual int open(const char* path, int flags, unsigned mode);
  virtual ssize_t write(int fd, const void* data, std::size_t n);
  virtual int fsync(int fd);
  virtual int close(int fd);
  virtual int rename(const char* from, const char* to);
  virtual int unlink(const char* path);
};

/// Routes the file calls of the whole process through `calls` while it lives (tests; not thread-safe).
class ScopedFileCalls {
 public:
  explicit ScopedFileCalls(FileCalls& calls) noexcept;
  ~ScopedFileCalls();
  ScopedFileCalls(const ScopedFileCalls&) = delete;
  ScopedFileCalls& operator=(const ScopedFileCalls&) = delete;

 private:
  FileCalls* before_;
};

/// A file that appears under its name only by commit(); without commit() nothing remains.
class AtomicFile {
 public:
  /// Opens a scratch file beside PATH. Error{io} names path and reason.
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  /// Appends all bytes; short writes are continued and EINTR retried. Error{io}.
  void write(const void* data, std::size_t n);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// Makes the content durable and gives it its name. Error{io}.
  void commit();

 private:
  [[noreturn]] void fail(const char* action, int error);
  std::string path_, temporary_;
  int fd_ = -1;
};

/// Writes `text` as the whole content of `path`, atomically and durably. Error{io}.
void write_file_atomic(const std::string& path, std::string_view text);

/// Writes all bytes to an open descriptor; continues short writes, retries EINTR. False with errno set on failure.
bool write_fully(int fd, const void* data, std::size_t n);

/// Whole content of a regular file. Error{io}: missing, not a regular file, unreadable.
std::vector<std::uint8_t> read_file_bytes(const std::string& path);
std::string read_file_text(const std::string& path);

}  // namespace talus
