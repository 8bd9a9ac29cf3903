// See scratch.hpp.
#include "core/io/scratch.hpp"

#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "core/base/rng.hpp"

namespace talus {
namespace {

constexpr std::string_view k_mark = ".talus-";
constexpr std::size_t k_digits = 16;

std::uint64_t random_bits() {
  std::uint64_t bits = 0;
  if (getrandom(&bits, sizeof bits, 0) == static_cast<ssize_t>(sizeof bits)) return bits;
  // a kernel without the call: unlike any other run's, if not unguessable
  return mix64(static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count()) ^
               (static_cast<std::uint64_t>(getpid()) << 40));
}

}  // namespace

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::string scratch_beside(const std::string& path) {
  const auto slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : path.substr(0, slash + 1);
  return fmt::format("{}{}{:016x}", folder, k_mark, random_bits());
}

bool is_scratch_name(std::string_view name) noexcept {
  if (!name.starts_with(k_mark) || name.size() != k_mark.size() + k_digits) return false;
  name.remove_prefix(k_mark.size());
  return std::all_of(name.begin(), name.end(), [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

}  // namespace talus
