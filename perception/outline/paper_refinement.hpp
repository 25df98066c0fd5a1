// Stage 5, the paper's: a circle refined by one Gauss-Newton step on the strongest gradients of a ring
// (paper, "Raffinement des parametres du cercle").
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/base/fault.hpp"
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

struct RingOptions {
  double half_width_px = 2.5;
  /// How many pixels are kept, as a multiple of the circle's circumference in px: the strongest.
  double kept_per_circumference_px = 1.0;

  void check(FaultList& faults, const std::string& place) const;  ///< adds every value that makes no sense
};

/// The ring's strongest gradient pixels (central differences of the grey level) around a circle.
void select_ring_pixels(const cv::Mat& bgr, const RayTable& rays, const UndistortedCircle& circle,
                        const RingOptions& options, std::vector<RingPixel>& ring);

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
