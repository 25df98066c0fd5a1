// OpenCV's camera YAML, as its calibration programs write it through cv::FileStorage.
#pragma once

#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {

/// camera_matrix, distortion_coefficients, image_width and image_height, in the spellings of OpenCV's own
/// programs (calibration, interactive-calibration, and those of OpenCV 2). 4, 5 coefficients are `brown`
/// (`pinhole` where all are 0), 8 `brown8`; 12 and 14 (thin prism, tilted sensor) only where the additional
/// ones are 0; with `fisheye_model: 1` the 4 are `kannala_brandt`. A FileStorage may hold anything besides,
/// which is left aside, but for keys that speak of the lens. Read without cv::FileStorage, which takes words
/// for numbers and missing keys for 0.
CameraFileFormat opencv_camera_format();

}  // namespace ballservo
