// See cli_reference.hpp: the reference as text and Markdown, and the man page.
#include "cases/program/cli_reference.hpp"

#include <fmt/format.h>

#include <span>

#include "cases/program/cli_completion.hpp"
#include "core/io/output_tables.hpp"
#include "core/scene/scene_keys.hpp"
#include "version.hpp"

namespace talus::cli {
namespace {

struct ExitCode {
  std::string_view code, meaning;
};
constexpr ExitCode k_exit_codes[] = {
    {"0", "done"},
    {"1", "compare: the states differ"},
    {"2", "usage: a command, option or name that does not exist, or a folder that would be overwritten"},
    {"3", "scene: a key, value or input file that cannot be meant; nothing was written"},
    {"4", "physics: the run ended itself (overlap, travel, energy); the last state is kept as failed.tcp"},
    {"5",
     "input or output: a missing or damaged file, a full disk, a folder that another run holds, text that cannot be "
     "written"},
    {"70", "a fault of the program: please report it with the scene"},
    {"128 + n",
     "signal n (SIGINT 130, SIGTERM 143), after a checkpoint; a second one ends at once; 141: nobody reads the "
     "output"},
};

constexpr std::string_view k_kinds =
    "sum: over all steps since the start of the trajectory, whatever the times of the rows; mean: of a sum, over the "
    "time "
    "since the row before; moment: of the row's time alone. Contacts, loads and energies are those of the last "
    "executed "
    "step (zero at step 0), positions and velocities those after it.";

// ------------------------------------------------------------------------------------------------------------- text

void add_rows(std::string& text, std::span<const OutputColumn> rows) {
  for (const OutputColumn& c : rows)
    text += fmt::format("  {:<44} {:<7} {}{}{}\n", c.name, fmt::format("[{}]", c.unit), c.kind,
                        c.kind.empty() ? "" : ": ", c.doc);
}

std::string output_text() {
  std::string text = "Files of a run's folder (<N>: a number):\n";
  for (const OutputFile& f : output_files())
    text += fmt::format("  {:<44} {}{}\n", f.name, f.doc, f.key.empty() ? "" : fmt::format(" ({})", f.key));
  text += fmt::format("\nColumns of series.csv. {}\n", k_kinds);
  add_rows(text, series_columns());
  text += "\nColumns of particle frames:\n";
  add_rows(text, frame_columns());
  text += "\nColumns of contact frames:\n";
  add_rows(text, contact_columns());
  return text;
}

std::string exit_text() {
  std::string text = "Exit codes:\n";
  for (const ExitCode& e : k_exit_codes) text += fmt::format("  {:<8} {}\n", e.code, e.meaning);
  return text;
}

// --------------------------------------------------------------------------------------------------------- markdown

/// Text within a cell of a table.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '|' || c == '<' || c == '*' || c == '_' || c == '[') out += '\\';
    out += c;
  }
  return out;
}

void add_table(std::string& text, std::span<const OutputColumn> rows, bool kinds) {
  text += kinds ? "| column | unit | kind | what |\n|---|---|---|---|\n" : "| column | unit | what |\n|---|---|---|\n";
  for (const OutputColumn& c : rows)
    text +=
        fmt::format("| `{}` | {} |{} {} |\n", c.name, c.unit, kinds ? fmt::format(" {} |", c.kind) : "", cell(c.doc));
  text += '\n';
}

std::string key_tables() {
  std::string text;
  for (const SceneSection& s : scene_sections()) {
    const std::string title = s.name.empty()
                                  ? "Top of the file"
                                  : fmt::format("{}{}{}", s.repeated ? "[[" : "[", s.name, s.repeated ? "]]" : "]");
    text += fmt::format("### {}\n\n{}\n\n| key | value | default | what | example |\n|---|---|---|---|---|\n",
                        s.name.empty() ? title : "`" + title + "`", cell(s.doc));
    for (const SceneKey& k : scene_keys()) {
      if (k.section != s.name) continue;
      std::string doc = cell(k.doc);
      if (const std::size_t at = k.only.find('='); at != std::string_view::npos) {
        std::string words(k.only.substr(at + 1));
        for (std::size_t bar; (bar = words.find('|')) != std::string::npos;) words.replace(bar, 1, ", ");
        doc += fmt::format("; only with {} = {}", cell(k.only.substr(0, at)), cell(words));
      }
      text += fmt::format("| `{}` | {} | {} | {} | `{}` |\n", k.name, cell(allowed_text(k)), cell(k.fallback), doc,
                          k.example);
    }
    text += '\n';
  }
  return text;
}

/// "--threads INT", or the name of a positional.
std::string option_title(const OptionText& o) {
  if (!o.positional.empty()) return o.positional;
  std::string title;
  for (const std::string& n : o.names) title += (title.empty() ? "" : ", ") + n;
  return o.takes_value && !o.type.empty() ? title + " " + o.type : title;
}

std::string command_tables(const ProgramText& program) {
  std::string text;
  for (const CommandText& c : program.commands) {
    text += fmt::format("### `talus {}`\n\n{}\n\n| option | what |\n|---|---|\n", c.name, cell(c.about));
    for (const OptionText& o : c.options) text += fmt::format("| {} | {} |\n", cell(option_title(o)), cell(o.about));
    text += '\n';
  }
  return text;
}

std::string reference_markdown(const ProgramText& program) {
  std::string text = fmt::format(
      "# Reference of Talus {}\n\nMade by `talus help reference` from the tables that the program uses.\n\n- "
      "[Commands](#commands)\n- [Keys of a scene](#keys-of-a-scene)\n- [Files](#files)\n- [Columns of "
      "series.csv](#columns-of-seriescsv)\n- [Columns of frames](#columns-of-frames)\n- [Exit codes](#exit-codes)\n\n",
      TALUS_FULL_VERSION);
  text += "## Commands\n\n" + command_tables(program);
  text +=
      "## Keys of a scene\n\nUnits are SI, or any consistent set. On the command line: `--set section.key=value`, with "
      "the number of the entry, from 0, for repeated sections (`--set wall.0.material=steel`).\n\n" +
      key_tables();
  text += "## Files\n\n| file | key | what |\n|---|---|---|\n";
  for (const OutputFile& f : output_files())
    text += fmt::format("| `{}` | {} | {} |\n", f.name, f.key.empty() ? "" : fmt::format("`{}`", f.key), cell(f.doc));
  text += fmt::format("\n## Columns of series.csv\n\nKinds: {}\n\n", cell(k_kinds));
  add_table(text, series_columns(), true);
  text += "## Columns of frames\n\nOf particles:\n\n";
  add_table(text, frame_columns(), false);
  text += "Of contacts:\n\n";
  add_table(text, contact_columns(), false);
  text += "## Exit codes\n\n| code | meaning |\n|---|---|\n";
  for (const ExitCode& e : k_exit_codes) text += fmt::format("| {} | {} |\n", e.code, cell(e.meaning));
  return text;
}

// --------------------------------------------------------------------------------------------------------- man page

/// Plain text in roff.
std::string roff(std::string_view text) {
  std::string out;
  if (!text.empty() && (text.front() == '.' || text.front() == '\'')) out = "\\&";
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
    if (c == ',') out += "\\:";  // long words may be broken there
  }
  return out;
}

std::string man_page(const ProgramText& program) {
  std::string text =
      fmt::format(".TH TALUS 1 \"\" \"talus {}\" \"User Commands\"\n.ad l\n.nh\n.SH NAME\ntalus \\- {}\n",
                  TALUS_FULL_VERSION, "discrete element method for granular material");
  text += ".SH SYNOPSIS\n";
  for (const CommandText& c : program.commands) {
    text += fmt::format(".B talus {}\n.RI [ options ]", c.name);
    for (const OptionText& o : c.options)
      if (!o.positional.empty()) text += fmt::format("\n.I {}", roff(o.positional));
    text += "\n.br\n";
  }
  text += fmt::format(".SH DESCRIPTION\n{}\n", roff(program.own.about));
  text += "A scene is a TOML file; \\fBtalus help scene\\fR lists its keys.\n.SH COMMANDS\n";
  for (const CommandText& c : program.commands) {
    text += fmt::format(".SS talus {}\n{}\n", c.name, roff(c.about));
    for (const OptionText& o : c.options) text += fmt::format(".TP\n.B {}\n{}\n", roff(option_title(o)), roff(o.about));
  }
  text += ".SH FILES\n";
  for (const OutputFile& f : output_files()) text += fmt::format(".TP\n.I {}\n{}\n", roff(f.name), roff(f.doc));
  text += ".SH EXIT STATUS\n";
  for (const ExitCode& e : k_exit_codes) text += fmt::format(".TP\n.B {}\n{}\n", e.code, roff(e.meaning));
  text +=
      ".SH ENVIRONMENT\n.TP\n.B TALUS_ISA\ninstruction set, as \\-\\-isa\n.TP\n.B TALUS_SHARE\nfolder of the scripts, "
      "if "
      "they are not beside the program\n.TP\n.B COLUMNS\nwidth of a terminal that does not tell it\n";
  return text;
}

}  // namespace

const std::vector<std::string>& help_topics() {
  static const std::vector<std::string> topics{"scene", "output", "exit", "reference", "man", "bash", "zsh"};
  return topics;
}

std::optional<std::string> help_text(const ProgramText& program, std::string_view topic) {
  if (topic == "output") return output_text();
  if (topic == "exit") return exit_text();
  if (topic == "reference") return reference_markdown(program);
  if (topic == "man") return man_page(program);
  if (topic == "bash") return bash_completion(program);
  if (topic == "zsh") return zsh_completion(program);
  return {};
}

}  // namespace talus::cli
