// Texts made from the program's own tables: the reference of commands, keys, outputs and exit codes (text, Markdown),
// the man page, completions for bash and zsh. Called by talus.cpp (talus help TOPIC); the build writes them to files.
// Invariant: names come from the tables and the parser alone, so that no text can name what the program does not know.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cases/program/cli_commands.hpp"

namespace talus::cli {

/// Topics of `talus help` besides the commands.
const std::vector<std::string>& help_topics();

/// The text of output, exit, reference, man, bash or zsh; nothing for other topics.
std::optional<std::string> help_text(const ProgramText& program, std::string_view topic);

}  // namespace talus::cli
