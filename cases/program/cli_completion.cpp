// See cli_completion.hpp. Both shells share one plan: commands first, then options of the command, then what an option
// takes (keys after --set, words where it has a choice), else files.
#include "cases/program/cli_completion.hpp"

#include <fmt/format.h>

#include <set>
#include <vector>

#include "cases/program/cli_reference.hpp"
#include "core/scene/scene_keys.hpp"
#include "core/scene/scene_suggest.hpp"

namespace talus::cli {
namespace {

constexpr const char* k_isas = "auto scalar sse2 avx2 avx512";

std::string words(const std::vector<std::string>& list) {
  std::string s;
  for (const std::string& w : list) s += (s.empty() ? "" : " ") + w;
  return s;
}

std::string option_words(const CommandText& command) {
  std::vector<std::string> list;
  for (const std::string& name : command.option_names())
    if (name.starts_with("--")) list.push_back(name);
  return words(list);
}

/// Options that take a value: the next word is not an option's name.
std::string value_options(const ProgramText& program) {
  std::set<std::string> names;
  for (const CommandText& c : program.commands)
    for (const OptionText& o : c.options)
      if (o.takes_value) names.insert(o.names.begin(), o.names.end());
  return words({names.begin(), names.end()});
}

std::string key_words() {
  std::string s;
  for (const SceneKey& k : scene_keys()) s += fmt::format("{}{}=", s.empty() ? "" : " ", settable_path(k, ""));
  return s;
}

std::string help_words(const ProgramText& program) {
  return words(program.command_names()) + " " + words(help_topics());
}

}  // namespace

std::string bash_completion(const ProgramText& program) {
  std::string options;
  for (const CommandText& c : program.commands)
    options += fmt::format("    {}) words=\"{}\" ;;\n", c.name, option_words(c));
  return fmt::format(R"(# bash completion for talus, made by `talus help bash`
_talus() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} command=${{COMP_WORDS[1]}} words=
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "{} --help --version" -- "$current"))
    return
  fi
  case $previous in
    --isa) COMPREPLY=($(compgen -W "{}" -- "$current")); return ;;
    --verlet-k) COMPREPLY=($(compgen -W "auto" -- "$current")); return ;;
    --frame) COMPREPLY=($(compgen -W "all last" -- "$current")); return ;;
    --set)
      compopt -o nospace 2>/dev/null
      COMPREPLY=($(compgen -W "{}" -- "$current"))
      return ;;
  esac
  if [ "$command" = help ]; then
    [ "$COMP_CWORD" -eq 2 ] && COMPREPLY=($(compgen -W "{}" -- "$current"))
    return
  fi
  case $command in
{}  esac
  case " {} " in
    *" $previous "*) words= ;;
  esac
  if [ -n "$words" ] && [ "${{current#-}}" != "$current" ]; then
    COMPREPLY=($(compgen -W "$words" -- "$current"))
  else
    compopt -o default 2>/dev/null
    COMPREPLY=($(compgen -f -- "$current"))
  fi
}}
complete -F _talus talus
)",
                     words(program.command_names()), k_isas, key_words(), help_words(program), options,
                     value_options(program));
}

std::string zsh_completion(const ProgramText& program) {
  std::string options;
  for (const CommandText& c : program.commands)
    options += fmt::format("    {}) choices=({}) ;;\n", c.name, option_words(c));
  return fmt::format(R"(#compdef talus
# zsh completion for talus, made by `talus help zsh`
_talus() {{
  local -a choices
  if (( CURRENT == 2 )); then
    compadd -- {} --help --version
    return
  fi
  case $words[CURRENT-1] in
    --isa) compadd -- {}; return ;;
    --verlet-k) compadd -- auto; return ;;
    --frame) compadd -- all last; return ;;
    --set) compadd -S '' -- {}; return ;;
  esac
  if [[ $words[2] == help ]]; then
    (( CURRENT == 3 )) && compadd -- {}
    return
  fi
  case $words[2] in
{}  esac
  if [[ $words[CURRENT] == -* ]]; then
    compadd -- $choices
  else
    _files
  fi
}}
_talus "$@"
)",
                     words(program.command_names()), k_isas, key_words(), help_words(program), options);
}

}  // namespace talus::cli
