// See input_file.hpp.
#include "core/base/input_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/base/memory.hpp"

namespace talus {
namespace {

std::string_view kind_text(mode_t mode) {
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a FIFO (named pipe)";
  if (S_ISCHR(mode) || S_ISBLK(mode)) return "a device";
  if (S_ISSOCK(mode)) return "a socket";
  return "not a regular file";
}

template <class Call>
auto retried(Call call) {
  auto r = call();
  while (r < 0 && errno == EINTR) r = call();
  return r;
}

template <class Bytes>
Bytes read_whole(const std::string& path, const InputKind& kind) {
  InputFile file(path, kind);
  require_memory(static_cast<double>(file.size()), fmt::format("reading this {}", kind.name), path,
                 "a smaller file, or a machine with more memory", kind.code);
  Bytes bytes;
  bytes.resize(static_cast<std::size_t>(file.size()));
  bytes.resize(file.read(bytes.data(), bytes.size()));
  // Files of /proc have no size, and a file may grow meanwhile.
  const std::size_t piece = file.size() == 0 ? 1 << 16 : 1 << 10;
  while (bytes.size() == file.size() || file.size() == 0) {
    const std::size_t have = bytes.size();
    if (have > kind.most_bytes) break;
    bytes.resize(have + piece);
    const std::size_t got = file.read(bytes.data() + have, piece);
    bytes.resize(have + got);
    if (got < piece || file.size() != 0) break;
  }
  if (bytes.size() > kind.most_bytes)
    throw Error(kind.code, fmt::format("the {} has more than {} bytes", kind.name, kind.most_bytes), path, kind.cure);
  return bytes;
}

}  // namespace

InputFile::InputFile(const std::string& path, const InputKind& kind) : path_(path), kind_(kind) {
  const auto refuse = [&](const std::string& what, std::string_view cure) {
    throw Error(kind_.code, what, path_, cure);
  };
  if (path.empty()) refuse(fmt::format("the name of the {} is empty", kind.name), kind.cure);
  if (path.find('\0') != std::string::npos)
    refuse(fmt::format("the name of the {} holds a NUL byte", kind.name), kind.cure);
  struct stat st {};
  // Looked at before it is opened: opening a device can have effects, opening a FIFO waits for a writer.
  int error = ::stat(path.c_str(), &st) == 0 ? 0 : errno;
  if (error == 0 && !S_ISREG(st.st_mode))
    refuse(fmt::format("cannot open the {}: it is {}", kind.name, kind_text(st.st_mode)), kind.cure);
  if (error == 0) {
    fd_ = retried([&] { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY); });
    if (fd_ < 0) error = errno;
  }
  if (error != 0)
    refuse(fmt::format("cannot open the {}: {}", kind.name, std::strerror(error)),
           error == EACCES ? "make it readable" : kind.cure);
  if (::fstat(fd_, &st) != 0 || !S_ISREG(st.st_mode)) {
    ::close(fd_);
    refuse(fmt::format("cannot open the {}: it is {}", kind.name, kind_text(st.st_mode)), kind.cure);
  }
  size_ = static_cast<std::uint64_t>(st.st_size);
  if (size_ > kind.most_bytes) {
    ::close(fd_);
    refuse(fmt::format("the {} has {} bytes", kind.name, size_),
           fmt::format("at most {} bytes are allowed", kind.most_bytes));
  }
}

InputFile::~InputFile() {
  if (fd_ >= 0) ::close(fd_);
}

int InputFile::release() noexcept {
  const int fd = fd_;
  fd_ = -1;
  return fd;
}

std::size_t InputFile::read(void* to, std::size_t n) {
  constexpr std::size_t most = std::size_t{1} << 30;  // of one system call
  std::size_t have = 0;
  while (have < n) {
    const ssize_t got = retried([&] { return ::read(fd_, static_cast<char*>(to) + have, std::min(n - have, most)); });
    if (got < 0)
      throw Error(kind_.code, fmt::format("cannot read the {}: {}", kind_.name, std::strerror(errno)), path_);
    if (got == 0) break;
    have += static_cast<std::size_t>(got);
  }
  return have;
}

std::string read_input_text(const std::string& path, const InputKind& kind) {
  return read_whole<std::string>(path, kind);
}
std::vector<std::uint8_t> read_input_bytes(const std::string& path, const InputKind& kind) {
  return read_whole<std::vector<std::uint8_t>>(path, kind);
}

}  // namespace talus
