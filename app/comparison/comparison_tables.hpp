// A comparison's CSV files (interface: "a comparison's folder") and its summary as JSON. Columns of our own
// stand behind the promised ones.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "app/comparison/comparison.hpp"

namespace ballservo {

using RowsByFile = std::map<std::string, std::string>;

/// The headings of all files that have rows by condition or by frame.
RowsByFile comparison_headings();
/// compare.csv, pairs.csv, tests.csv, and timing.csv, which differs from run to run.
RowsByFile condition_rows(const ConditionInfo& info, const ConditionSummary& summary,
                          const MethodList& methods);
/// fits.csv: what each method said; frames.csv: what is true of the frame, its bound, and its votes.
RowsByFile frame_rows(const ConditionInfo& info, const ComparisonRecord& record, const MethodList& methods);

/// {"conditions": {NAME: {METHOD: figures}}, "pairs": [...], "certificates": [...]}; no times.
nlohmann::json comparison_json(const ComparisonResults& results);

}  // namespace ballservo
