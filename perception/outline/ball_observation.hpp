// A ball as it was seen in one picture.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "calibration/camera/sphere_outline.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "calibration/color/color_table.hpp"
#include "perception/judgement/outline_support.hpp"
#include "perception/outline/cone_fit.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

/// The two ways to fit a ball: the exact tangent cone, or the paper's circle with the paper's formula.
enum class BallFit { sphere, paper };

/// The ball's radius as the user states it (m).
struct BallRadius {
  double radius_m = 0;
  double sigma_m = 0;
};

/// A position in 3-D with its covariance.
struct BallPosition {
  Eigen::Vector3d p_C{0, 0, 0};                                 ///< centre, camera frame, m
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  ///< m^2
};

struct BallObservation {
  ClassIndex color_class = no_class;
  OutlineEllipse outline;  ///< in the picture as given
  TangentCone cone;        ///< direction and angular radius, camera frame
  Eigen::Matrix3d cone_covariance_rad2 = Eigen::Matrix3d::Zero();  ///< of (turn, turn, alpha), see ConeFit
  std::optional<BallPosition> position;  ///< where the camera and the diameter are known
  OutlineSupport support;
  double quality = 0;  ///< 0 to 1
  // How the fit went.
  UndistortedCircle start;  ///< where it started: the votes' circle, or an outline that edges show
  /// What the votes said of the ball's region; nothing where it was found without them.
  std::optional<CircleEstimate> vote;
  double residual_px = 0;  ///< RMS distance of the edge from the outline
  double step_px = 0;      ///< length of the last Gauss-Newton step
  /// Of the step that would follow it on the same points: what stopping leaves, to first order.
  double next_step_px = 0;
  /// Stopping leaves less than would matter: see enough_next_step_px in ball_fitter.hpp.
  bool one_step_enough = false;
  double blur_px = 0;
};

}  // namespace ballservo
