// Where the program's other parts are: scripts of the report and the cases. Called by cli_report.cpp.
#pragma once

#include <string>

namespace talus::cli {

/// Path of a part, e.g. "perf/report.py": below $TALUS_SHARE, below ../share/talus beside the program (an installed
/// copy, wherever it was moved to), or in the sources that it was built from. Error{io}: in none of them.
std::string part(const std::string& name);

}  // namespace talus::cli
