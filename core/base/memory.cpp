// See memory.hpp.
#include "core/base/memory.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>

namespace talus {
namespace {

constexpr double k_unknown = std::numeric_limits<double>::infinity();

/// The number behind `key` (a word at the start of a line, or "" for the first word of the file).
std::optional<double> number_in(const std::string& file, std::string_view key) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string word;
    if (!key.empty() && (!(words >> word) || word != key)) continue;
    if (!(words >> word)) return {};
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) return {};  // "max"
    return value;
  }
  return {};
}

double of_machine(const std::string& root) {
  if (const auto kib = number_in(root + "/proc/meminfo", "MemAvailable:")) return 1024 * *kib;
  return k_unknown;
}

/// What one group leaves; page cache that the kernel would give back counts as free.
double of_group(const std::string& folder, const char* limit, const char* usage, const char* cache) {
  const auto most = number_in(folder + limit, "");
  if (!most) return k_unknown;
  const double used = number_in(folder + usage, "").value_or(0);
  const double reclaimable = number_in(folder + "/memory.stat", cache).value_or(0);
  return std::fmax(0, *most - std::fmax(0, used - reclaimable));
}

double of_groups(const std::string& root) {
  std::ifstream in(root + "/proc/self/cgroup");
  double least = k_unknown;
  for (std::string line; std::getline(in, line);) {
    // "0::/a/b" (version 2) or "5:memory:/a/b" (version 1)
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const bool two = controllers.empty();
    if (!two && ("," + controllers + ",").find(",memory,") == std::string::npos) continue;
    const std::string base = root + (two ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory");
    for (std::string path = line.substr(second + 1);; path.resize(path.rfind('/'))) {
      if (path == "/") path.clear();
      const double here =
          two ? of_group(base + path, "/memory.max", "/memory.current", "inactive_file")
              : of_group(base + path, "/memory.limit_in_bytes", "/memory.usage_in_bytes", "total_inactive_file");
      least = std::fmin(least, here);
      if (path.find('/') == std::string::npos) break;
    }
  }
  return least;
}

double of_address_space(const std::string& root) {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return k_unknown;
  const double pages = number_in(root + "/proc/self/statm", "").value_or(0);
  return std::fmax(0, static_cast<double>(limit.rlim_cur) - pages * static_cast<double>(sysconf(_SC_PAGESIZE)));
}

}  // namespace

AvailableMemory available_memory(const std::string& root) {
  AvailableMemory best{of_machine(root), "free memory of this machine"};
  if (const double b = of_groups(root); b < best.bytes) best = {b, "limit of the control group"};
  if (const double b = of_address_space(root); b < best.bytes) best = {b, "limit of the address space, ulimit -v"};
  return best;
}

void require_memory(double bytes, std::string_view what, std::string_view where, std::string_view cure,
                    ErrorCode code) {
  // Most requests are small: the files of /proc and /sys are read for large ones only.
  constexpr double small = 16 << 20;
  if (bytes < small) return;
  const AvailableMemory memory = available_memory();
  if (bytes <= memory.bytes) return;
  throw Error(code,
              fmt::format("{} needs about {} of memory, {} are available ({})", what, bytes_text(bytes),
                          bytes_text(memory.bytes), memory.by),
              where, cure);
}

std::string bytes_text(double bytes) {
  const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  int u = 0;
  while (bytes >= 1024 && u < 6) bytes /= 1024, ++u;
  return bytes < 1e6 ? fmt::format("{:.{}f} {}", bytes, u == 0 ? 0 : 1, units[u])
                     : fmt::format("{:.1e} {}", bytes, units[u]);
}

}  // namespace talus
