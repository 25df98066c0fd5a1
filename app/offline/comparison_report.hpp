// A comparison told in plain words: tables, plots, an example of every condition.
#pragma once

#include <string>

#include "app/offline/comparison.hpp"

namespace ballservo {

/// report.html of a comparison. `plan_name` is the plan file's name. Holds no times: they are in timing.csv.
std::string comparison_report_html(const Comparison& comparison, const ComparisonPlan& plan,
                                   const std::string& plan_name);

}  // namespace ballservo
