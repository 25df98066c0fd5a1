// What a part of a comparison hands to `compare merge`: its conditions, methods and notes, as text.
#pragma once

#include <string>
#include <vector>

#include "app/comparison/comparison.hpp"
#include "app/comparison/comparison_report.hpp"

namespace ballservo {

/// Names the conditions, methods and settings of a run: comparison.json, the same in every part.
std::string comparison_setting_text(const std::vector<ConditionInfo>& conditions, const MethodList& methods,
                                    std::uint64_t seed, const ComparisonReportText& text);

struct ComparisonSetting {
  std::vector<ConditionInfo> conditions;
  MethodList methods;
  std::uint64_t seed = 0;
  ComparisonReportText text;
};
/// Throws InputError naming `place` for anything else than comparison_setting_text writes.
ComparisonSetting read_comparison_setting(const std::string& text, const std::string& place);

}  // namespace ballservo
