// A run's folder: log.csv, tracks.csv, summary.json, manifest.json, and what its page is drawn from.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/experiment/outcome_judge.hpp"
#include "app/experiment/run_record.hpp"
#include "app/scenario/scenario.hpp"
#include "calibration/base/output.hpp"

namespace ballservo {

/// One row a control step, in simulated time; numbers round-trip, what is not known stays empty.
std::string log_csv(const std::vector<StepRecord>& steps);

/// The keys of the contract in its order, more after them; NaN as null. Wall-clock figures stand under
/// `timing` alone.
nlohmann::ordered_json summary_json(const RunSummary& summary, const RunTiming& timing);

/// Writes log.csv, tracks.csv, summary.json and manifest.json.
///   peer   what somebody else had: robot, controller; empty: neither
void write_run(const OutputFolder& folder, const RunRecord& run, const Scenario& scenario,
               const std::string& perception, const std::string& peer = "");

/// Writes the key frames' pictures into the folder, and returns the contents of report.json: the floor, the
/// ball's way over it and through the picture.
nlohmann::ordered_json run_report(const RunRecord& record, const Scenario& scenario,
                                  const std::string& perception, const OutputFolder& folder);

/// [[x, y], ...]
nlohmann::ordered_json points_json(const std::vector<Eigen::Vector2d>& points);

/// A word as a shell takes it.
std::string quoted(const std::string& word);
/// The command line of a run.
std::string servo_command(const std::string& scenario, const std::string& output, std::uint64_t seed,
                          const std::string& perception, const std::vector<std::string>& sets);

/// Whether a run wrote a file of that name for its page: a later run in the same folder removes it.
bool is_run_picture(const std::string& name);

}  // namespace ballservo
