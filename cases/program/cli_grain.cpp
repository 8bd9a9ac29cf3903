// `talus grain FILE`: one grain in hot gas, its history as a table.
#include <fmt/format.h>

#include <filesystem>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
#include "core/conversion/grain_advice.hpp"
#include "core/conversion/grain_run.hpp"
#include "core/io/atomic_file.hpp"

namespace talus::cli {
int grain(const Options& options) {
  const std::string& path = options.files.at(0);
  const conversion::GrainJob job = conversion::load_grain(path);
  if (options.advise) {
    put_text(conversion::advice_text(job));
    return 0;
  }
  std::filesystem::path out(options.out);
  if (options.out.empty()) {
    put_text(conversion::grain_table(job));
    return 0;
  }
  if (std::filesystem::exists(out) && (!options.overwrite || !std::filesystem::is_regular_file(out)))
    throw Error(ErrorCode::usage, "is there already", options.out, "--overwrite replaces a file");
  write_file_atomic(options.out, conversion::grain_table(job));
  if (!options.quiet) put("{}: {} steps of {:g} s\n", shown_path(options.out), job.steps, job.step);
  return 0;
}

}  // namespace talus::cli
