// Pictures without a ball, in which things of a ball's colour lie so that a circle fits them in part.
#include <gtest/gtest.h>

#include <algorithm>

#include "app/comparison/pictures/plan_pictures.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

// Each of these frames showed a ball while a doubtful one's outline counted for nothing in its second look.
TEST(FalseBalls, AreNotMadeOfOvalsAndCutDiscsThatMeetACircleHereAndThere) {
  ComparisonPlan plan = read_comparison_plan(test::project_data_dir() / "comparisons" / "accuracy.yaml");
  plan.seed = 77;
  const auto clutter =
      std::find_if(plan.conditions.begin(), plan.conditions.end(),
                   [](const ComparisonCondition& condition) { return condition.name == "paint_clutter"; });
  const auto at = static_cast<std::size_t>(clutter - plan.conditions.begin());
  std::vector<char> needed(plan.conditions.size(), 0);
  needed.at(at) = 1;
  PlanPictures pictures(plan);
  pictures.prepare(needed);
  std::size_t balls = 0;
  for (const int frame : {344, 432, 478, 671, 786, 973}) {
    const ComparisonPicture picture = pictures.picture(at, frame);
    Detector detector(picture.detector.rays, picture.detector.colors, picture.detector.options);
    balls += detector.detect(picture.bgr).size();
  }
  EXPECT_LE(balls, 1u);
}

}  // namespace
}  // namespace ballservo
