#include "app/offline/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "calibration/files/fault.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

std::vector<Fault> faults_of(const std::string& text) {
  try {
    parse_comparison_plan(text, "plan.yaml", ".");
  } catch (const InputError& error) {
    return error.faults();
  }
  return {};
}

bool any_at(const std::vector<Fault>& faults, const std::string& part) {
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
  EXPECT_EQ(plan.methods, (std::vector<FitMethod>{FitMethod::vote, FitMethod::sphere_one_step}));
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
  EXPECT_EQ(plan.methods.size(), all_fit_methods.size());
}

TEST(ComparisonPlan, SaysEveryFaultAtOnce) {
  const std::vector<Fault> faults = faults_of(
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
    EXPECT_TRUE(any_at(faults, part)) << part;
  }
  EXPECT_GE(faults.size(), 13u);
  for (const Fault& fault : faults) {
    EXPECT_EQ(fault.place.rfind("plan.yaml", 0), 0u) << fault.place;
    EXPECT_FALSE(fault.allowed.empty());
  }
}

TEST(ComparisonPlan, RefusesWhatCannotBeRendered) {
  EXPECT_TRUE(any_at(faults_of("conditions: [{name: a, depth_m: 0.03}]"), "conditions"));
  EXPECT_TRUE(any_at(faults_of("conditions: [{name: a, off_axis_rad: 0.5}]"), "conditions"));
  EXPECT_TRUE(any_at(faults_of("conditions: [{name: a, ball: {diameter_m: 1.5}}]"), "conditions"));
  EXPECT_TRUE(faults_of("conditions: [{name: a, off_axis_rad: 0.5, camera: {focal_px: 500}}]").empty());
}

TEST(ComparisonPlan, RefusesNothingToCompare) {
  EXPECT_FALSE(faults_of("").empty());
  EXPECT_FALSE(faults_of("frames: 3").empty());
  EXPECT_FALSE(faults_of("conditions: []").empty());
  EXPECT_FALSE(faults_of("conditions: {name: a}").empty());
  EXPECT_FALSE(faults_of("conditions: [{name: a, camera: {file: missing.yaml}}]").empty());
}

TEST(ComparisonPlan, TheBasicOneHoldsItsConditions) {
  const ComparisonPlan plan = read_comparison_plan(test::project_data_dir() / "comparisons" / "basic.yaml");
  std::vector<std::string> names;
  for (const ComparisonCondition& condition : plan.conditions) names.push_back(condition.name);
  EXPECT_EQ(names, (std::vector<std::string>{"base", "sigma_10", "blur_1_5", "occluded_30", "at_2_m",
                                             "axis_0_deg", "axis_15_deg", "axis_28_deg"}));
  EXPECT_EQ(plan.methods.size(), all_fit_methods.size());
}

}  // namespace
}  // namespace ballservo
