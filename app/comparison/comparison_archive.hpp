// What a comparison is about: comparison.json, the same in every part, from which `compare merge` goes on.
#pragma once

#include <string>
#include <vector>

#include "app/comparison/comparison.hpp"

namespace ballservo {

/// What a report says beside the figures.
struct ComparisonReportText {
  std::string subject;  ///< "basic.yaml", "pictures/"
  std::string setting;  ///< the plan or the options, as they were read
  bool rendered = true;
  bool claims_wanted = false;  ///< the paper's claims are to be looked at one by one
};

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
