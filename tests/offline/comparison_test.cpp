#include "app/offline/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "app/offline/comparison_report.hpp"
#include "app/offline/comparison_statistics.hpp"
#include "app/offline/rendered_frame.hpp"
#include "tests/report/markup_check.hpp"

namespace ballservo {
namespace {

const char* const tiny_plan =
    "seed: 3\nframes: 3\n"
    "defaults: {camera: {focal_px: 400, width_px: 320, height_px: 240}, noise: {read: 2}, blur_px: 0.7, "
    "depth_m: 0.6}\n"
    "conditions: [{name: base}, {name: hidden, occlusion: 0.3}, {name: aside, off_axis_rad: 0.2}]\n";

const Comparison& tiny(int threads) {
  static const ComparisonPlan plan = parse_comparison_plan(tiny_plan, "tiny.yaml", ".");
  static const Comparison one = run_comparison(plan, 1, [](long) {});
  static const Comparison two = run_comparison(plan, 2, [](long) {});
  return threads == 1 ? one : two;
}

TEST(Quantile, Interpolates) {
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 0.5), 2.5);
  EXPECT_EQ(quantile({0, 10}, 0.9), 9);
  EXPECT_EQ(quantile({7}, 0.1), 7);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

// A frame whose ball stands at (0.3, 0.4, 1) m and one answer that is off by known amounts.
ConditionResult known_errors() {
  ConditionResult condition;
  condition.name = "known";
  for (int k = 0; k < 2; ++k) {
    ComparisonFrame frame;
    frame.truth.p_CB = {0.3, 0.4, 1};
    frame.truth.outline = OutlineEllipse{{100, 100}, 30};
    MethodFit fit;
    fit.outline = {{103, 104}, 31};
    fit.p_C = frame.truth.p_CB + Eigen::Vector3d(0.0006, 0.0008, -0.002);  // 1 mm outward, 2 mm nearer
    frame.fits = {fit, {}};
    condition.frames.push_back(frame);
  }
  condition.frames[1].fits[0]->outline.center_px.x() = 200;  // locked onto something else
  return condition;
}

TEST(MethodStatistics, StateKnownErrors) {
  const MethodStatistics s = method_statistics(known_errors(), 0);
  EXPECT_EQ(s.frames, 2);
  EXPECT_EQ(s.found, 1);
  EXPECT_EQ(s.failed, 1);
  EXPECT_DOUBLE_EQ(s.center_rms_px, 5);
  EXPECT_DOUBLE_EQ(s.radius_bias_px, 1);
  EXPECT_NEAR(s.depth_bias_mm, -2, 1e-9);
  EXPECT_NEAR(s.lateral_bias_mm, 1, 1e-9);
  EXPECT_NEAR(s.position_median_mm, std::sqrt(5), 1e-9);
  const MethodStatistics none = method_statistics(known_errors(), 1);
  EXPECT_EQ(none.found, 0);
  EXPECT_TRUE(std::isnan(none.center_rms_px));
}

TEST(ComparisonTables, LeaveUnknownCellsEmpty) {
  Comparison comparison;
  comparison.methods = {FitMethod::vote, FitMethod::paper_one_step};
  comparison.conditions = {known_errors()};
  EXPECT_NE(compare_csv(comparison).find("known,paper_one_step,2,0,2,,,,,,,,\n"), std::string::npos);
  EXPECT_NE(fits_csv(comparison).find("known,rendered,0,paper_one_step,0,,,,,,,,\n"), std::string::npos);
  EXPECT_NE(fits_csv(comparison).find("known,rendered,1,vote,0,200,104,31"), std::string::npos);
}

TEST(RenderedFrame, HidesThePartThatTheConditionAsksFor) {
  ComparisonCondition condition;
  condition.name = "hidden";
  for (const double occlusion : {0.0, 0.3, 0.6}) {
    condition.occlusion = occlusion;
    for (int frame = 0; frame < 3; ++frame) {
      const RenderedFrame rendered = render_comparison_frame(condition, 1, frame);
      EXPECT_NEAR(rendered.truth.visible_fraction, 1 - occlusion, 0.02);
    }
  }
}

TEST(RenderedFrame, StandsWhereTheConditionSays) {
  ComparisonCondition condition;
  condition.name = "aside";
  condition.off_axis_rad = 0.2;
  for (int frame = 0; frame < 5; ++frame) {
    const Eigen::Vector3d p = render_comparison_frame(condition, 1, frame).truth.p_CB;
    EXPECT_NEAR(std::atan2(p.head<2>().norm(), p.z()), 0.2, 0.004);
    EXPECT_NEAR(p.z(), 1, 0.021);
  }
}

TEST(Comparison, FindsTheBallAndPlacesIt) {
  const Comparison& comparison = tiny(1);
  for (const ConditionResult& condition : comparison.conditions) {
    for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
      const MethodStatistics s = method_statistics(condition, m);
      EXPECT_EQ(s.found, s.frames) << condition.name << " " << fit_method_name(comparison.methods[m]);
      // The votes of a partly hidden ball, and the circle refined from them, may be a few pixels off.
      if (condition.name != "hidden") {
        EXPECT_LT(s.center_rms_px, 1.5) << condition.name << " " << fit_method_name(comparison.methods[m]);
      }
    }
  }
}

TEST(Comparison, OneStepIsNearTheConvergedFit) {
  for (const MethodPair& pair : one_step_pairs(tiny(1).methods)) {
    PairDifferences all;
    for (const ConditionResult& condition : tiny(1).conditions)
      all.add(pair_differences(tiny(1), condition, pair));
    EXPECT_EQ(all.statistics().frames, 9);
    EXPECT_LT(all.statistics().center_median_px, 0.05) << fit_method_name(pair.a);
  }
}

TEST(Comparison, IsTheSameAtOneAndTwoThreads) {
  EXPECT_EQ(compare_csv(tiny(1)), compare_csv(tiny(2)));
  EXPECT_EQ(fits_csv(tiny(1)), fits_csv(tiny(2)));
  EXPECT_EQ(pairs_csv(tiny(1)), pairs_csv(tiny(2)));
}

TEST(Comparison, ReportIsAWholePageThatLoadsNothing) {
  const ComparisonPlan plan = parse_comparison_plan(tiny_plan, "tiny.yaml", ".");
  const std::string html = comparison_report_html(tiny(1), plan, "<tiny>.yaml");
  EXPECT_EQ(test::markup_fault(html), "");
  EXPECT_EQ(html.find("http"), std::string::npos);
  EXPECT_NE(html.find("&lt;tiny&gt;"), std::string::npos);
}

TEST(Comparison, EndsWhenItIsToldTo) {
  struct Stop {};
  const ComparisonPlan plan = parse_comparison_plan(tiny_plan, "tiny.yaml", ".");
  EXPECT_THROW(run_comparison(plan, 2,
                              [](long done) {
                                if (done == 2) throw Stop();
                              }),
               Stop);
}

}  // namespace
}  // namespace ballservo
