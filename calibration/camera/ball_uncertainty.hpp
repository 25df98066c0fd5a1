// What the uncertainty of a calibration means where it counts: at the ball.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// The standard deviation of a ball's 3-D centre (mm, square root of the covariance's trace) that the camera
/// parameters' covariance causes, the worst over a grid of places at which the whole ball is in the picture
/// (its middle alone where the ball fills it). The ball's outline as the camera sees it is read again with
/// changed parameters; derivatives are central differences along the covariance's own axes. Nothing where no
/// ball of that size can be seen.
std::optional<double> ball_sigma_mm(const Camera& camera, const Eigen::MatrixXd& covariance,
                                    double diameter_m = 0.070, double range_m = 1.0);

}  // namespace ballservo
