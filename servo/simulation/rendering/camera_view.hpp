// Where the camera is and when.
#pragma once

#include <Eigen/Geometry>

namespace ballservo {

/// Where the camera is at one instant of an exposure.
struct CameraView {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  double time_s = 0;
};

}  // namespace ballservo
