// What the page of `calibrate camera` is drawn from: how far a calibration can be trusted.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "calibration/base/output.hpp"
#include "calibration/boards/board_calibration.hpp"

namespace ballservo {

struct CameraReportInput {
  const BoardCalibration* calibration = nullptr;
  std::vector<BoardView> views;                               ///< as they were calibrated from
  std::function<cv::Mat(std::size_t view)> overlay;           ///< of each view, by `board_overlay`
  std::vector<std::pair<std::string, std::string>> rejected;  ///< picture and reason
  std::vector<std::string> remarks;                           ///< on pictures that are used
  std::size_t looked_at = 0;                                  ///< pictures in all
};

/// Writes the boards' overlays into the folder, and returns the contents of report.json: the figures, what to
/// do next, corners and residuals, the error at the ball over the picture at three distances, the rejected
/// pictures.
nlohmann::ordered_json camera_report(const CameraReportInput& input, const OutputFolder& folder);

/// The corners as found, joined in their order (red: set aside), and their residuals 50 times enlarged.
cv::Mat board_overlay(const cv::Mat& picture, const BoardView& view, const CornerResiduals& corners);

/// "0.177 px", or "unknown" for NaN.
std::string pixels_text(double value_px);

/// What a calibration lacks to be used as it is, and what to do about it, in plain words; empty: nothing.
std::vector<std::string> calibration_lacks(const BoardCalibration& calibration);

/// What to do next, in plain words; one sentence an item.
std::vector<std::string> calibration_advice(const BoardCalibration& calibration);

}  // namespace ballservo
