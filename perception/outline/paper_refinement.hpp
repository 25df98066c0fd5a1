// Stage 5, the paper's: a circle refined by one Gauss-Newton step on the strongest gradients of a ring
// (paper, "Raffinement des parametres du cercle").
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/camera/ray_table.hpp"

namespace ballservo {

/// A circle in the undistorted picture of square pixels, relative to its principal point (px).
struct UndistortedCircle {
  Eigen::Vector2d center_px{0, 0};
  double radius_px = 0;
};

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

}  // namespace ballservo
