// ROS' camera_info YAML, as camera_calibration writes it and camera_info_manager reads it.
#pragma once

#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {

/// plumb_bob is `brown` (`pinhole` where all its coefficients are 0), rational_polynomial `brown8`,
/// equidistant `kannala_brandt`. Rectification, projection, binning and region of interest describe a use of
/// the camera, not its lens: they are checked and left aside.
CameraFileFormat ros_camera_format();

}  // namespace ballservo
