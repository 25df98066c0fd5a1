// What the page of one closed-loop run is drawn from, beside log.csv and summary.json.
#pragma once

#include <nlohmann/json.hpp>

#include "app/experiment/outcome_judge.hpp"
#include "app/experiment/run_record.hpp"
#include "app/scenario/scenario.hpp"
#include "calibration/base/output.hpp"

namespace ballservo {

/// Writes the key frames' pictures into the folder, and returns the contents of report.json: the floor, the
/// ball's way over it and through the picture.
nlohmann::ordered_json run_report(const RunRecord& record, const Scenario& scenario,
                                  const std::string& perception, const ReachedRule& rule,
                                  const OutputFolder& folder);

/// Whether a run wrote a file of that name for its page: a later run in the same folder removes it.
bool is_run_picture(const std::string& name);

}  // namespace ballservo
