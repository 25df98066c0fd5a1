// The page of `calibrate diff`: how two cameras disagree, and whether that means anything.
#pragma once

#include <string>

#include "calibration/ball/camera_difference.hpp"

namespace ballservo {

/// Two camera files, as the user named them, and what came of comparing them.
struct ComparedCameras {
  std::string name_a, name_b;
  bool known_a = false, known_b = false;  ///< whether the covariance of its parameters was found
  ImageSize size;
  CameraDifferenceOptions options;
  CameraDifference difference;
};

/// Differences that chance alone would exceed less often than this are more than the uncertainties allow.
inline constexpr double least_chance = 0.01;

/// What the uncertainties say of the difference, in words.
std::string uncertainty_verdict(const ComparedCameras& compared);

/// The whole page (HTML).
std::string difference_page(const ComparedCameras& compared);

}  // namespace ballservo
