// The options of a scenario, and of the commands whose work can be split over machines, killed, resumed and
// put together again.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
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

/// Adds the subcommand that joins what --shard has split; its description and footer are the caller's.
CLI::App* add_merge_command(CLI::App& command, Action& action, int (*merge)(const MergeOptions&),
                            bool with_against);

/// Adds --against to a sweep or a merge of one.
void add_against_option(CLI::App& command, std::filesystem::path& against);

/// --threads, or as many as the machine has.
int threads_of(const CommonOptions& common);

/// Names the files that a scenario refers to as read by the run, and throws InputError where one of them is
/// an output, or its camera's pictures are not to be had: more pixels than --max-pixels allows, or than
/// memory has room for with `pictures` of them in work at once (0: none is rendered). Says what a large run
/// needs.
void admit(const Scenario& scenario, const CommonOptions& common, int pictures);
void admit_camera(const std::filesystem::path& file, ImageSize size, const CommonOptions& common,
                  int pictures);

/// `--set`: values of the scenario to be set before it is read.
void add_set_option(CLI::App& command, std::vector<std::string>& sets);

/// `--perception`, with `level` as its default (see parse_perception_level).
void add_perception_option(CLI::App& command, std::string& level);

}  // namespace ballservo
