// The figures as a table for the terminal, as CSV, and as a page.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/accuracy_score.hpp"

namespace ballservo::bench {

std::string accuracy_table(const ConditionScores& scores);  ///< the lines of one condition
std::string accuracy_table_heading();

/// One row per condition and method.
std::string accuracy_csv(const std::vector<ConditionScores>& all);
/// One row per condition, frame and method.
std::string accuracy_frames_csv(const std::vector<ConditionScores>& all);
/// The plots of the sweeps that ran, as the contents of an SVG file; empty where none did.
std::string accuracy_sweeps_svg(const std::vector<ConditionScores>& all);
/// `command` is what makes these figures again.
std::string accuracy_report_html(const std::vector<ConditionScores>& all, const std::string& command);

}  // namespace ballservo::bench
