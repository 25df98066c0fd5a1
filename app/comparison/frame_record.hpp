// What a comparison keeps of a frame: its truth, and what each method said.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/comparison/estimators/methods.hpp"

namespace ballservo {

/// As truth.csv has it; what is not known is open.
struct FrameTruth {
  std::string source = "rendered";
  int frame = 0;
  bool has_ball = true;  ///< false: whatever is reported is false
  std::optional<OutlineEllipse> outline;
  std::optional<Eigen::Vector3d> p_CB;  ///< m
  std::optional<double> visible_fraction;
  /// The least covariance (m^2) of any unbiased estimate of p_CB (see position_bound); its root mean traces.
  std::optional<double> bound_m, bound_depth_m;
};

/// What the votes were like.
struct VoteFacts {
  int votes = 0, points = 0;
  double quality = 0;  ///< the paper's Q_c
};

struct ComparisonRecord {
  FrameTruth truth;
  std::optional<VoteFacts> facts;
  int passes = 0;  ///< times that the exact fit's points were measured; 0: it had none
  std::vector<std::optional<MethodFit>> fits;
};

/// Whether an answer has found the ball (see is_found). A method that locked onto something else has not,
/// however well it fits that. Where no circle is known every answer counts; where there is no ball, none.
bool at_the_ball(const MethodFit& fit, const FrameTruth& truth);

/// How far two answers lie apart in the picture (px): their centres or their radii, whichever is more.
double apart_px(const MethodFit& a, const MethodFit& b);
/// One step breaks in a frame where it lies further than this from the converged fit.
inline constexpr double break_px = 0.05;

/// Compact JSON, every number as it was; and back. Throws nlohmann's exceptions for anything else.
nlohmann::json json_of(const ComparisonRecord& record);
ComparisonRecord record_from_json(const nlohmann::json& json);

}  // namespace ballservo
