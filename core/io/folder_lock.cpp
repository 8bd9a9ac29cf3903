// See folder_lock.hpp.
#include "core/io/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "core/base/error.hpp"
#include "core/io/atomic_file.hpp"

namespace talus {
namespace {

struct flock whole_file() {
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

/// What the holder has written about itself; the file is short and its text printable.
std::string text_of(int fd) {
  std::array<char, 256> buffer{};
  const ssize_t n = pread(fd, buffer.data(), buffer.size(), 0);
  std::string text(buffer.data(), n > 0 ? static_cast<std::size_t>(n) : 0);
  text.resize(std::min(text.size(), text.find('\n')));
  for (const char c : text)
    if (c < 0x20 || c > 0x7e) return "another process";
  return text.empty() ? "another process" : text;
}

bool same_file(int fd, const std::string& path) {
  struct stat a = {}, b = {};
  return fstat(fd, &a) == 0 && ::stat(path.c_str(), &b) == 0 && a.st_ino == b.st_ino && a.st_dev == b.st_dev;
}

std::string own_text() {
  std::array<char, 256> host{};
  if (gethostname(host.data(), host.size() - 1) != 0) host[0] = '?';
  return fmt::format("pid {} on host {}\n", getpid(), host.data());
}

}  // namespace

FolderLock::FolderLock(const std::string& folder) {
  const std::string path = folder + "/" + k_file;
  fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (fd_ < 0)
    throw Error(ErrorCode::io, std::string("cannot open for writing: ") + std::strerror(errno), path,
                "choose a folder that you may write to");
  struct flock lock = whole_file();
  const bool refused = fcntl(fd_, F_OFD_SETLK, &lock) != 0 && (errno == EAGAIN || errno == EACCES);
  // A folder that was replaced between open and lock belongs to whoever replaced it.
  if (refused || !same_file(fd_, path)) {
    const std::string who = text_of(fd_);
    ::close(fd_);
    throw Error(ErrorCode::io, "another run is writing here (" + who + ")", folder,
                "wait for it, stop it, or choose another folder with --out");
  }
  const std::string text = own_text();
  // The text is for people; that it may be missing on a full disk does not matter to the lock.
  if (ftruncate(fd_, 0) == 0) static_cast<void>(write_fully(fd_, text.data(), text.size()));
}

FolderLock::~FolderLock() { ::close(fd_); }

std::string FolderLock::holder(const std::string& folder) {
  const std::string path = folder + "/" + k_file;
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return {};
  struct flock lock = whole_file();
  std::string who;
  if (fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK) who = text_of(fd);
  ::close(fd);
  return who;
}

}  // namespace talus
