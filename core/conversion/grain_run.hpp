// The history of a grain file as a table. Who calls it: the command, tests. Invariant: a table holds the whole run or
// none of it: a state that cannot be right is an error.
#pragma once

#include <string>

#include "core/conversion/grain_file.hpp"

namespace talus::conversion {

/// CSV with a header row: time, masses, temperatures, radius, released gas, residuals [SI]. Error{physics} names time
/// and shell.
std::string grain_table(const GrainJob& job);

}  // namespace talus::conversion
