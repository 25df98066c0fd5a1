#include "servo/control/law.hpp"

#include <cmath>

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
  try {
    mount.validate();
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults())
      faults.add(place + "." + fault.place, fault.found, fault.allowed);
  }
}

void LawOptions::check(FaultList& faults, const std::string& place) const {
  if (!(gain_per_s > 0.0 && gain_per_s <= 10.0)) {
    faults.add(place + ".gain_per_s", shown_number(gain_per_s), "a number above 0 and up to 10 (1/s)");
  }
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
