// The claims of accuracy_bench as properties, on few frames and a seed of their own.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/bench/accuracy_score.hpp"

namespace ballservo::bench {
namespace {

MethodSummary measured(const std::string& name, AccuracyMethod method) {
  static std::vector<ConditionScores> known;
  const auto is_it = [&](const ConditionScores& scores) { return scores.condition->name == name; };
  auto place = std::find_if(known.begin(), known.end(), is_it);
  if (place == known.end()) {
    const auto& conditions = accuracy_conditions();
    const auto condition = std::find_if(conditions.begin(), conditions.end(),
                                        [&](const AccuracyCondition& c) { return c.name == name; });
    known.push_back(score_condition(*condition, 41, 40, [] {}));
    place = known.end() - 1;
  }
  return summarize(*place, method);
}

class UnderCondition : public testing::TestWithParam<const char*> {};

TEST_P(UnderCondition, FindsNoLessThanThePeers) {
  const int ours = measured(GetParam(), AccuracyMethod::sphere).found;
  EXPECT_GE(ours, measured(GetParam(), AccuracyMethod::hough_gradient).found);
  EXPECT_GE(ours, measured(GetParam(), AccuracyMethod::hsv_contour).found);
}

TEST_P(UnderCondition, TheCovarianceIsTrue) {
  const MethodSummary ours = measured(GetParam(), AccuracyMethod::sphere);
  EXPECT_GT(ours.mean_nees, 1);
  EXPECT_LT(ours.mean_nees, 6);
  EXPECT_GT(ours.within_95, 0.85);
}

TEST_P(UnderCondition, FewThingsAreTakenForBalls) {
  const MethodSummary ours = measured(GetParam(), AccuracyMethod::sphere);
  EXPECT_LE(ours.false_balls, ours.frames / 5);  // of four things of its colour in each frame
}

INSTANTIATE_TEST_SUITE_P(Conditions, UnderCondition,
                         testing::Values("base", "occluded_60", "touching_bar", "border_cut", "axis_28",
                                         "paint_marbled"));

}  // namespace
}  // namespace ballservo::bench
