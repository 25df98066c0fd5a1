// What somebody does to a run while it goes on, and the file that does it again.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/scenario/scenario.hpp"

namespace ballservo {

struct Touch {
  enum class Kind { ball, obstacle, box, robot, law, gain, latency, noise, light, avoidance };

  long step = 0;  ///< it happens after this control step, before the next one
  Kind kind = Kind::ball;
  std::string name;  ///< the obstacle's, the law's
  Pose2 to;          ///< where the ball, the obstacle, a new box is put; where the robot is pushed
  double value = 0;  ///< gain (1/s); latency (s); noise, light: factor on the scenario's own
  AvoidanceOptions::Type avoidance = AvoidanceOptions::Type::none;
};

/// A run that was touched: how many steps it took, and the touches in their order.
struct Touches {
  long steps = 0;
  std::vector<Touch> list;

  /// How long the run lasts: up to its last step.
  double duration_s(const Scenario& scenario) const {
    return static_cast<double>(steps - 1) / scenario.control_rate_hz;
  }
};

/// The scenario as a touch leaves it; `untouched` is what noise and light are factors of. A ball that is put
/// somewhere stays there. Where the robot is, no scenario says.
void touch_scenario(const Touch& touch, const Scenario& untouched, Scenario& scenario);

/// A touch after `step`, from its text without `step`: "{do: ball, x_m: 1, y_m: 0}", as YAML or JSON. Throws
/// InputError for what the scenario, as it stands, does not allow.
Touch parse_touch(const std::string& text, long step, const Scenario& untouched, const Scenario& scenario);

/// Reads a touches file for a scenario. Throws InputError with every fault, each with its line.
Touches read_touches(const std::filesystem::path& file, const Scenario& scenario);
/// As YAML that read_touches reads.
std::string touches_yaml(const Touches& touches);

}  // namespace ballservo
