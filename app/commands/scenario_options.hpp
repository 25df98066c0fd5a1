// The options of the commands that run a scenario.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace ballservo {

/// `--set`: values of the scenario to be set before it is read.
void add_set_option(CLI::App& command, std::vector<std::string>& sets);

/// `--perception`, with `level` as its default (see parse_perception_level).
void add_perception_option(CLI::App& command, std::string& level);

}  // namespace ballservo
