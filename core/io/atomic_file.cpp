// Durable replacement of files; see atomic_file.hpp.
#include "core/io/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/base/error.hpp"
#include "core/base/input_file.hpp"
#include "core/io/scratch.hpp"

namespace talus {

namespace {

FileCalls k_system;  // NOLINT: stateless
FileCalls* g_calls = &k_system;

// One write(2) moves at most 0x7ffff000 bytes; smaller pieces also bound the time a signal has to wait.
constexpr std::size_t k_piece = std::size_t{1} << 30;

std::string cure_for(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free some space or write to another disk; what was written before is still valid";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder that you may write to";
    case ENOENT:
      return "create the folder first";
    default:
      return "what was written before is still valid";
  }
}

template <class Call>
auto retry(Call call) {
  auto r = call();
  while (r < 0 && errno == EINTR) r = call();
  return r;
}

}  // namespace

int FileCalls::open(const char* path, int flags, unsigned mode) { return ::open(path, flags, mode); }
ssize_t FileCalls::write(int fd, const void* data, std::size_t n) { return ::write(fd, data, n); }
int FileCalls::fsync(int fd) { return ::fsync(fd); }
int FileCalls::close(int fd) { return ::close(fd); }
int FileCalls::rename(const char* from, const char* to) { return ::rename(from, to); }
int FileCalls::unlink(const char* path) { return ::unlink(path); }

ScopedFileCalls::ScopedFileCalls(FileCalls& calls) noexcept : before_(std::exchange(g_calls, &calls)) {}
ScopedFileCalls::~ScopedFileCalls() { g_calls = before_; }

bool write_fully(int fd, const void* data, std::size_t n) {
  auto p = static_cast<const char*>(data);
  while (n > 0) {
    const ssize_t put = retry([&] { return g_calls->write(fd, p, n < k_piece ? n : k_piece); });
    if (put < 0) return false;
    if (put == 0) {  // POSIX allows it for no reason; a loop would never end
      errno = EIO;
      return false;
    }
    p += put;
    n -= static_cast<std::size_t>(put);
  }
  return true;
}

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), temporary_(scratch_beside(path_)) {
  fd_ = retry([&] { return g_calls->open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); });
  if (fd_ < 0) {
    const int error = errno;
    throw Error(ErrorCode::io, std::string("cannot open for writing: ") + std::strerror(error), path_, cure_for(error));
  }
}

AtomicFile::~AtomicFile() {
  if (fd_ >= 0) {
    g_calls->close(fd_);
    g_calls->unlink(temporary_.c_str());
  }
}

void AtomicFile::fail(const char* action, int error) {
  if (fd_ >= 0) g_calls->close(fd_);
  fd_ = -1;
  g_calls->unlink(temporary_.c_str());
  throw Error(ErrorCode::io, std::string("cannot ") + action + ": " + std::strerror(error), path_, cure_for(error));
}

void AtomicFile::write(const void* data, std::size_t n) {
  if (!write_fully(fd_, data, n)) fail("write", errno);
}

void AtomicFile::commit() {
  // A failed fsync may have dropped dirty pages: never retried (except EINTR), the temporary file is given up.
  if (retry([&] { return g_calls->fsync(fd_); }) != 0) fail("make durable (fsync)", errno);
  const int closed = g_calls->close(std::exchange(fd_, -1));
  // Linux closes the descriptor even on EINTR; other errors are late write errors (quota, network file systems).
  if (closed != 0 && errno != EINTR) fail("close", errno);
  if (retry([&] { return g_calls->rename(temporary_.c_str(), path_.c_str()); }) != 0) fail("rename", errno);
  const std::string folder = folder_of(path_);
  const int dir = retry([&] { return g_calls->open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC, 0); });
  if (dir < 0) {
    const int error = errno;
    throw Error(ErrorCode::io, std::string("cannot open the folder to make a rename durable: ") + std::strerror(error),
                path_, cure_for(error));
  }
  const int synced = retry([&] { return g_calls->fsync(dir); });
  const int error = errno;
  g_calls->close(dir);
  // Some file systems cannot sync a directory and say EINVAL: nothing more can be done there.
  if (synced != 0 && error != EINVAL && error != ENOTSUP)
    throw Error(ErrorCode::io, std::string("cannot make a rename durable: ") + std::strerror(error), path_,
                cure_for(error));
}

void write_file_atomic(const std::string& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

// A checkpoint or a summary is read as a whole; memory is the only bound on its size.
std::vector<std::uint8_t> read_file_bytes(const std::string& path) { return read_input_bytes(path, {}); }
std::string read_file_text(const std::string& path) { return read_input_text(path, {}); }

}  // namespace talus
