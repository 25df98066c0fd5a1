#include "servo/law.hpp"

#include <algorithm>
#include <cmath>

#include "servo/cone_law.hpp"
#include "servo/option_check.hpp"
#include "servo/visp_law.hpp"

namespace ballservo {

Eigen::Vector3d ServoGoal::desired_p_CB() const {
  return mount.X_RC().inverse() * Eigen::Vector3d(distance_m, 0.0, ball_height_m);
}

void ServoGoal::check(FaultList& faults, const std::string& place) const {
  if (!std::isfinite(distance_m) || distance_m <= 0.0) {
    faults.add(place + ".distance_m", shown_number(distance_m), "a number above 0 (m)");
  }
  if (!std::isfinite(ball_height_m))
    faults.add(place + ".ball_height_m", shown_number(ball_height_m), "a number (m)");
  try {
    mount.validate();
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults())
      faults.add(place + "." + fault.place, fault.found, fault.allowed);
  }
}

void LawOptions::check(FaultList& faults, const std::string& place) const {
  const auto& names = law_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    std::string allowed = "one of";
    for (const std::string& known : names) allowed += " " + known;
    faults.add(place + ".name", name, allowed);
  }
  if (!(gain_per_s > 0.0 && gain_per_s <= 10.0)) {
    faults.add(place + ".gain_per_s", shown_number(gain_per_s), "a number above 0 and up to 10 (1/s)");
  }
}

const std::vector<std::string>& law_names() {
  static const std::vector<std::string> names{"cone", "visp"};
  return names;
}

std::unique_ptr<Law> make_law(const LawOptions& options, const ServoGoal& goal) {
  FaultList faults;
  options.check(faults, "law");
  goal.check(faults, "target");
  faults.throw_if_any();
  if (options.name == "visp") return std::make_unique<VispLaw>(options, goal);
  return std::make_unique<ConeLaw>(options, goal);
}

double ahead_of_axle_m(const CameraMount& mount, const Eigen::Vector3d& p_CB) {
  return std::cos(mount.pitch_down_rad) * p_CB.z() - std::sin(mount.pitch_down_rad) * p_CB.y() +
         mount.forward_m;
}

}  // namespace ballservo
