#include "perception/detector_options.hpp"

#include <cmath>
#include <string>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

void DetectorOptions::validate() const {
  FaultList faults;
  const auto fraction = [&](const char* name, double value) {
    if (!(value >= 0 && value <= 1)) faults.add(name, number_text(value), "a number from 0 to 1");
  };
  fraction("max_leak", max_leak);
  fraction("max_small_leak", max_small_leak);
  fraction("min_quality", min_quality);
  fraction("min_shading_explained", min_shading_explained);
  if (!(min_radius_px >= 2))
    faults.add("min_radius_px", number_text(min_radius_px), "a number of at least 2 (px)");
  if (max_regions < 1) faults.add("max_regions", std::to_string(max_regions), "at least 1");
  if (threads < 1 || threads > most_threads)
    faults.add("threads", std::to_string(threads),
               "a whole number from 1 to " + std::to_string(most_threads));
  if (!(min_frayed_edge > 0 && min_frayed_edge <= 1))
    faults.add("min_frayed_edge", number_text(min_frayed_edge), "a number above 0 and at most 1");
  if (!(min_enclosing_edge > 0 && min_enclosing_edge <= 1))
    faults.add("min_enclosing_edge", number_text(min_enclosing_edge), "a number above 0 and at most 1");
  if (!(min_expected_edge > 0 && min_expected_edge <= 1))
    faults.add("min_expected_edge", number_text(min_expected_edge), "a number above 0 and at most 1");
  if (max_runs < 1) faults.add("max_runs", std::to_string(max_runs), "at least 1");
  for (const BallRadius& radius : radii) {
    if (!(radius.radius_m >= 0) || !std::isfinite(radius.radius_m))
      faults.add("radii", number_text(radius.radius_m), "a positive length (m), or 0 where unknown");
    if (!(radius.sigma_m >= 0) || !std::isfinite(radius.sigma_m))
      faults.add("radii", number_text(radius.sigma_m), "a sigma of 0 or more (m)");
  }
  if (!(oval_fraction >= 0 && oval_fraction <= 0.3))
    faults.add("oval_fraction", number_text(oval_fraction), "a number from 0 to 0.3");
  vote.check(faults, "vote");
  edges.check(faults, "edges");
  ring.check(faults, "ring");
  faults.throw_if_any();
}

}  // namespace ballservo
