#include "app/comparison/pictures/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "calibration/base/fault.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

std::vector<Fault> plan_faults(const std::string& text) {
  return test::faults_of([&] { parse_comparison_plan(text, "plan.yaml", "."); });
}

bool any_at_place(const std::vector<Fault>& faults, const std::string& part) {
  return std::any_of(faults.begin(), faults.end(),
                     [&](const Fault& fault) { return fault.place.find(part) != std::string::npos; });
}

TEST(ComparisonPlan, ConditionsInheritWhatTheyDoNotSay) {
  const ComparisonPlan plan = parse_comparison_plan(
      "seed: 5\nframes: 3\nmethods: [vote, sphere_one_step]\n"
      "defaults: {depth_m: 2, noise: {read: 4, shot: 0.5}, ball: {color: green, diameter_m: 0.1}}\n"
      "conditions:\n- {name: plain}\n- {name: other, noise: {read: 1}, frames: 7, ball: {color: blue}}\n",
      "plan.yaml", ".");
  EXPECT_EQ(plan.seed, 5u);
  EXPECT_EQ(plan.methods, (MethodList{find_fit_method("vote"), find_fit_method("sphere_one_step")}));
  ASSERT_EQ(plan.conditions.size(), 2u);
  EXPECT_EQ(plan.conditions[0].frames, 3);
  EXPECT_EQ(plan.conditions[0].sensor.read_noise, 4);
  EXPECT_EQ(plan.conditions[1].frames, 7);
  EXPECT_EQ(plan.conditions[1].sensor.read_noise, 1);
  EXPECT_EQ(plan.conditions[1].sensor.shot_noise, 0.5);
  EXPECT_EQ(plan.conditions[1].ball_color, "blue");
  EXPECT_EQ(plan.conditions[1].diameter_m, 0.1);
  EXPECT_EQ(plan.conditions[1].depth_m, 2);
}

TEST(ComparisonPlan, AllMethodsWhereNoneIsNamed) {
  const ComparisonPlan plan = parse_comparison_plan("conditions: [{name: a}]", "plan.yaml", ".");
  EXPECT_EQ(plan.methods.size(), fit_methods().size());
}

TEST(ComparisonPlan, SaysEveryFaultAtOnce) {
  const std::vector<Fault> faults = plan_faults(
      "frames: 0\n"
      "methods: [vote, best, vote]\n"
      "colour: red\n"
      "conditions:\n"
      "- {name: a, depth_m: -1, noise: {red: 2}}\n"
      "- {name: a, blur_px: .nan}\n"
      "- {name: 'Not a name', occlusion: 1.5, ball: {color: plaid, diameter_m: 0}}\n"
      "- {camera: {focal_px: 0, width_px: 1}}\n");
  for (const std::string part : {"frames", "methods", "colour", "depth_m", "red", "name", "blur_px",
                                 "occlusion", "color", "diameter_m", "focal_px", "width_px"}) {
    EXPECT_TRUE(any_at_place(faults, part)) << part;
  }
  EXPECT_GE(faults.size(), 13u);
  for (const Fault& fault : faults) {
    EXPECT_EQ(fault.place.rfind("plan.yaml", 0), 0u) << fault.place;
    EXPECT_FALSE(fault.allowed.empty());
  }
}

TEST(ComparisonPlan, RefusesWhatCannotBeRendered) {
  EXPECT_TRUE(any_at_place(plan_faults("conditions: [{name: a, depth_m: 0.03}]"), "conditions"));
  EXPECT_TRUE(any_at_place(plan_faults("conditions: [{name: a, off_axis_rad: 0.5}]"), "conditions"));
  EXPECT_TRUE(any_at_place(plan_faults("conditions: [{name: a, ball: {diameter_m: 1.5}}]"), "conditions"));
  EXPECT_TRUE(plan_faults("conditions: [{name: a, off_axis_rad: 0.5, camera: {focal_px: 500}}]").empty());
}

TEST(ComparisonPlan, RefusesNothingToCompare) {
  EXPECT_FALSE(plan_faults("").empty());
  EXPECT_FALSE(plan_faults("frames: 3").empty());
  EXPECT_FALSE(plan_faults("conditions: []").empty());
  EXPECT_FALSE(plan_faults("conditions: {name: a}").empty());
  EXPECT_FALSE(plan_faults("conditions: [{name: a, camera: {file: missing.yaml}}]").empty());
}

TEST(ComparisonPlan, ReadsEveryNumberThatDesignsVary) {
  const ComparisonPlan plan = parse_comparison_plan(
      "conditions:\n- {name: a, occlusion: 0.4, occlusion_side: left, motion_blur_px: 3, light: {level: 0.5, "
      "angle_rad: 1}, contrast: 0.3, ring_clutter: 5, same_color: 2, touching: true, start: {center_px: 2}, "
      "resolution: 0.5, gain: 2, ball: {pattern: checks}, camera: {focal_px: 900, model: brown, "
      "coefficients: [-0.2, 0.05, 0, 0, 0]}}\n",
      "plan.yaml", ".");
  const ComparisonCondition& c = plan.conditions[0];
  EXPECT_EQ(c.occlusion, 0.4);
  EXPECT_EQ(c.occlusion_side, OcclusionSide::left);
  EXPECT_EQ(c.motion_blur_px, 3);
  EXPECT_EQ(c.light_level, 0.5);
  EXPECT_EQ(c.light_angle_rad, 1);
  EXPECT_EQ(c.contrast, 0.3);
  EXPECT_EQ(c.ring_clutter, 5);
  EXPECT_EQ(c.same_color, 2);
  EXPECT_TRUE(c.touching);
  ASSERT_TRUE(c.start);
  EXPECT_EQ(c.start->center_px, 2);
  EXPECT_EQ(c.ball_pattern, Pattern::checks);
  EXPECT_EQ(c.camera.size().width_px, 320);
  EXPECT_EQ(c.camera.focal_px(), 450);
  EXPECT_EQ(c.camera.parameters().model, LensModel::brown);
}

TEST(ComparisonPlan, DesignsMakeConditions) {
  const ComparisonPlan one = parse_comparison_plan(
      "defaults: {blur_px: 0.7}\ndesign: {type: one_at_a_time, vary: {depth_m: [0.5, 2], noise.read: [4]}}\n",
      "plan.yaml", ".");
  ASSERT_EQ(one.conditions.size(), 3u);
  EXPECT_EQ(one.conditions[0].name, "depth_m_0_5");
  EXPECT_EQ(one.conditions[0].depth_m, 0.5);
  EXPECT_EQ(one.conditions[2].name, "noise_read_4");
  EXPECT_EQ(one.conditions[2].sensor.read_noise, 4);
  EXPECT_EQ(one.conditions[2].depth_m, 1);
  const ComparisonPlan grid = parse_comparison_plan(
      "design: {type: grid, vary: {depth_m: [0.5, 1, 2], occlusion: [0, 0.3]}}\n", "plan.yaml", ".");
  ASSERT_EQ(grid.conditions.size(), 6u);
  EXPECT_EQ(grid.conditions[5].depth_m, 2);
  EXPECT_EQ(grid.conditions[5].occlusion, 0.3);
  const char* random = "design: {type: random, conditions: 8, vary: {depth_m: {log_uniform: [0.5, 2]}}}\n";
  const ComparisonPlan drawn = parse_comparison_plan(random, "plan.yaml", ".");
  const ComparisonPlan again = parse_comparison_plan(random, "plan.yaml", ".");
  ASSERT_EQ(drawn.conditions.size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_GE(drawn.conditions[k].depth_m, 0.5);
    EXPECT_LE(drawn.conditions[k].depth_m, 2);
    EXPECT_EQ(drawn.conditions[k].depth_m, again.conditions[k].depth_m);
  }
  EXPECT_NE(drawn.conditions[0].depth_m, drawn.conditions[1].depth_m);
}

TEST(ComparisonPlan, SaysWhatIsWrongWithADesign) {
  const std::vector<Fault> faults = plan_faults(
      "design: {type: spiral, vary: {depth_m: [], colour: [1], blur_px: [99], noise.read: {uniform: [1, "
      "2]}}}\n");
  for (const std::string part : {"type", "depth_m", "colour", "blur_px", "noise.read"})
    EXPECT_TRUE(any_at_place(faults, part)) << part;
  EXPECT_FALSE(
      plan_faults("design: {type: random, conditions: 3, vary: {depth_m: {uniform: [2, 1]}}}\n").empty());
  EXPECT_FALSE(plan_faults("design: {type: grid, vary: {}}\n").empty());
  EXPECT_FALSE(plan_faults("conditions: [{name: a, calibration_sigmas: 1}]").empty());  // no covariance
}

TEST(ComparisonPlan, EstimatesWhatItTakes) {
  const ComparisonPlan plan =
      parse_comparison_plan("frames: 1000000000\nconditions: [{name: a}]", "plan.yaml", ".");
  const PlanEstimate whole = estimate(plan);
  EXPECT_EQ(whole.frames, 1e9);
  EXPECT_GT(whole.core_hours, 1e4);
  EXPECT_GT(whole.disk_bytes, 1e12);
  EXPECT_NE(in_words(whole, 2).find("days"), std::string::npos);
}

TEST(ComparisonPlan, TheBasicOneHoldsItsConditions) {
  const ComparisonPlan plan = read_comparison_plan(test::project_data_dir() / "comparisons" / "basic.yaml");
  std::vector<std::string> names;
  for (const ComparisonCondition& condition : plan.conditions) names.push_back(condition.name);
  EXPECT_EQ(names, (std::vector<std::string>{"base", "sigma_10", "blur_1_5", "occluded_30", "at_2_m",
                                             "axis_0_deg", "axis_15_deg", "axis_28_deg"}));
  EXPECT_EQ(plan.methods.size(), 5u);
}

TEST(ComparisonPlan, EveryPlanThatIsShippedCanBeRead) {
  for (const char* name :
       {"basic.yaml", "paper.yaml", "full.yaml", "accuracy.yaml", "accuracy_sweeps.yaml"}) {
    const ComparisonPlan plan = read_comparison_plan(test::project_data_dir() / "comparisons" / name);
    EXPECT_FALSE(plan.conditions.empty());
    EXPECT_EQ(plan.paper_claims, std::string(name) == "paper.yaml" || std::string(name) == "full.yaml");
  }
}

}  // namespace
}  // namespace ballservo
