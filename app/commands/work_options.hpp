// The options of the commands whose work can be split over machines, killed, resumed and put together again.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/commands/command.hpp"

namespace ballservo {

struct WorkOptions {
  std::filesystem::path output;
  std::string shard = "1/1";  ///< see parse_shard
  bool resume = false;
};

/// Adds -o, --shard and --resume.
void add_work_options(CLI::App& command, WorkOptions& options);

struct MergeOptions {
  CommonOptions common;
  std::vector<std::filesystem::path> folders;
  std::filesystem::path output, against;
};

/// Adds the subcommand that joins what --shard has split; its description and footer, and --against, are the
/// caller's.
CLI::App* add_merge_command(CLI::App& command, Action& action, std::function<int(const MergeOptions&)> merge,
                            const std::function<void(CLI::App&, MergeOptions&)>& more_options = {});

/// Adds --against to a sweep or a merge of one.
void add_against_option(CLI::App& command, std::filesystem::path& against);

}  // namespace ballservo
