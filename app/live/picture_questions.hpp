// What the page shows of a picture, and its answer to "why is this no ball?".
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "perception/detection_stages.hpp"
#include "perception/detector.hpp"
#include "perception/tracking/tracker.hpp"

namespace ballservo {

/// A picture with what was made of it. Without a detector nothing was looked for.
struct SeenPicture {
  const cv::Mat& bgr;
  const DetectionStages* stages;
  const Detector* detector;
  const ColorTable& colors;
};

/// The picture of a view (see live_views), which may be `seen.bgr` itself; empty for one that there is not.
cv::Mat live_picture(const std::string& view, const SeenPicture& seen);

/// What was looked at for a ball: class, outline_px, accepted, reason, remedy.
nlohmann::json candidates_json(const DetectionStages& stages, const ColorTable& colors);

/// The answer to a click: {"ball": whether one is there, "text": what was found and why it is none,
/// "figures": of it, "remedy": what helps}. `tracks` are those of the picture.
nlohmann::json why_no_ball(const cv::Mat& bgr, const Eigen::Vector2d& point_px, Detector& detector,
                           const std::vector<Track>& tracks);

/// "1.002 m +- 1.1 mm": the range with its 95 % half-width, and the widest one across.
std::string position_text(const BallPosition& position);

}  // namespace ballservo
