// Stage 5, the paper's: a circle refined by one Gauss-Newton step on the strongest gradients of a ring
// (paper, "Raffinement des parametres du cercle").
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "perception/outline/cone_fit.hpp"

namespace ballservo {

/// A pixel of the ring that was kept.
struct RingPixel {
  Eigen::Vector2d position_px{0, 0};  ///< undistorted, relative to the principal point
  double weight = 0;                  ///< |grad I|^2, grey levels^2 per px^2
  int u_px = 0, v_px = 0;             ///< where it lies in the picture
};

/// The strongest gradient pixels (central differences of the grey level) of a ring around a circle: as many
/// as its circumference has px.
void select_ring_pixels(const cv::Mat& bgr, const RayTable& rays, const UndistortedCircle& circle,
                        std::vector<RingPixel>& ring);

struct CircleFit {
  UndistortedCircle circle;
  Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();  ///< of (c_x, c_y, c_r)
  double residual_px = 0;                                    ///< weighted RMS of C after the step
  double step_px = 0;                                        ///< largest move of the outline
  int used = 0;
};

/// Exactly one Gauss-Newton step of E(c) = sum |grad I|^2 C(c)^2, C = sqrt((p_x - c_x)^2 + (p_y - c_y)^2) -
/// c_r, with the pixels held fixed: delta = -(J'WJ)^-1 J'W C. Nothing for fewer than 3 pixels or a degenerate
/// set.
std::optional<CircleFit> one_gauss_newton_step(const UndistortedCircle& start,
                                               const std::vector<RingPixel>& ring);

// Stage 6: the ball's centre in 3-D from a circle, by the paper's formula (paper, "Position 3D", as
// corrected: c_r under the root, c_x and c_y relative to the principal point).

/// z = R sqrt(1 + f^2 / c_r^2), x = c_x z / f, y = c_y z / f (m, camera frame). Exact only on the optical
/// axis: at 1 m a perfect circle is read 2, 18 and 71 mm wrong at 5, 15 and 28 degrees from it.
Eigen::Vector3d paper_position(const UndistortedCircle& circle, double focal_px, double radius_m);

/// Derivative of `paper_position` by (c_x, c_y, c_r), 3 x 3, m per px.
Eigen::Matrix3d paper_position_jacobian(const UndistortedCircle& circle, double focal_px, double radius_m);

/// The cone whose outline in the undistorted picture lies closest to the circle: where the exact fit starts.
/// Nothing for a circle that no ball in front of the camera makes.
std::optional<TangentCone> cone_near_circle(const UndistortedCircle& circle, double focal_px);

}  // namespace ballservo
