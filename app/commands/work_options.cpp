#include "app/commands/work_options.hpp"

#include <fmt/format.h>

#include "app/scenario/scenario.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {

void add_work_options(CLI::App& command, WorkOptions& options) {
  add_output_option(command, "-o,--output", options.output, "DIR", "Folder for the results; required");
  command.add_option("--shard", options.shard, "Run only part I of N (I from 1)")
      ->type_name("I/N")
      ->capture_default_str();
  command.add_flag("--resume", options.resume, "Go on with what an earlier run left in the folder");
}

CLI::App* add_merge_command(CLI::App& command, Action& action, std::function<int(const MergeOptions&)> merge,
                            const std::function<void(CLI::App&, MergeOptions&)>& more_options) {
  auto options = std::make_shared<MergeOptions>();
  CLI::App* subcommand = command.add_subcommand("merge");
  subcommand->add_option("DIR", options->folders, "Folders of all parts (--shard I/N), in any order")
      ->required();
  add_output_option(*subcommand, "-o,--output", options->output, "DIR", "Folder for the results")->required();
  if (more_options) more_options(*subcommand, *options);
  add_common_options(*subcommand, options->common);
  subcommand->callback([&action, options, merge] { action = [options, merge] { return merge(*options); }; });
  return subcommand;
}

void add_against_option(CLI::App& command, std::filesystem::path& against) {
  command.add_option("--against", against, "Folder of another sweep to compare with, seed by seed")
      ->type_name("DIR");
}

void add_set_option(CLI::App& command, std::vector<std::string>& sets) {
  command
      .add_option("--set", sets,
                  "Sets a value of the scenario before it is read, e.g. law.name=visp (may be repeated)")
      ->type_name("KEY.PATH=VALUE")
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

void admit_camera(const std::filesystem::path& file, ImageSize size, const CommonOptions& common) {
  common.files->reads("a camera", file);
  if (static_cast<double>(size.width_px) * size.height_px > common.max_pixels)
    throw InputError(file.string(), fmt::format("{} x {} pixels", size.width_px, size.height_px),
                     fmt::format("at most {:.0f} pixels (--max-pixels sets the limit)", common.max_pixels));
}

void admit(const Scenario& scenario, const CommonOptions& common) {
  common.files->reads("colors", scenario.colors);
  common.files->reads("target.taught", scenario.taught);
  admit_camera(scenario.camera.file, scenario.camera.camera.size(), common);
}

}  // namespace ballservo
