#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/comparison/pictures/plan.hpp"
#include "calibration/base/system_file.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/option_keys.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* small_plan = "frames: 1\nconditions: [{name: a}]\n";

std::string plan_fault_lines(const std::string& text) {
  return "\n" + test::fault_lines([&] { parse_comparison_plan(text, "plan.yaml", "."); });
}

bool is_varied(const OptionRow& row) { return row.path.rfind("design.vary.", 0) == 0; }

TEST(PlanKeys, HoldEveryKeyOfTheProjectsPlans) {
  std::set<std::string> known, used;
  for (const OptionRow& row : plan_keys()) {
    EXPECT_TRUE(known.insert(row.path).second || !row.conditions.empty()) << row.path << " is listed twice";
    EXPECT_FALSE(row.help.empty()) << row.path;
  }
  for (const auto& entry : std::filesystem::directory_iterator(test::project_data_dir() / "comparisons")) {
    auto document = nlohmann::json::parse(StrictYaml::from_file(entry.path()).resolved_json());
    if (document.contains("design")) {
      for (const auto& [key, values] : document["design"]["vary"].items())
        EXPECT_TRUE(known.count("conditions[]." + key)) << key;
      document["design"].erase("vary");
    }
    test::add_paths(document, "", used);
  }
  EXPECT_GT(used.size(), 25u);
  for (const std::string& path : used) EXPECT_TRUE(known.count(path)) << path;
}

TEST(PlanKeys, EachDefaultIsAccepted) {
  int tried = 0;
  for (const OptionRow& row : plan_keys()) {
    if (!test::has_default(row)) continue;
    ++tried;
    EXPECT_THAT(plan_fault_lines(test::with_value(small_plan, row, row.fallback)),
                Not(HasSubstr(": " + test::of_first_item(row.path) + ":")));
  }
  EXPECT_GT(tried, 40);
}

TEST(PlanKeys, WhatIsOutsideIsRefusedWithItsPlace) {
  for (const OptionRow& row : plan_keys()) {
    if (is_varied(row)) continue;
    for (const std::string& value : test::values_outside(row)) {
      EXPECT_THAT(plan_fault_lines(test::with_value(small_plan, row, value)),
                  HasSubstr("plan.yaml:1: " + test::of_first_item(row.path) + ": found "))
          << value;
    }
  }
}

TEST(PlanKeys, TheReferencePageIsWhatTheProgramSays) {
  const auto page = test::project_data_dir().parent_path() / "app" / "comparison" / "KEYS.md";
  EXPECT_EQ(read_file_bytes(page, 1u << 20), option_page("plan", plan_keys()))
      << "ballservo compare --keys > app/comparison/KEYS.md";
}

}  // namespace
}  // namespace ballservo
