// detections.csv and tracks.csv: one row per ball and picture.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "perception/ball_observation.hpp"

namespace ballservo {

/// The header line, with its newline.
std::string ball_rows_header();

/// What a row says beside the ball.
struct BallRowLabel {
  std::string source;  ///< file name without folders
  int frame = 0;
  double time_s = 0;
  std::optional<int> track_id;  ///< empty for detect
  std::string color_class;
  std::string_view state;  ///< detected, tentative, confirmed, coasting
};

/// One row, with its newline. Numbers round-trip; what is not known stays empty.
std::string ball_row(const BallRowLabel& label, const BallObservation& ball);

}  // namespace ballservo
