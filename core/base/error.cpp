// See error.hpp.
#include "core/base/error.hpp"

#include "core/base/text.hpp"

namespace talus {
namespace {

// Together with separators and the program's prefix below 1000 bytes. A long path loses its middle, not its end, where
// file, line and column are.
constexpr std::size_t k_where = 200, k_what = 560, k_cure = 200;

std::string compose(std::string_view what, std::string_view where, std::string_view cure) {
  std::string s = where.empty() ? "" : shown(where, k_where) + ": ";
  s += shown(what, k_what);
  if (!cure.empty()) s += " (" + shown(cure, k_cure) + ")";
  return s;
}

}  // namespace

Error::Error(ErrorCode code, std::string_view what, std::string_view where, std::string_view cure)
    : std::runtime_error(compose(what, where, cure)), code_(code) {}

}  // namespace talus
