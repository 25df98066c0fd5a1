// What a comparison is about: comparison.json, the same in every part, from which `compare merge` goes on.
#pragma once

#include <string>
#include <vector>

#include "app/comparison/comparison.hpp"
#include "app/comparison/comparison_report.hpp"

namespace ballservo {

struct ComparisonSetting {
  std::vector<ConditionInfo> conditions;
  MethodList methods;
  std::uint64_t seed = 0;
  ComparisonReportText text;
};

std::string comparison_setting_text(const ComparisonSetting& setting);
/// Throws InputError naming `place` for anything else than comparison_setting_text writes.
ComparisonSetting read_comparison_setting(const std::string& text, const std::string& place);

}  // namespace ballservo
