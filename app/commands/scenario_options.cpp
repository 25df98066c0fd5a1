#include "app/commands/scenario_options.hpp"

namespace ballservo {

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
      .add_option(
          "--perception", level,
          "image: rendered frames, detector and tracker; geometric: the true place with a fit's errors; "
          "truth: the true place")
      ->capture_default_str();
}

}  // namespace ballservo
