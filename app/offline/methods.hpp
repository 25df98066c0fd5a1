// The estimators that a comparison runs, all on the same picture and the same voted circle.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <opencv2/core.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"
#include "perception/detector.hpp"

namespace ballservo {

enum class FitMethod { vote, paper_one_step, paper_converged, sphere_one_step, sphere_converged };

inline constexpr std::array<FitMethod, 5> all_fit_methods{
    FitMethod::vote, FitMethod::paper_one_step, FitMethod::paper_converged, FitMethod::sphere_one_step,
    FitMethod::sphere_converged};

std::string_view fit_method_name(FitMethod method);  ///< "paper_one_step"
std::optional<FitMethod> fit_method_from_name(std::string_view name);

/// What a method says of the ball in one picture.
struct MethodFit {
  OutlineEllipse outline;         ///< in the picture as given
  Eigen::Vector3d p_C{0, 0, 0};   ///< the ball's centre (m, camera frame)
  std::optional<int> iterations;  ///< steps of the fit; nothing for votes
  std::optional<double> residual_px;
  double time_us =
      0;  ///< vote: the whole detection; one step: choosing the points and the step; converged: Ceres alone
};

/// The answer of each method asked for, in their order; nothing where a method has none. The ball is the
/// detector's best of class `color_class`; its radius must be among the detector's options. One step and
/// converged fit share points, weights and start: those of `BallFitter::refine`.
std::vector<std::optional<MethodFit>> run_methods(Detector& detector, const cv::Mat& bgr,
                                                  ClassIndex color_class,
                                                  const std::vector<FitMethod>& methods);

}  // namespace ballservo
