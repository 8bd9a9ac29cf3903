// Command line of Talus: the options as parsed and one function per command. cases/program/talus.cpp parses and
// dispatches; each cli_*.cpp is one command and returns the exit code (DESIGN 6: 0 ok, 2 usage, 3 scene, 4 physics, 5
// I/O, 130/143 signal). Invariant: commands throw talus::Error, only talus.cpp turns errors into messages and exit
// codes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/scene_changes.hpp"

namespace talus::cli {

/// Everything that may stand on the command line; every command uses the part that its help names.
struct Options {
  std::string program = "talus";           ///< as it was called, for the commands that messages suggest
  std::string scene;                       ///< SCENE of run, check, explain
  std::vector<std::string> files;          ///< FILE… of info, compare, report; FROM and TO of convert
  std::string frame;                       ///< of convert: all, last or a number
  std::string index, figures;              ///< of report: the page about several runs, what it shows
  std::string topic, key;                  ///< of help
  std::vector<std::string> set;            ///< section.key=value
  std::string out;                         ///< run folder; empty: results/<scene name>
  std::string resume;                      ///< checkpoint file or run folder
  std::string trace;                       ///< Chrome trace file
  std::optional<std::int64_t> trace_from;  ///< first traced step; default: the first of this run
  std::int64_t trace_steps = 200;          ///< enough to see rebuilds; much more makes files that no viewer opens
  std::optional<std::string> verlet_k;
  std::optional<std::int64_t> steps;  ///< last step of the run, not the number still to do
  std::int64_t warm = 0;              ///< first steps that wall_s and the rate leave out
  std::int64_t checkpoint_every = 0;  ///< [steps]; 0: only at a signal or a failure
  double calibrate = 2;               ///< [s] that check spends on measuring; 0: none
  RunOptions run;                     ///< threads, isa, chunk, profile
  bool quiet = false, json = false, overwrite = false;
  bool advise = false;  ///< of grain
};

int run(const Options& options);
int check(const Options& options);
int explain(const Options& options);
int info(const Options& options);
int compare(const Options& options);
int convert(const Options& options);
int report(const Options& options);
int grain(const Options& options);
int help(const Options& options);

/// --set, --steps and --verlet-k as texts "section.key=value".
std::vector<std::string> overrides_of(const Options& options);
/// Error{scene} where a frame of the scene's grid does not fit into memory.
void require_room(const Scene& scene);
/// The scene of the command line: file, then --set, --steps and --verlet-k; with the values that it gives. Errors:
/// Error{scene}, Error{usage}.
SceneText scene_text_of(const Options& options);
Scene scene_of(const Options& options);

/// Thousands separated by blanks for people: 1234567 -> "1 234 567".
std::string grouped(std::int64_t n);
/// Bytes for people: "1.4 GiB".
std::string human_bytes(double bytes);

}  // namespace talus::cli
