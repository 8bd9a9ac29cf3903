// See cli_usage.hpp.
#include "cases/program/cli_usage.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/suggest.hpp"
#include "core/base/text.hpp"
#include "core/scene/scene_suggest.hpp"

namespace talus::cli {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string s;
  for (const std::string& w : words) s += (s.empty() ? "" : ", ") + w;
  return s;
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// "--threads=4" -> "--threads"; "" for values, numbers too.
std::string option_in(const std::string& argument) {
  const bool option = argument.size() > 1 && argument[0] == '-' && !(argument[1] >= '0' && argument[1] <= '9') &&
                      argument[1] != '.' && argument != "--";
  return option ? argument.substr(0, argument.find('=')) : "";
}

std::string unknown_command(const ProgramText& program, const std::string& word) {
  const std::vector<std::string> names = program.command_names();
  std::string hint = did_you_mean(word, names);
  if (word.ends_with(".toml")) hint = fmt::format(" (a scene is run by 'talus run {}')", shown(word));
  return fmt::format("unknown command '{}'{}; there is {}", shown(word), hint, joined(names));
}

std::string unknown_option(const ProgramText& program, const CommandText& command, const std::string& name) {
  std::string hint = did_you_mean(name, command.option_names());
  std::vector<std::string> elsewhere;
  for (const CommandText& other : program.commands)
    if (has(other.option_names(), name)) elsewhere.push_back(other.name);
  if (!elsewhere.empty())
    hint = fmt::format(" (an option of {})", joined(elsewhere));
  else if (has(command.option_names(), "--set") && hint.empty())
    if (const KeySuggestion key = suggest_key(name.substr(name.find_first_not_of('-'))); key.key != nullptr)
      hint = fmt::format(" (a key of the scene is set by --set {}=VALUE)", settable_path(*key.key, ""));
  return fmt::format("'talus {}' has no option '{}'{}; 'talus {} --help' lists them", command.name, shown(name), hint,
                     command.name);
}

}  // namespace

std::string usage_fault(const ProgramText& program, const std::vector<std::string>& arguments,
                        const std::string& parser) {
  if (arguments.empty()) return fmt::format("no command is given; there is {}", joined(program.command_names()));
  const std::string& word = arguments.front();
  if (const CommandText* command = program.find(word)) {
    const std::vector<std::string> options = command->option_names();
    for (std::size_t k = 1; k < arguments.size() && arguments[k] != "--"; ++k)
      if (const std::string option = option_in(arguments[k]); !option.empty() && !has(options, option))
        return unknown_option(program, *command, option);
    return fmt::format("{}; 'talus {} --help' tells more", shown(parser, 700), word);
  }
  const std::string option = option_in(word);
  if (option.empty()) return unknown_command(program, word);
  const std::vector<std::string> own = program.own.option_names();
  if (!has(own, option))
    return fmt::format("'{}' stands before the command{}; write 'talus COMMAND … {}'", shown(option),
                       did_you_mean(option, own), shown(option));
  return fmt::format("{}; 'talus --help' tells more", shown(parser, 700));
}

}  // namespace talus::cli
