#include "servo/control/law.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/base/options.hpp"

namespace ballservo {

Eigen::Vector3d ServoGoal::desired_p_CB() const {
  if (taught_center_over_radius) return ball_radius_m * *taught_center_over_radius;
  return mount.X_RC().inverse() * Eigen::Vector3d(distance_m, 0.0, ball_height_m);
}

Eigen::Vector3d ServoGoal::desired_p_RB(double scale) const {
  if (taught_center_over_radius) return mount.X_RC() * (desired_p_CB() / scale);
  return {distance_m, 0.0, ball_height_m};
}

void declare(OptionVisitor& v, ServoGoal& goal) {
  v.number("distance_m", goal.distance_m, NumberRange::above(0, "m"), "axle to the ball's centre");
  v.number("ball_height_m", goal.ball_height_m, NumberRange::any("m"), "of the ball's centre over the floor");
  v.number("ball_radius_m", goal.ball_radius_m, NumberRange::above(0, "m"), "as perception believes");
  v.part("mount", goal.mount);
  const auto& taught = goal.taught_center_over_radius;
  v.require(!taught || (taught->allFinite() && taught->z() > 1.0), "taught_center_over_radius",
            "no ball before the camera", "three finite numbers, the third above 1 (radii)");
}

void declare(OptionVisitor& v, LawOptions& law, const std::vector<std::string>& names) {
  v.choice("name", law.name, names, "the law");
  v.number("gain_per_s", law.gain_per_s, NumberRange::above(0, 10, "1/s"),
           "lambda of the exponential decay of the error that it asks for");
}

void LawCatalog::add(const std::string& name, Factory factory) {
  for (auto& [known, its_factory] : laws_) {
    if (known != name) continue;
    its_factory = std::move(factory);
    return;
  }
  laws_.emplace_back(name, std::move(factory));
}

std::vector<std::string> LawCatalog::names() const {
  std::vector<std::string> names;
  for (const auto& [name, factory] : laws_) names.push_back(name);
  return names;
}

std::unique_ptr<Law> LawCatalog::make(const LawOptions& options, const ServoGoal& goal) const {
  const auto found =
      std::find_if(laws_.begin(), laws_.end(), [&](const auto& law) { return law.first == options.name; });
  FaultList faults;
  OptionChecker checker(faults, "law");
  LawOptions law = options;
  declare(checker, law, names());
  check_options(faults, "target", goal);
  faults.throw_if_any();
  return found->second(options, goal);
}

double max_stable_gain_per_s(double sample_rate_hz, double delay_s) {
  constexpr double pi = 3.14159265358979323846;
  const double periods = std::ceil(delay_s * sample_rate_hz - 1e-9);
  return 2.0 * std::sin(pi / (2.0 * (2.0 * periods + 1.0))) * sample_rate_hz;
}

double ahead_of_axle_m(const CameraMount& mount, const Eigen::Vector3d& p_CB) {
  return std::cos(mount.pitch_down_rad) * p_CB.z() - std::sin(mount.pitch_down_rad) * p_CB.y() +
         mount.forward_m;
}

}  // namespace ballservo
