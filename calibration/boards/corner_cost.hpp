// The residual of calibration: where a camera would show a board's corner, minus where it was found.
#pragma once

#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// Projected minus found position (px) of one corner as a function of the camera's parameters (in
/// parameter_names' order) and the board's pose, differentiated automatically. `point_m` in the board frame.
std::unique_ptr<ceres::CostFunction> corner_cost(LensModel model, const Eigen::Vector3d& point_m,
                                                 const Eigen::Vector2d& corner_px);

}  // namespace ballservo
