// What the paper says of its first stages, measured: votes, their quality, boundaries, classes, times.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "app/comparison/pictures/plan.hpp"

namespace ballservo {

/// Medians over a few frames of the plan's defaults with things of the ball's colour in them.
struct PaperMeasurements {
  double votes = 0, votes_largest = 0;  ///< N_votes of whole balls: median, most
  double quality_ball = 0;              ///< Q_c of a whole ball's region
  double quality_touching = 0;          ///< of a ball whose region holds a bar that touches it, too
  double quality_other = 0;             ///< of regions of the same colour that are not round
  double boundary_px = 0;               ///< pixels on the boundaries of all regions of the colour
  double edge_px = 0;                   ///< luminance edges (Canny, 50 and 150) in the same pictures
  /// The part of the balls' pixels that are told to be of their own class, with so many classes at once.
  std::vector<int> class_counts;
  std::vector<double> class_right, class_wrong;  ///< wrong: of another class
  // One thread, a picture of 1024x683 (0.7 Mpix). Times are the machine's.
  double read_us = 0, segment_us = 0, vote_us = 0, detect_us = 0;
};

PaperMeasurements measure_paper_claims(const ComparisonPlan& plan);

nlohmann::json to_json(const PaperMeasurements& measurements);
PaperMeasurements paper_measurements_from_json(const nlohmann::json& json);

}  // namespace ballservo
