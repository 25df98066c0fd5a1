// What a comparison renders and runs: conditions, frames and methods, read from a strict YAML file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/offline/methods.hpp"
#include "calibration/camera/camera.hpp"
#include "calibration/files/strict_yaml.hpp"
#include "servo/simulation/sensor.hpp"

namespace ballservo {

/// What stands behind the ball: textured walls and boxes, or walls of one colour.
enum class ComparisonBackground { clutter, plain };

/// One way in which the ball is shown. Every frame of it draws its own background, light and sub-pixel
/// position.
struct ComparisonCondition {
  std::string name;  ///< 1 to 64 of a-z, 0-9 and _
  int frames = 20;
  Camera camera{CameraParameters{LensModel::pinhole, {640, 480}, 857, 857, 319.5, 239.5, {}}};
  std::string ball_color = "red";  ///< a colour word, see color_words()
  double diameter_m = 0.07;
  double depth_m = 1;       ///< Z of the ball's centre
  double off_axis_rad = 0;  ///< angle of the ball's centre from the optical axis
  double occlusion = 0;     ///< fraction of the disc behind something with a straight edge, 0 to 0.8
  ComparisonBackground background = ComparisonBackground::clutter;
  SensorOptions sensor;

  double radius_m() const { return diameter_m / 2; }
};

struct ComparisonPlan {
  std::uint64_t seed = 0;
  std::vector<FitMethod> methods;
  std::vector<ComparisonCondition> conditions;
  std::string resolved_json;  ///< the plan as it was read, keys sorted
};

/// The keys of a plan: `seed`, `frames`, `methods` (a list of names; all where missing), `conditions`, and
/// `defaults`. A condition has a `name` and any of `frames`, `camera` ({focal_px, width_px, height_px} or
/// {file}), `ball` ({color, diameter_m}), `depth_m`, `off_axis_rad`, `occlusion`, `background` (clutter or
/// plain), `noise` ({read, shot}), `blur_px`, `gain`, `gamma`; what it does not say is as in `defaults`, and
/// what that does not say is as in ComparisonCondition. A camera's file is relative to the plan's. Throws
/// InputError naming every fault: unknown and repeated keys, values out of range, condition names that
/// repeat, a ball that does not fit into the picture or hides the camera.
ComparisonPlan read_comparison_plan(const std::filesystem::path& file);

/// The same from text; `folder` is where camera files are looked for, `name` stands for the file in messages.
ComparisonPlan parse_comparison_plan(const std::string& text, const std::string& name,
                                     const std::filesystem::path& folder);

}  // namespace ballservo
