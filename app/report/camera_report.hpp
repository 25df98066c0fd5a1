// What the page of `calibrate camera` is drawn from: how far a calibration can be trusted.
#pragma once

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/io/board_pictures.hpp"
#include "calibration/base/output.hpp"
#include "calibration/boards/board_calibration.hpp"

namespace ballservo {

struct CameraCalibration {
  BoardPictures pictures;
  std::vector<const BoardPicture*> used;  ///< of the pictures
  std::vector<BoardView> views;           ///< of the board in those
  BoardCalibration result;
};

/// Writes the boards' overlays into the folder, and returns the contents of report.json: the figures, what to
/// do next, corners and residuals, the error at the ball over the picture at three distances, the rejected
/// pictures. Throws Interrupted.
nlohmann::ordered_json camera_report(const CameraCalibration& calibration, double max_pixels,
                                     const OutputFolder& folder);

/// The corners as found, joined in their order (red: set aside), and their residuals 50 times enlarged.
cv::Mat board_overlay(const cv::Mat& picture, const BoardView& view, const CornerResiduals& corners);

/// "0.177 px", or "unknown" for NaN.
std::string pixels_text(double value_px);

/// What a calibration lacks to be used as it is, and what to do about it, in plain words; empty: nothing.
std::vector<std::string> calibration_lacks(const BoardCalibration& calibration);

/// What to do next, in plain words; one sentence an item.
std::vector<std::string> calibration_advice(const BoardCalibration& calibration);

}  // namespace ballservo
