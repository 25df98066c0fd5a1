// A camera from pictures of a board, for the command and for Python.
#pragma once

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/commands/command.hpp"
#include "app/report/camera_report.hpp"
#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {

struct CalibrateCameraOptions {
  CommonOptions common;
  std::vector<std::string> sources;
  std::vector<cv::Mat> stills;  ///< instead of sources, as find_boards takes them
  std::string board_text;
  double square_m = std::nan("");
  std::string model = "auto";
  std::filesystem::path output;
  std::string format;
  std::filesystem::path report;
};

/// Looks for the board in the sources and fits a camera of a model that the format holds. Throws InputError,
/// Refusal and Interrupted.
CameraCalibration calibrate_camera(const CalibrateCameraOptions& options, const CameraFileFormat& format);

/// What --json writes of it.
nlohmann::json results_json(const CameraCalibration& calibration);

}  // namespace ballservo
