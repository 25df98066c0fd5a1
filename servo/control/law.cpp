#include "servo/control/law.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/base/options.hpp"
#include "servo/control/cone_law.hpp"
#include "servo/control/pose_law.hpp"
#include "servo/control/sphere_law.hpp"
#include "servo/control/visp_law.hpp"
#include "servo/motion/option_check.hpp"

namespace ballservo {

Eigen::Vector3d ServoGoal::desired_p_CB() const {
  if (taught_center_over_radius) return ball_radius_m * *taught_center_over_radius;
  return mount.X_RC().inverse() * Eigen::Vector3d(distance_m, 0.0, ball_height_m);
}

Eigen::Vector3d ServoGoal::desired_p_RB() const {
  if (taught_center_over_radius) return mount.X_RC() * desired_p_CB();
  return {distance_m, 0.0, ball_height_m};
}

void ServoGoal::check(FaultList& faults, const std::string& place) const {
  if (!std::isfinite(distance_m) || distance_m <= 0.0) {
    faults.add(place + ".distance_m", shown_number(distance_m), "a number above 0 (m)");
  }
  if (!std::isfinite(ball_height_m))
    faults.add(place + ".ball_height_m", shown_number(ball_height_m), "a number (m)");
  check_positive(faults, place + ".ball_radius_m", ball_radius_m, "m");
  if (taught_center_over_radius &&
      !(taught_center_over_radius->allFinite() && taught_center_over_radius->z() > 1.0)) {
    faults.add(place + ".taught_center_over_radius", "no ball before the camera",
               "three finite numbers, the third above 1 (radii)");
  }
  check_options(faults, place + ".mount", mount);
}

void declare(OptionVisitor& v, LawOptions& law) {
  v.choice("name", law.name, law_names(), "the law");
  v.number("gain_per_s", law.gain_per_s, NumberRange::above(0, 10, "1/s"),
           "lambda of the exponential decay of the error that it asks for");
}

const std::vector<std::string>& law_names() {
  static const std::vector<std::string> names{"cone", "visp", "sphere", "pose"};
  return names;
}

std::unique_ptr<Law> make_law(const LawOptions& options, const ServoGoal& goal) {
  FaultList faults;
  check_options(faults, "law", options);
  goal.check(faults, "target");
  faults.throw_if_any();
  if (options.name == "visp") return std::make_unique<VispLaw>(options, goal);
  if (options.name == "sphere") return std::make_unique<SphereLaw>(options, goal);
  if (options.name == "pose") return std::make_unique<PoseLaw>(options, goal);
  return std::make_unique<ConeLaw>(options, goal);
}

std::optional<LawOutput> decaying(const Law& law, double gain_per_s, const Eigen::Vector3d& p_CB,
                                  const Eigen::Vector3d& v_CB) {
  const auto e = law.errors(p_CB);
  if (!e) return std::nullopt;
  const Eigen::Matrix2d J = *law.robot_jacobian(p_CB);
  const Eigen::Vector2d rate = -gain_per_s * *e - *law.ball_jacobian(p_CB) * v_CB;
  const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
  const Eigen::Vector2d u((J(1, 1) * rate(0) - J(0, 1) * rate(1)) / det,
                          (J(0, 0) * rate(1) - J(1, 0) * rate(0)) / det);
  if (!u.allFinite()) return std::nullopt;
  return LawOutput{{u(0), u(1)}, (*e)(0), (*e)(1)};
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
