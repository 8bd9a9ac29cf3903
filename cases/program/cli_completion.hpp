// Completions for shells, made from the parser and the key table. Called by cli_reference.cpp.
#pragma once

#include <string>

#include "cases/program/cli_commands.hpp"

namespace talus::cli {

std::string bash_completion(const ProgramText& program);
std::string zsh_completion(const ProgramText& program);

}  // namespace talus::cli
