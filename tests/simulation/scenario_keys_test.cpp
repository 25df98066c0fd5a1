#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "app/scenario/scenario.hpp"
#include "calibration/base/system_file.hpp"
#include "tests/support/option_keys.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::filesystem::path scenarios() { return test::project_data_dir() / "scenarios"; }

/// Every fault of a scenario beside static_ball.yaml, a line each.
std::string fault_lines_of(const std::string& text) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "scenario.yaml") << text;
  try {
    load_scenario(folder.path() / "scenario.yaml", {}, 0);
  } catch (const InputError& error) {
    return std::string("\n") + error.what() + "\n";
  }
  return {};
}

std::string static_ball_text() {
  auto document =
      nlohmann::json::parse(StrictYaml::from_file(scenarios() / "static_ball.yaml").resolved_json());
  document.erase("vary");  // what it draws would hide what is set
  return document.dump();
}

TEST(ScenarioKeys, HoldEveryKeyOfTheProjectsScenarios) {
  std::set<std::string> known, used;
  for (const OptionRow& row : scenario_keys()) {
    EXPECT_TRUE(known.insert(row.path).second || !row.conditions.empty()) << row.path << " is listed twice";
    EXPECT_FALSE(row.help.empty()) << row.path;
  }
  for (const auto& entry : std::filesystem::directory_iterator(scenarios())) {
    auto document = nlohmann::json::parse(StrictYaml::from_file(entry.path()).resolved_json());
    document.erase("vary");  // its keys are paths
    test::add_paths(document, "", used);
  }
  EXPECT_GT(used.size(), 60u);
  for (const std::string& path : used) EXPECT_TRUE(known.count(path)) << path;
}

TEST(ScenarioKeys, EachDefaultIsAccepted) {
  int tried = 0;
  for (const OptionRow& row : scenario_keys()) {
    if (!test::has_default(row)) continue;
    ++tried;
    EXPECT_THAT(fault_lines_of(test::with_value(static_ball_text(), row, row.fallback)),
                Not(HasSubstr(": " + test::of_first_item(row.path) + ":")));
  }
  EXPECT_GT(tried, 80);
}

TEST(ScenarioKeys, WhatIsOutsideIsRefusedWithItsPlace) {
  for (const OptionRow& row : scenario_keys()) {
    if (row.path.rfind("vary.", 0) == 0) continue;
    for (const std::string& value : test::values_outside(row)) {
      EXPECT_THAT(fault_lines_of(test::with_value(static_ball_text(), row, value)),
                  HasSubstr("scenario.yaml:1: " + test::of_first_item(row.path) + ": found "))
          << value;
    }
  }
}

TEST(ScenarioKeys, TheReferencePageIsWhatTheProgramSays) {
  const auto page = test::project_data_dir().parent_path() / "app" / "scenario" / "KEYS.md";
  EXPECT_EQ(read_file_bytes(page, 1u << 20), option_page("scenario", scenario_keys()))
      << "ballservo servo --keys > app/scenario/KEYS.md";
}

}  // namespace
}  // namespace ballservo
