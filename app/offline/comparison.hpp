// Every estimator on the same pixels: renders a plan's conditions and runs its methods on each frame.
#pragma once

#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/offline/plan.hpp"
#include "servo/simulation/truth.hpp"

namespace ballservo {

/// One frame's truth and what each method of the plan said of it.
struct ComparisonFrame {
  BallTruth truth;
  std::vector<std::optional<MethodFit>> fits;
};

struct ConditionResult {
  std::string name;
  std::vector<ComparisonFrame> frames;
  cv::Mat example;  ///< the first frame's picture
};

struct Comparison {
  std::vector<FitMethod> methods;
  std::vector<ConditionResult> conditions;
};

/// Whether an answer is at the ball at all: its centre within half the true radius of the true centre. A
/// detector that locked onto something else has not found the ball, however well it fits that.
bool at_the_ball(const MethodFit& fit, const BallTruth& truth);

/// Runs the plan on `threads` threads (0: as many as the machine has); the same result at any number, times
/// apart. Each ball colour is learnt, as a user would, from teaching pictures rendered for it. `progress` is
/// told how many frames are done, from one thread at a time, and ends the work by throwing. Throws Refusal
/// where a colour cannot be learnt.
Comparison run_comparison(const ComparisonPlan& plan, int threads,
                          const std::function<void(long done)>& progress);

}  // namespace ballservo
