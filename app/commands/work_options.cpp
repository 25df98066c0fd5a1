#include "app/commands/work_options.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

#include "app/scenario/scenario.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();

/// The number that follows a word (or nothing) in a file of the kernel's.
double number_in(const char* file, const std::string& word, double otherwise) {
  std::ifstream stream(file);
  double number = 0;
  for (std::string name; word != name && stream >> name;) {
  }
  return stream >> number ? number : otherwise;
}

/// Bytes that this process can still have: of the machine, of its control group, of the user's limit.
double free_memory_bytes() {
  const double machine = number_in("/proc/meminfo", "MemAvailable:", no_limit) * 1024;
  const double group = number_in("/sys/fs/cgroup/memory.max", "", no_limit) -
                       number_in("/sys/fs/cgroup/memory.current", "", 0);
  rlimit limit{};
  double process = no_limit;
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    process = static_cast<double>(limit.rlim_cur) -
              number_in("/proc/self/statm", "", 0) * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::max(0.0, std::min({machine, group, process}));
}

}  // namespace

void add_work_options(CLI::App& command, WorkOptions& options) {
  add_output_option(command, "-o,--output", options.output, "DIR", "Folder for the results; required");
  add_typed_option(command, "--shard", options.shard, "I/N", "Run only part I of N (I from 1)")
      ->capture_default_str();
  command.add_flag("--resume", options.resume, "Go on with what an earlier run left in the folder");
}

CLI::App* add_merge_command(CLI::App& command, Action& action, int (*merge)(const MergeOptions&),
                            bool with_against) {
  const auto [subcommand, options] = add_command<MergeOptions>(command, action, "merge", "", merge);
  subcommand.add_option("DIR", options.folders, "Folders of all parts (--shard I/N), in any order")
      ->required();
  add_output_option(subcommand, "-o,--output", options.output, "DIR", "Folder for the results")->required();
  if (with_against) add_against_option(subcommand, options.against);
  add_common_options(subcommand, options.common);
  return &subcommand;
}

void add_against_option(CLI::App& command, std::filesystem::path& against) {
  add_typed_option(command, "--against", against, "DIR",
                   "Folder of another sweep to compare with, seed by seed");
}

void add_set_option(CLI::App& command, std::vector<std::string>& sets) {
  add_typed_option(command, "--set", sets, "KEY.PATH=VALUE",
                   "Sets a value of the scenario before it is read, e.g. law.name=visp (may be repeated)")
      ->take_all()
      ->allow_extra_args(false);
}

void add_perception_option(CLI::App& command, std::string& level) {
  command
      .add_option("--perception", level,
                  "image: rendered frames, detector and tracker; geometric: the true place with a fit's "
                  "errors; truth: the true place")
      ->capture_default_str();
}

int threads_of(const CommonOptions& common) {
  return common.threads > 0 ? common.threads
                            : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

void admit_camera(const std::filesystem::path& file, ImageSize size, const CommonOptions& common,
                  int pictures) {
  // What is held of a picture in work, with what renders it and looks at it: 81 at the most (servo).
  constexpr double bytes_a_pixel = 90, bytes_worth_saying = 1e9;
  common.files->reads("a camera", file);
  const double pixels = static_cast<double>(size.width_px) * size.height_px;
  if (pixels > common.max_pixels)
    throw InputError(file.string(), fmt::format("{} x {} pixels", size.width_px, size.height_px),
                     fmt::format("at most {:.0f} pixels (--max-pixels sets the limit)", common.max_pixels));
  const double needed = pictures * pixels * bytes_a_pixel, free = free_memory_bytes();
  const std::string words =
      fmt::format("{} of {} x {} pixels at once, some {:.1f} GB of memory", counted(pictures, "picture"),
                  size.width_px, size.height_px, needed / 1e9);
  if (needed > free)
    throw InputError(
        file.string(), words,
        fmt::format("{:.1f} GB, which are free: a smaller camera, or fewer --threads", free / 1e9));
  if (needed > bytes_worth_saying) spdlog::info("{}: {}", file.string(), words);
}

void admit(const Scenario& scenario, const CommonOptions& common, int pictures) {
  common.files->reads("colors", scenario.colors);
  common.files->reads("target.taught", scenario.taught);
  admit_camera(scenario.camera.file, scenario.camera.camera.size(), common, pictures);
}

}  // namespace ballservo
