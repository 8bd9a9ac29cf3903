// The commands and options of the program as plain data, taken from the parser by talus.cpp, for texts about them:
// usage faults, the reference, completions. Invariant: names here are those that the parser knows.
#pragma once

#include <string>
#include <vector>

namespace talus::cli {

struct OptionText {
  std::string positional;          ///< name of a positional; "" for an option
  std::vector<std::string> names;  ///< "-h", "--threads": all by which an option may be called
  std::string type, about;         ///< type: what its value is called, e.g. "DIR"
  bool takes_value = false;
};

struct CommandText {
  std::string name, about;
  std::vector<OptionText> options;
  std::vector<std::string> option_names() const {
    std::vector<std::string> all;
    for (const OptionText& o : options) all.insert(all.end(), o.names.begin(), o.names.end());
    return all;
  }
};

struct ProgramText {
  CommandText own;  ///< description and options of the program itself
  std::vector<CommandText> commands;
  std::vector<std::string> command_names() const {
    std::vector<std::string> all;
    for (const CommandText& c : commands) all.push_back(c.name);
    return all;
  }
  const CommandText* find(const std::string& name) const {
    for (const CommandText& c : commands)
      if (c.name == name) return &c;
    return nullptr;
  }
};

}  // namespace talus::cli
