// What was meant by a command line that cannot be parsed: unknown commands and options with the nearest known ones.
// Called by talus.cpp. Invariant: one line, whatever was typed.
#pragma once

#include <string>
#include <vector>

#include "cases/program/cli_commands.hpp"

namespace talus::cli {

/// The fault of the arguments (without the program's name) in the terms of the user, with what cures it; `parser`: what
/// the parser says, for faults that are none of names.
std::string usage_fault(const ProgramText& program, const std::vector<std::string>& arguments,
                        const std::string& parser);

}  // namespace talus::cli
