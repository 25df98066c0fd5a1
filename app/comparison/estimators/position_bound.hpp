// The Cramer-Rao bound of a ball's place: no unbiased estimator has a smaller covariance in such a picture
// (Rao 1945, Cramer 1946).
//
// The picture's model, in an arc segment of the outline and a channel c, with t the distance outside the
// outline of a ball at p_C through the camera's own lens (px), x = -t/s, and s the width of the edge (blur
// and the pixel's square, s^2 = blur^2 + 1/12):
//   I_c(t) = O_c + A_c Phi(x) + B_c sqrt(s) F(x) + D_c s R(x),     Phi, F, R as in perception/edge_model.hpp
// A Lambertian limb is a root and a ramp in the distance inside. Every pixel near the outline adds
// (dI_c/dp)(dI_c/dp)^T / variance to the Fisher information of p = (p_C, nuisances); the nuisances are
// eliminated by the Schur complement. O, A, B, D are read off the picture without noise.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// A ball in a picture of which everything is known.
struct BoundScene {
  const Camera& camera;
  Eigen::Vector3d p_CB{0, 0, 0};  ///< m, camera frame
  double radius_m = 0;
  double blur_px = 0;     ///< sigma of the optics' blur
  double read_noise = 0;  ///< grey levels
  double shot_noise = 0;  ///< grey levels; variance = read_noise^2 + shot_noise * level + 1/12 (rounding)
  cv::Mat clean_bgr;      ///< CV_8UC3 or CV_32FC3, grey levels, blurred but without noise
  /// CV_8UC1, 0 where something hides the ball or what lies behind it; empty: nothing does.
  cv::Mat unhidden;
};

/// What the estimator is not told.
struct BoundNuisances {
  bool blur = true;        ///< s, one for the picture
  bool background = true;  ///< O, of every arc segment and channel
  bool contrast = true;    ///< A, of every arc segment and channel
  bool shading = true;  ///< slopes of root and ramp relative to the ball's level, of every arc segment: the
                        ///< light has one colour
};
inline constexpr BoundNuisances nothing_unknown{false, false, false, false};

/// The least covariance (m^2, camera frame) of the ball's centre, its radius and the camera known. Nothing
/// where the picture does not determine it: too little of the outline in view, no contrast
/// (a sigma above the distance).
std::optional<Eigen::Matrix3d> position_bound(const BoundScene& scene, const BoundNuisances& unknown = {});

}  // namespace ballservo
