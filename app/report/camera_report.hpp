// The page of `calibrate camera`: how far a calibration can be trusted, in pictures and plain words.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "calibration/boards/board_calibration.hpp"

namespace ballservo {

inline constexpr int overlay_width_px = 800;

struct CameraReportInput {
  const BoardCalibration* calibration = nullptr;
  std::vector<BoardView> views;   ///< as they were calibrated from
  std::vector<cv::Mat> overlays;  ///< of each view, by `board_overlay`, at most `overlay_width_px` wide
  std::vector<std::pair<std::string, std::string>> rejected;  ///< picture and reason
  std::vector<std::string> remarks;                           ///< on pictures that are used
  std::size_t looked_at = 0;                                  ///< pictures in all
};

/// One HTML file that loads nothing: the figures, what to do next, coverage and residuals over the picture,
/// residuals by radius, the error at the ball as a heat map at three distances, each board with its residuals
/// enlarged, the rejected pictures with their reasons.
std::string camera_report_html(const CameraReportInput& input);

/// The corners as found, joined in their order (red: set aside), and their residuals 50 times enlarged.
cv::Mat board_overlay(const cv::Mat& picture, const BoardView& view, const CornerResiduals& corners);

/// "0.177 px", or "unknown" for NaN.
std::string pixels_text(double value_px);

/// What to do next, in plain words; one sentence an item.
std::vector<std::string> calibration_advice(const BoardCalibration& calibration);

}  // namespace ballservo
