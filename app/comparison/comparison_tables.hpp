// A comparison's CSV files (interface: "a comparison's folder"); columns of our own stand behind the
// promised ones.
#pragma once

#include <string>
#include <vector>

#include "app/comparison/comparison_statistics.hpp"
#include "app/comparison/pictures/picture_source.hpp"

namespace ballservo {

std::string compare_csv_header();
std::string compare_csv_rows(const ConditionInfo& info, const ConditionSummary& summary,
                             const MethodList& methods);
std::string pairs_csv_header();
std::string pairs_csv_rows(const ConditionInfo& info, const ConditionSummary& summary,
                           const MethodList& methods);
std::string tests_csv_header();
std::string tests_csv_rows(const ConditionInfo& info, const ConditionSummary& summary,
                           const MethodList& methods);
std::string timing_csv_header();
std::string timing_csv_rows(const ConditionInfo& info, const ConditionSummary& summary,
                            const MethodList& methods);
std::string fits_csv_header();
std::string fits_csv_rows(const ConditionInfo& info, const ComparisonRecord& record,
                          const MethodList& methods);
/// frames.csv: what is true of each frame, its bound, and its votes.
std::string frames_csv_header();
std::string frames_csv_row(const ConditionInfo& info, const ComparisonRecord& record);

}  // namespace ballservo
