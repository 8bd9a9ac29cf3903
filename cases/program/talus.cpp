// The program `talus`: parses the command line, calls one command, turns errors into one message and an exit code.
// Who calls it: people, scripts, CI. Invariant: the only place of the project that decides an exit code.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <new>

#include "cases/program/cli.hpp"
#include "cases/program/cli_console.hpp"
#include "cases/program/cli_reference.hpp"
#include "cases/program/cli_shape.hpp"
#include "cases/program/cli_signal.hpp"
#include "cases/program/cli_usage.hpp"
#include "core/base/suggest.hpp"
#include "core/base/text.hpp"
#include "core/scene/scene_keys.hpp"
#include "version.hpp"

namespace {
using namespace talus;
using cli::Options;

const std::map<std::string, Isa> k_isa_names{{"auto", Isa::automatic},
                                             {"scalar", Isa::scalar},
                                             {"sse2", Isa::sse2},
                                             {"avx2", Isa::avx2},
                                             {"avx512", Isa::avx512}};

/// A number in [low, high], which NaN is not; or `word`.
CLI::Validator number_in(double low, double high, const std::string& word = {}) {
  const std::string range = fmt::format("a number in [{:g}, {:g}]{}{}", low, high, word.empty() ? "" : " or ", word);
  return {[=](std::string& text) {
            double v = 0;
            const bool good =
                (!word.empty() && text == word) || (CLI::detail::lexical_cast(text, v) && v >= low && v <= high);
            return good ? std::string() : fmt::format("{}: must be {}", shown(text), range);
          },
          range};
}

void add_scene_options(CLI::App& app, Options& o) {
  app.add_option("scene", o.scene, "scene file (TOML); `talus help scene` lists its keys")->required();
  app.add_option("--set", o.set, "section.key=value: replaces any key of the scene (repeatable)")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  app.add_option("--verlet-k", o.verlet_k, "K of the skin K|v|dt, or auto; never changes the trajectory")
      ->check(number_in(0, 1e9, "auto"));
  app.add_option("--steps", o.steps, "last step of the run")->check(CLI::NonNegativeNumber);
}

void add_engine_options(CLI::App& app, Options& o) {
  app.add_option("--threads", o.run.threads, "threads; 0 = all cores (default)")->check(CLI::Range(0, 4096));
  app.add_option_function<std::string>(
         "--isa", [&o](const std::string& name) { o.run.isa = k_isa_names.at(CLI::detail::to_lower(name)); },
         "instruction set (default auto: $TALUS_ISA, or the best of this processor)")
      ->check(CLI::IsMember(std::vector<std::string>{"auto", "scalar", "sse2", "avx2", "avx512"}, CLI::ignore_case))
      ->type_name("NAME");
  app.add_option("--chunk", o.run.chunk, "particles per chunk; 0 = chosen (default)")->check(CLI::Range(0, 1 << 24));
}

void add_run_options(CLI::App& app, Options& o) {
  app.add_option("--out", o.out, "folder of the results (default results/SCENE-NAME)")->type_name("DIR");
  app.add_option("--resume", o.resume, "continue from a checkpoint, or from the newest one of a run folder")
      ->type_name("FILE|DIR");
  app.add_option("--checkpoint-every", o.checkpoint_every,
                 "steps between checkpoints, besides those of output.checkpoint_wall; 0 = none")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--warm", o.warm, "first steps that the reported time and rate leave out (benchmarks)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--trace", o.trace, "write a Chrome trace (Perfetto): one row per thread, one box per node and chunk")
      ->type_name("FILE");
  app.add_option("--trace-from", o.trace_from, "first traced step (default: the first of this run)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--trace-steps", o.trace_steps, "number of traced steps (default 200)")->check(CLI::PositiveNumber);
  app.add_flag("--profile", o.run.profile,
               "print a table of the nodes: calls, time, share, imbalance; idle time of the threads");
  app.add_flag("--audit", o.run.audit,
               "count at every step what touches and is in no list, found without cells (slow)");
  app.add_flag("--quiet", o.quiet, "no progress, no closing text");
  app.add_flag("--overwrite", o.overwrite, "replace the results of an earlier run in the same folder");
}

void add_shape_options(CLI::App& app, cli::ShapeOptions& o) {
  app.add_option("mesh", o.mesh, "STL, OBJ or PLY file")->required();
  app.add_option("--spheres", o.spheres, "number of spheres")->required()->check(CLI::Range(1, 10000));
  app.add_option("--grid", o.grid, "candidates along the longest side of the mesh (default 40)")
      ->check(CLI::Range(4, 400));
  app.add_option("--scale", o.scale, "metres per unit of the file (default 1)")->check(number_in(1e-12, 1e12));
  app.add_flag("--grow", o.grow, "grow all spheres by one length until they have the volume of the mesh");
  app.add_option("--out", o.out, "table of x, y, z, radius (default MESH-NAME.csv)")->type_name("FILE");
  app.add_flag("--overwrite", o.overwrite, "replace the table");
  app.add_flag("--quiet", o.quiet, "print nothing");
}

/// What the parser knows, as plain data.
cli::CommandText text_of(const CLI::App& app) {
  cli::CommandText command{app.get_name(), app.get_description(), {}};
  for (const CLI::Option* o : app.get_options()) {
    cli::OptionText option;
    for (const std::string& n : o->get_snames()) option.names.push_back("-" + n);
    for (const std::string& n : o->get_lnames()) option.names.push_back("--" + n);
    if (option.names.empty()) option.positional = o->get_name();
    option.takes_value = o->get_expected_max() > 0 && option.positional.empty();
    option.type = o->get_type_name().substr(0, o->get_type_name().find(':'));
    option.about = o->get_description();
    command.options.push_back(std::move(option));
  }
  return command;
}

cli::ProgramText texts_of(const CLI::App& app) {
  cli::ProgramText program{text_of(app), {}};
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    program.commands.push_back(text_of(*command));
  return program;
}

/// `talus help contact.friction` means `talus help scene contact.friction`; false where there is no such key.
bool put_scene_key(const std::string& name) {
  Options o;
  o.topic = "scene";
  o.key = name;
  try {
    cli::help(o);
  } catch (const Error&) {
    return false;
  }
  return true;
}

/// `talus help` and `talus help TOPIC`; false for everything else. Error{usage}.
bool help_on_commands(const CLI::App& app, const Options& o) {
  if (!app.got_subcommand("help") || o.topic == "scene" || o.topic == "grain") return false;
  if (o.topic.empty()) {
    cli::put_text(app.help());
    return true;
  }
  const cli::ProgramText program = texts_of(app);
  if (const auto text = cli::help_text(program, o.topic)) {
    cli::put_text(*text);
    return true;
  }
  const auto found = app.get_subcommands([&](const CLI::App* c) { return c->get_name() == o.topic; });
  if (found.empty()) {
    if (put_scene_key(o.topic)) return true;
    std::vector<std::string> topics = program.command_names();
    topics.insert(topics.end(), cli::help_topics().begin(), cli::help_topics().end());
    std::string list;
    for (const std::string& t : topics) list += (list.empty() ? "" : ", ") + t;
    throw Error(ErrorCode::usage,
                fmt::format("no help on '{}'{}; there is {}, and keys of a scene (talus help scene lists them)",
                            o.topic, did_you_mean(o.topic, topics), list));
  }
  cli::put_text(found.front()->help());
  if (find_scene_section(o.topic) != nullptr)
    cli::put("\nKeys of scenes with this name: talus help scene {}\n", o.topic);
  return true;
}

void say(const std::string& text) { cli::tell("talus: error: {}\n", text); }

/// As of a program that SIGPIPE ends: `talus help scene | head` is no fault.
constexpr int k_reader_gone = 128 + SIGPIPE;

int guarded(const std::function<int()>& command) {
  const int io = static_cast<int>(ErrorCode::io);
  try {
    return command();
  } catch (const cli::ReaderGone&) {
    return k_reader_gone;
  } catch (const Error& e) {
    say(e.what());
    return e.exit_code();
  } catch (const std::bad_alloc&) {
    say("out of memory (fewer particles, or a machine with more memory; `talus check SCENE` estimates the need)");
    return io;
  } catch (const std::filesystem::filesystem_error& e) {
    // Permission, a name that is too long, a loop of links, a disk that is gone: the system's reason, one line.
    say(fmt::format("{}: cannot be accessed: {}", e.path1().string(), e.code().message()));
    return io;
  } catch (const std::system_error& e) {
    say(fmt::format("the system refused: {}", e.code().message()));
    return io;
  } catch (const std::exception& e) {
    say(fmt::format("internal error: {} (please report it with the scene)", e.what()));
    return 70;
  }
}

/// The exit code of a command whose text has to be out, too.
int finished(int code) {
  if (code == static_cast<int>(ErrorCode::io) || code == k_reader_gone) return code;  // one message is enough
  const int flushed = guarded([] {
    cli::flush_output();
    return 0;
  });
  return flushed != 0 && code <= 1 ? flushed : code;
}
using Command = std::function<int(const Options&)>;
/// Adds a command to the program: its name, what it does, what carries it out.
using Adder = std::function<CLI::App*(const char*, const char*, Command)>;

void add_scene_commands(const Adder& add, Options& o) {
  CLI::App* sub = add("run", "run a scene", cli::run);
  add_scene_options(*sub, o);
  add_engine_options(*sub, o);
  add_run_options(*sub, o);
  sub->add_flag("--json", o.json, "print the summary as JSON");

  sub = add("check", "validate a scene; advise time step, stiffness and K; predict steps, run time and memory",
            cli::check);
  add_scene_options(*sub, o);
  add_engine_options(*sub, o);
  sub->add_option("--calibrate", o.calibrate, "seconds of first steps to measure their cost; 0 = none (default 2)")
      ->check(number_in(0, 60));
  sub->add_flag("--json", o.json, "machine-readable");

  sub = add("explain", "what the step of a scene consists of, what is left out and why", cli::explain);
  add_scene_options(*sub, o);
  add_engine_options(*sub, o);
  sub->add_flag("--json", o.json, "machine-readable");
}

void add_result_commands(const Adder& add, Options& o) {
  CLI::App* sub = add("info", "what is in a checkpoint, a summary or a run folder", cli::info);
  sub->add_option("file", o.files, "checkpoint, summary.json or run folder")->required();
  sub->add_flag("--json", o.json, "machine-readable");

  sub = add("compare", "first difference between two checkpoints or run folders; exit 1 if they differ", cli::compare);
  sub->add_option("files", o.files, "two checkpoints or run folders")->required()->expected(2);
  sub->add_flag("--json", o.json, "machine-readable");

  sub = add("convert", "particles of a run, checkpoint or file as CSV, LAMMPS dump, extended XYZ, VTP or VTKHDF",
            cli::convert);
  sub->add_option("files", o.files,
                  "FROM: run folder, .tcp, or a file as TO (text also .gz); TO: a name that ends with .csv, "
                  ".dump, .lammpstrj, .xyz, .extxyz, .vtp, .pvd or .vtkhdf")
      ->required()
      ->expected(2);
  sub->add_option("--frame", o.frame, "all, last, or a number from 0 (default: all; last for .csv and .vtp)");
  sub->add_flag("--overwrite", o.overwrite, "replace TO");
  sub->add_flag("--quiet", o.quiet, "print nothing");

  sub = add("report", "write one self-contained HTML page about a run, or about many (--index)", cli::report);
  sub->add_option("folder", o.files, "run folder; several with --index")->required();
  sub->add_option("--out", o.out, "HTML file (default FOLDER/report.html)")->type_name("FILE");
  sub->add_option("--index", o.index, "one page about all folders: a table, each figure over what differs, series")
      ->type_name("FILE")
      ->excludes("--out");
  sub->add_option("--figures", o.figures,
                  "of the index: names of summary.json or columns of series.csv (default: chosen)")
      ->type_name("NAME,…")
      ->needs("--index");
  sub->add_flag("--quiet", o.quiet, "print nothing");
}

void add_other_commands(const Adder& add, Options& o, cli::ShapeOptions& shape) {
  CLI::App* sub = add("grain", "heat, drying and conversion of one grain in hot gas as a CSV table", cli::grain);
  sub->add_option("file", o.files, "grain file (TOML); `talus help grain` lists its keys")->required()->expected(1);
  sub->add_option("--out", o.out, "CSV file (default: standard output)")->type_name("FILE");
  sub->add_flag("--advise", o.advise, "print Biot number, level, shells and heat step instead");
  sub->add_flag("--overwrite", o.overwrite, "replace the file");
  sub->add_flag("--quiet", o.quiet, "print nothing");

  sub = add("shape", "make a clump of spheres that fills a watertight mesh; say how well",
            [&shape](const Options&) { return cli::shape(shape); });
  add_shape_options(*sub, shape);

  sub = add("help", "help on a command, on keys (talus help scene [KEY]), on files and columns (talus help output)",
            cli::help);
  sub->add_option(
      "topic", o.topic,
      "a command, a key or section of a scene, or one of scene, grain, output, exit; reference (Markdown), man, "
      "bash, zsh: the same for other readers");
  sub->add_option("key", o.key, "a key such as contact.friction, or a section");
}
}  // namespace

int main(int argc, char** argv) {
  cli::secure_descriptors();
  cli::outlive_failed_writes();
  Options o;
  cli::ShapeOptions shape;
  if (argc > 0) o.program = argv[0];
  CLI::App app{"Talus: discrete element method with a local Verlet buffer; the trajectory depends on the scene alone."};
  app.set_version_flag("--version", std::string("talus ") + TALUS_FULL_VERSION);
  app.require_subcommand(1);
  app.failure_message([&](const CLI::App*, const CLI::Error& e) {
    const std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
    return fmt::format("talus: error: {}\n", cli::usage_fault(texts_of(app), arguments, e.what()));
  });
  Command command;
  const Adder add = [&](const char* name, const char* about, Command function) {
    CLI::App* sub = app.add_subcommand(name, about);
    sub->final_callback([&command, function = std::move(function)] { command = function; });
    return sub;
  };
  add_scene_commands(add, o);
  add_result_commands(add, o);
  add_other_commands(add, o, shape);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    // --help and --version arrive here too, with code 0.
    return finished(app.exit(e) == 0 ? 0 : static_cast<int>(ErrorCode::usage));
  }
  return finished(guarded([&] { return help_on_commands(app, o) ? 0 : command(o); }));
}
