#include "app/scenario/taught_target.hpp"

#include <fmt/format.h>

#include <vector>

#include "calibration/base/numbers.hpp"
#include "calibration/base/strict_yaml.hpp"

namespace ballservo {
namespace {

Eigen::Vector3d read_vector(YamlNode node, const std::string& key, const NumberRange& range) {
  const std::vector<double> v = node.numbers(key, range, 3);
  return v.size() == 3 ? Eigen::Vector3d(v[0], v[1], v[2]) : Eigen::Vector3d::Zero();
}

std::string vector_text(const Eigen::Vector3d& v) {
  return fmt::format("[{}, {}, {}]", number_text(v.x()), number_text(v.y()), number_text(v.z()));
}

}  // namespace

std::string taught_target_yaml(const TaughtTarget& target) {
  return fmt::format(
      R"(# What the robot saw of the ball when it stood at the goal. In a scenario: target: {{ball: {0}, taught: THIS_FILE}}
ball: {0}
center_over_radius: {1}   # the ball's centre in the camera frame (x right, y down, z forward), in radii
sigma: {2}   # standard deviations, of the mean over the frames
frames: {3}
distance_m: {4}   # where it stood, axle to the ball's centre: nothing but the errors in summaries depends on it
)",
      target.ball, vector_text(target.center_over_radius), vector_text(target.sigma), target.frames,
      number_text(target.distance_m));
}

TaughtTarget read_taught_target(const std::filesystem::path& file) {
  StrictYaml yaml = StrictYaml::from_file(file);
  YamlNode root = yaml.root();
  TaughtTarget target;
  target.ball = root.text("ball");
  target.center_over_radius =
      read_vector(root, "center_over_radius", NumberRange::within(-1e4, 1e4, "radii"));
  if (root.has("center_over_radius") && !(target.center_over_radius.z() > 1)) {
    root.fault("center_over_radius", vector_text(target.center_over_radius),
               "a ball before the camera: the third number above 1");
  }
  target.sigma = read_vector(root, "sigma", NumberRange::within(0, 1e4, "radii"));
  target.frames = static_cast<int>(root.integer("frames", 1, 1000000));
  target.distance_m = root.number("distance_m", NumberRange::above(0, 20, "m"));
  yaml.finish();
  return target;
}

}  // namespace ballservo
