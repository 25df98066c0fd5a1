// What data/comparisons/accuracy.yaml shows of the whole detectors, as properties, on few frames and a seed
// of their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "app/comparison/comparison_statistics.hpp"
#include "app/comparison/pictures/plan_pictures.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

constexpr int frames = 40;

const ComparisonPlan& plan() {
  static const ComparisonPlan shipped = [] {
    ComparisonPlan read = read_comparison_plan(test::project_data_dir() / "comparisons" / "accuracy.yaml");
    read.seed = 41;
    return read;
  }();
  return shipped;
}

Figures measured(const std::string& name, const std::string& method) {
  static std::map<std::string, ConditionSummary> known;
  if (known.count(name) == 0) {
    const auto condition = std::find_if(plan().conditions.begin(), plan().conditions.end(),
                                        [&](const ComparisonCondition& c) { return c.name == name; });
    const auto c = static_cast<std::size_t>(condition - plan().conditions.begin());
    PlanPictures source(plan());
    std::vector<char> needed(plan().conditions.size(), 0);
    needed[c] = 1;
    source.prepare(needed);
    ConditionStatistics statistics(name, plan().methods, plan().seed);
    for (int k = 0; k < frames; ++k) statistics.add(measure(source.picture(c, k), plan().methods));
    known.emplace(name, statistics.summary());
  }
  return known.at(name).methods[*place_of(plan().methods, method)];
}

class UnderCondition : public testing::TestWithParam<const char*> {};

TEST_P(UnderCondition, FindsNoLessThanThePeers) {
  const int ours = measured(GetParam(), "detect_sphere")["found"];
  EXPECT_GE(ours, measured(GetParam(), "detect_hough_gradient")["found"]);
  EXPECT_GE(ours, measured(GetParam(), "detect_hsv_contour")["found"]);
}

TEST_P(UnderCondition, TheCovarianceIsTrue) {
  const Figures ours = measured(GetParam(), "detect_sphere");
  EXPECT_GT(ours["nees_mean"], 1);
  EXPECT_LT(ours["nees_mean"], 6);
  EXPECT_GT(ours["inside_95"], 0.85);
}

TEST_P(UnderCondition, FewThingsAreTakenForBalls) {
  const Figures ours = measured(GetParam(), "detect_sphere");
  EXPECT_EQ(ours["frames"], frames);
  EXPECT_LE(ours["false_balls"], frames / 5);  // of four things of its colour in each frame
}

INSTANTIATE_TEST_SUITE_P(Conditions, UnderCondition,
                         testing::Values("base", "occluded_60", "touching_bar", "border_cut", "axis_28",
                                         "paint_marbled"));

}  // namespace
}  // namespace ballservo
