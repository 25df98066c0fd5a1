// The estimators that a comparison runs, all on the same picture and the same starting circle.
//
// A method is a function of a MethodScene and one line in the list in methods.cpp.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

class MethodScene;
struct FrameTruth;

/// What a method says of the ball in one picture. What only fits know is left open by the others.
struct MethodFit {
  OutlineEllipse outline;        ///< in the picture as given
  Eigen::Vector3d p_C{0, 0, 0};  ///< the ball's centre (m, camera frame)
  std::optional<int> iterations;
  std::optional<double> residual_px;   ///< weighted RMS distance of the points from the outline
  std::optional<double> step_px;       ///< largest move of the outline by the last Gauss-Newton step
  std::optional<double> next_step_px;  ///< of the step that would follow on the same points
  std::optional<double> arc;           ///< of the outline, has points of weight (0 to 1)
  std::optional<double> condition;     ///< of the weighted Jacobian
  std::optional<bool> converged;
  /// Of p_C (m^2), where the method states how sure it is.
  std::optional<Eigen::Matrix3d> covariance_m2;
  int others = 0;      ///< balls that a whole detector reports beside this one
  double time_us = 0;  ///< from the picture and the starting circle; vote: from the picture
};

/// What a method shares with others: the detection or the points around the starting circle, which are part
/// of every one's time; or a detector that has seen pictures before, which is not.
enum class MethodPoints { none, detection, ring, edges, sphere_detector, paper_detector };

struct FitMethod {
  std::string name;
  std::string minimises;  ///< what it does, in a phrase, for the report
  MethodPoints points = MethodPoints::none;
  bool is_peer = false;  ///< somebody else's recipe, that starts from the picture alone
  /// One of the two: an estimate of the one ball, or of a whole detector everything that it reports.
  std::function<std::optional<MethodFit>(MethodScene&)> fit;
  std::function<std::vector<MethodFit>(MethodScene&)> detect{};
};

/// Every method there is. Pointers into the list stay valid.
const std::vector<FitMethod>& fit_methods();
/// Null where there is none of that name.
const FitMethod* find_fit_method(std::string_view name);

using MethodList = std::vector<const FitMethod*>;
/// Where a method stands in a list; nothing where it does not.
std::optional<std::size_t> place_of(const MethodList& methods, std::string_view name);

/// The answer of each method asked for, in their order; nothing where a method has none. Of what a whole
/// detector reports the one that is at the ball and nearest to its centre, else its best; `truth` serves this
/// choice alone.
std::vector<std::optional<MethodFit>> run_methods(MethodScene& scene, const MethodList& methods,
                                                  const FrameTruth& truth);

}  // namespace ballservo
