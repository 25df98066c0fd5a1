// The program's commands, as it names them itself.
#pragma once

#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/program/program_run.hpp"

namespace ballservo::test {

/// A fixture that knows all commands: "detect", "calibrate camera" ...
class Hostile : public ProgramTest {
 protected:
  /// What stands in the help's section: first words of its lines ("--json", "detect").
  std::vector<std::string> section(const std::string& command, const std::string& title) const {
    std::istringstream help(run(command + " --help").out);
    std::vector<std::string> words;
    bool inside = false;
    static const std::regex entry(R"(^  (?:-[A-Za-z],)?([^ ,]+).*)");
    std::smatch match;
    for (std::string line; std::getline(help, line);) {
      if (line.empty() || line[0] != ' ') inside = line == title + ":";
      if (inside && std::regex_match(line, match, entry)) words.push_back(match[1]);
    }
    return words;
  }
  std::vector<std::string> commands(const std::string& above = "") const {
    std::vector<std::string> found;
    for (const std::string& name : section(above, "Subcommands")) {
      const std::string command = above.empty() ? name : above + " " + name;
      if (command != "calibrate") found.push_back(command);
      for (const std::string& below : commands(command)) found.push_back(below);
    }
    return found;
  }
};

}  // namespace ballservo::test
