#include "perception/detector_options.hpp"

#include <cmath>

#include "calibration/base/numbers.hpp"
#include "calibration/base/range_check.hpp"

namespace ballservo {

BallRadius DetectorOptions::radius_of(ClassIndex color_class) const {
  const std::size_t index = static_cast<std::size_t>(color_class) - 1;
  return color_class != no_class && index < radii.size() ? radii[index] : BallRadius{};
}

void DetectorOptions::validate() const {
  FaultList faults;
  check_range(faults, "max_regions", max_regions, 1, 1 << 20);
  check_range(faults, "max_runs", max_runs, 1, 1 << 24);
  check_range(faults, "threads", threads, 1, most_threads);
  check_range(faults, "oval_fraction", oval_fraction, 0, 0.3);
  for (const BallRadius& radius : radii) {
    if (!(radius.radius_m >= 0) || !std::isfinite(radius.radius_m))
      faults.add("radii", number_text(radius.radius_m), "a positive length (m), or 0 where unknown");
    if (!(radius.sigma_m >= 0) || !std::isfinite(radius.sigma_m))
      faults.add("radii", number_text(radius.sigma_m), "a sigma of 0 or more (m)");
  }
  judge.check(faults, "judge");
  faults.throw_if_any();
}

}  // namespace ballservo
