// See watched_file.hpp.
#include "core/io/watched_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace talus {

WatchedFile::WatchedFile(std::string path) : path_(std::move(path)) {
  fd_ = ::open(path_.c_str(), O_RDWR | O_APPEND | O_CLOEXEC);
  if (fd_ < 0)
    throw Error(ErrorCode::io, std::string("cannot open for writing: ") + std::strerror(errno), path_,
                "choose a folder that you may write to");
  struct stat st = {};
  if (fstat(fd_, &st) == 0) size_ = st.st_size;
}

WatchedFile::~WatchedFile() {
  if (fd_ >= 0) ::close(fd_);
}

WatchedFile& WatchedFile::operator=(WatchedFile&& o) noexcept {
  std::swap(path_, o.path_);
  std::swap(fd_, o.fd_);
  std::swap(size_, o.size_);
  std::swap(room_end_, o.room_end_);
  return *this;
}

void WatchedFile::check() const {
  struct stat mine = {}, there = {};
  const char* what = nullptr;
  if (::stat(path_.c_str(), &there) != 0) {
    what = errno == ENOENT || errno == ENOTDIR ? "was deleted during the run" : "cannot be reached any more";
  } else if (fstat(fd_, &mine) != 0 || mine.st_ino != there.st_ino || mine.st_dev != there.st_dev) {
    what = "was replaced by another file during the run";
  } else if (there.st_size != size_) {
    what = there.st_size < size_ ? "was truncated during the run" : "was written to by others during the run";
  }
  if (what != nullptr) fail(what);
}

void WatchedFile::check_room() const {
  struct stat mine = {};
  if (room_end_ > 0 && fstat(fd_, &mine) == 0 && mine.st_size < room_end_) fail("was truncated during the run");
}

void WatchedFile::fail(const char* what) const {
  throw Error(ErrorCode::io, what, path_, "leave the files of a run alone until it has ended; --resume continues it");
}

void WatchedFile::reserve(std::uint64_t bytes) {
  const auto length = static_cast<off_t>(bytes);
  int error = posix_fallocate(fd_, size_, length);
  while (error == EINTR) error = posix_fallocate(fd_, size_, length);
  if (error == 0) room_end_ = size_ + length;
  // Where the file system cannot say, the writes themselves will.
  if (error == 0 || error == EOPNOTSUPP || error == EINVAL || error == ENODEV) return;
  release(static_cast<std::uint64_t>(size_));
  throw Error(ErrorCode::io, std::string("cannot extend: ") + std::strerror(error), path_,
              "free some space; what was written before stays readable");
}

void WatchedFile::release(std::uint64_t size) {
  struct stat st = {};
  // A longer file is still readable: that the cut fails would harm nobody.
  if (fstat(fd_, &st) == 0 && st.st_size > static_cast<off_t>(size))
    static_cast<void>(ftruncate(fd_, static_cast<off_t>(size)) == 0);
}

}  // namespace talus
