// Stage 6: the ball's centre in 3-D from a circle, by the paper's formula (paper, "Position 3D", as
// corrected: c_r under the root, c_x and c_y relative to the principal point).
#pragma once

#include <Eigen/Core>
#include <optional>

#include "perception/outline/cone_fit.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

/// z = R sqrt(1 + f^2 / c_r^2), x = c_x z / f, y = c_y z / f (m, camera frame). Exact only on the optical
/// axis: at 1 m a perfect circle is read 2, 18 and 71 mm wrong at 5, 15 and 28 degrees from it.
Eigen::Vector3d paper_position(const UndistortedCircle& circle, double focal_px, double radius_m);

/// Derivative of `paper_position` by (c_x, c_y, c_r), 3 x 3, m per px.
Eigen::Matrix3d paper_position_jacobian(const UndistortedCircle& circle, double focal_px, double radius_m);

/// The cone whose outline in the undistorted picture lies closest to the circle: where the exact fit starts.
/// Nothing for a circle that no ball in front of the camera makes.
std::optional<TangentCone> cone_near_circle(const UndistortedCircle& circle, double focal_px);

}  // namespace ballservo
