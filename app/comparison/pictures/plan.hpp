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
  bool paper_claims = false;  ///< the paper's claims are looked at one by one
  std::string text;           ///< as it was read: the order of a design's keys is that of its conditions
  std::string resolved_json;  ///< keys sorted
};

/// The keys of a plan: `seed`, `frames`, `methods` (a list of names; all where missing), `robust` ({loss:
/// huber, cauchy or tukey, scale_px}), `claims` (paper), `defaults`, `conditions`, `design`.
///
/// A condition has a `name` and any of: the numbers of condition_factors() (`noise.read` is {noise:
/// {read:}}), `frames`, `camera` ({focal_px, width_px, height_px, model, coefficients} or {file}), `ball`
/// ({color, diameter_m, pattern}), `occlusion_side`, `background` (clutter or plain), `touching`, `no_ball`,
/// `at_border`, `pictures` ({type: lab, room or painted; half_shade, highlight, marbled, contact_shadow}: see
/// Painter). What it does not say is as in `defaults`, and what that does not say is as in
/// ComparisonCondition. A camera's file is relative to the plan's, and its covariance stands beside it.
///
/// `design` makes conditions from lists of numbers: {type: one_at_a_time, vary: {depth_m: [0.5, 1, 2], ...}}
/// changes one number of the defaults at a time, {type: grid} makes all combinations, {type: random,
/// conditions: N, vary: {depth_m: {uniform: [0.5, 3]}, noise.read: {log_uniform: [0.5, 10]}}} draws them.
///
/// Throws InputError naming every fault: unknown and repeated keys, values out of range, condition names that
/// repeat, a ball that does not fit into the picture or hides the camera.
ComparisonPlan read_comparison_plan(const std::filesystem::path& file);

/// The same from text; `folder` is where camera files are looked for, `name` stands for the file in messages.
ComparisonPlan parse_comparison_plan(const std::string& text, const std::string& name,
                                     const std::filesystem::path& folder);

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
