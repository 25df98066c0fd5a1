// A run's folder: log.csv and summary.json (manifest.json is the command's, tracks.csv is written as the run
// goes).
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/experiment/run_record.hpp"

namespace ballservo {

/// One row a control step, in simulated time; numbers round-trip, what is not known stays empty.
std::string log_csv(const std::vector<StepRecord>& steps);

/// The keys of the contract in its order, more after them; NaN as null. Wall-clock figures stand under
/// `timing` alone.
nlohmann::ordered_json summary_json(const RunSummary& summary, const RunTiming& timing);

}  // namespace ballservo
