// Sweeps of several scenarios, or of one with different values of its keys, over the same seeds: a grid, a
// sweep a cell.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/sweep/sweep.hpp"

namespace ballservo {

/// The sweeps to be run, and the job that they are together.
struct SweepPlan {
  std::vector<SweepWork> works;
  nlohmann::json description;
};

/// A scenario is a sweep. `--vary KEY=V1,V2,...` makes a grid of it, the last key's values changing fastest;
/// so does a suite, a file that names scenarios, which change slowest. Commas within brackets, braces and
/// quotes belong to a value. Throws InputError with every fault of every cell, each named at its `--vary`.
SweepPlan plan_sweeps(const SweepOptions& options, const std::vector<std::string>& vary);

bool is_grid(const nlohmann::json& description);
/// The jobs of its cells; of a sweep alone, itself.
std::vector<nlohmann::json> cell_descriptions(const nlohmann::json& description);

/// grid.csv: a cell a row.
std::string grid_csv(const nlohmann::json& description, const std::vector<Sweep>& cells);
/// trials.csv of all cells.
std::string grid_trials_csv(const std::vector<Sweep>& cells);
/// summary.json: a sweep's keys over all cells, then each cell's own with its values.
nlohmann::ordered_json grid_summary_json(const nlohmann::json& description, const std::vector<Sweep>& cells,
                                         const Shard& shard, bool interrupted);
/// A cell a line, for people: counts, intervals, times, and what failed most.
std::string grid_table(const nlohmann::ordered_json& summary);
/// What the page says beside the summary.
nlohmann::ordered_json grid_report(const nlohmann::json& description);

}  // namespace ballservo
