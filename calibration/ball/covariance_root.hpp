// The square root of a covariance, and cameras changed along it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// Columns l_i with sum l_i l_i' = covariance; also for a matrix whose entries differ by orders of magnitude.
Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance);

/// The camera with its parameters changed by `step` of a standard deviation up and down along each axis of
/// their covariance (axes without variance are left out); nothing where a change leaves what is valid.
std::optional<std::vector<std::pair<Camera, Camera>>> changed_cameras(const Camera& camera,
                                                                      const Eigen::MatrixXd& covariance,
                                                                      double step);

}  // namespace ballservo
