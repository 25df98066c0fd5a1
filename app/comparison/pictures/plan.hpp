// What a comparison renders and runs: conditions, frames and methods, read from a strict YAML file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/comparison/estimators/converged_fits.hpp"
#include "app/comparison/estimators/methods.hpp"
#include "app/comparison/pictures/condition.hpp"

namespace ballservo {

struct ComparisonPlan {
  std::uint64_t seed = 0;
  MethodList methods;
  RobustLoss loss{RobustLossKind::cauchy, 0.3};
  std::vector<ComparisonCondition> conditions;
  std::vector<std::filesystem::path> files;  ///< of cameras that it names
  bool paper_claims = false;                 ///< the paper's claims are looked at one by one
  std::string text;           ///< as it was read: the order of a design's keys is that of its conditions
  std::string resolved_json;  ///< keys sorted
};

/// A condition is as in `defaults` where it says nothing, and those as in ComparisonCondition. A camera's
/// file is relative to the plan's, and its covariance stands beside it. `design` makes conditions from lists
/// of numbers (see PlanDesign).
///
/// Throws InputError naming every fault: unknown and repeated keys, values out of range, condition names that
/// repeat, a ball that does not fit into the picture or hides the camera.
ComparisonPlan read_comparison_plan(const std::filesystem::path& file);

/// The same from text; `folder` is where camera files are looked for, `name` stands for the file in messages.
ComparisonPlan parse_comparison_plan(const std::string& text, const std::string& name,
                                     const std::filesystem::path& folder);

/// Every key of a plan.
std::vector<OptionRow> plan_keys();

/// What a plan will take, roughly: measured on one core, scaled by pixels, frames and methods.
struct PlanEstimate {
  double frames = 0;
  double core_hours = 0;
  double disk_bytes = 0;
};
PlanEstimate estimate(const ComparisonPlan& plan);

/// "1.2 hours on 2 cores, 30 MB"
std::string in_words(const PlanEstimate& estimate, int threads);

}  // namespace ballservo
