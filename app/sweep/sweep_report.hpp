// What the page of a sweep is drawn from, beside trials.csv, traces.jsonl and summary.json.
#pragma once

#include <string>

#include "app/sweep/sweep_statistics.hpp"

namespace ballservo {

/// The contents of report.json: what depends on what a seed draws, and the worst trials with the commands
/// that show them again.
nlohmann::ordered_json sweep_report(const Sweep& sweep, const SweepComparison* against);

/// The command that runs one seed of a sweep again, with a film: for pasting into a shell.
std::string trial_command(const nlohmann::json& description, std::uint64_t seed);

}  // namespace ballservo
