// See cli_console.hpp.
#include "cases/program/cli_console.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/base/error.hpp"

namespace talus::cli {
namespace {

[[noreturn]] void output_failed(int error) {
  if (error == EPIPE) throw ReaderGone();
  throw Error(ErrorCode::io, std::string("cannot write: ") + std::strerror(error != 0 ? error : EIO),
              "standard output");
}

}  // namespace

void put_text(std::string_view text) {
  errno = 0;
  const std::size_t n = std::fwrite(text.data(), 1, text.size(), stdout);
  if (n != text.size() || std::ferror(stdout) != 0) output_failed(errno);
}

void tell_text(std::string_view text) noexcept {
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), stderr));
  static_cast<void>(std::fflush(stderr));
}

void flush_output() {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) output_failed(errno);
}

void secure_descriptors() noexcept {
  int fd = 0;
  while (fd >= 0 && fd <= 2) fd = ::open("/dev/null", O_RDWR);
  if (fd > 2) ::close(fd);
}

}  // namespace talus::cli
