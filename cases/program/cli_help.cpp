// `talus help scene [KEY]`, `talus help grain [KEY]`: prints the table of keys that the parser itself uses.
#include <fmt/format.h>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
#include "core/conversion/grain_keys.hpp"
#include "core/scene/scene_keys.hpp"

namespace talus::cli {

int help(const Options& options) {
  const std::string text = options.topic == "grain" ? conversion::grain_help(options.key) : scene_help(options.key);
  put("{}{}", text, text.empty() || text.back() == '\n' ? "" : "\n");
  return 0;
}

}  // namespace talus::cli
