// The options of a scenario, and of the commands whose work can be split over machines, killed, resumed and
// put together again.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/commands/command.hpp"
#include "calibration/base/image_size.hpp"

namespace ballservo {

struct Scenario;

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

/// Names the files that a scenario refers to as read by the run, and throws InputError where one of them is
/// an output, or its camera has more pixels than --max-pixels allows.
void admit(const Scenario& scenario, const CommonOptions& common);
void admit_camera(const std::filesystem::path& file, ImageSize size, const CommonOptions& common);

/// `--set`: values of the scenario to be set before it is read.
void add_set_option(CLI::App& command, std::vector<std::string>& sets);

/// `--perception`, with `level` as its default (see parse_perception_level).
void add_perception_option(CLI::App& command, std::string& level);

}  // namespace ballservo
